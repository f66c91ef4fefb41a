"""Iteration of the choice of parts and the masses of the links, until the parts no longer change.

A round draws the joints of the chosen parts, computes their masses, adds them to the links and chooses again: the fit
to the wanted motion and every simulated leg use these links. The iteration ends when the choice is the one that the
links carry. A spring to wind keeps its wire diameter from round to round if possible; otherwise two neighbouring sizes
could alternate for ever. The first round starts from each joint's best single parts and does not evaluate substitutes,
which halves its cost.

Heavy links may ask for parts that leave them light, and light ones for heavy parts. Once the links of a round turn back
towards those of the round before, each further round begins midway between its last links and those that its parts
give. Where the parts of two rounds give the same links, the next begins with these. Where no round settles, the best
is taken, each with its own parts' masses.

Masses here are those of facets (``cad.facets``), within 1e-5 of the solids that are drawn at the end; what is reported
is the masses of those solids. Joints whose dimensions did not change are not weighed again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import TYPE_CHECKING, Any

from synth.design.choice_rounds import LastChoice, Stage, built_free_angles
from synth.design.drawn_springs import draw_up, simulate_built_leg
from synth.design.judged_sets import Judge
from synth.design.leg_design import (
    Effort,
    KnownResults,
    LegDesign,
    MassRounds,
    design_for,
    known_beforehand,
    with_report_figures,
)
from synth.design.link_masses import (
    SAME_LINK,
    BuiltLink,
    built_links,
    link_warnings,
    midway_links,
    same_links,
    turns_back,
    with_links,
)
from synth.design.part_masses import PartMass, Pieces, unknown_parts
from synth.design.solid_work import joint_masses
from synth.errors import Problem, UserError
from synth.files.leg_project import LegProject
from synth.files.validate import near
from synth.parts.catalogs import Catalogue
from synth.remarks import decisive
from synth.swing.leg_model import Leg

if TYPE_CHECKING:
    from synth.cad import LegDimensions

MOST_ROUNDS = 5  # of choosing; the built-in example takes four, as its first two rounds alternate
SAME_CHOICE = 0.02  # relative, of links with the same parts: a spring to wind of one label has other coils by round
NEAR_JOINTS = 0.03  # mm, deg, N m: masses of joints this close agree to 1e-3, a fifth of the tolerance of convergence
MOST_SETTLING = 4  # drawings until free angles and masses agree; two are enough except for the last digit


def design_with_masses(project: LegProject, catalogue: Catalogue, stage: Stage) -> LegDesign:
    """The design of a leg whose links include the parts that are drawn on them.

    Raises
    ------
    UserError : as ``design_leg``, or ``cad: masses`` names an unknown part.
    cad.DimensionError : the joints of the chosen parts cannot be drawn.
    """
    from synth import cad

    known, target, scales = known_beforehand(project, stage), project.target, JointWeights(project)
    labels: tuple[object, ...] = ()
    try:
        started = design_for(project, catalogue, known, target, stage, effort="first", drawn=True)
        with stage("weighing the joints' parts"):
            target, labels = scales.on_links(draw_up(started, catalogue)), started.sets.chosen.labels
    except cad.DimensionError:
        pass  # the first parts are only a start; the chosen parts may be drawable
    return _rounds(project, catalogue, known, (target, labels), scales, stage)


def _rounds(
    project: LegProject,
    catalogue: Catalogue,
    known: KnownResults,
    start: tuple[Leg, tuple[object, ...]],
    scales: JointWeights,
    stage: Stage,
) -> LegDesign:
    """Choose parts and compute masses until the chosen parts, or nearly their masses, are those of the links."""
    target, labels = start
    before, held, alternating = project.target, LastChoice(), False
    gave: Leg | None = None  # the links that the parts of the round before give
    tried: list[tuple[LegDesign, Leg]] = []  # rounds that know the substitutes of their parts, and the links they draw
    for count in range(1, MOST_ROUNDS + 1):
        effort: Effort = "chosen" if count > 1 else "found"
        design = design_for(project, catalogue, known, target, stage, effort=effort, held=held, drawn=True)
        with stage("weighing the joints' parts"):
            carrying = scales.on_links(draw_up(design, catalogue))
        within = SAME_CHOICE if design.sets.chosen.labels == labels else SAME_LINK
        settled = count > 1 and same_links(target, carrying, within)
        if settled:
            break
        if count > 1:
            tried.append((design, carrying))
            alternating = alternating or turns_back(before, target, carrying)
        again = gave is not None and same_links(gave, carrying, SAME_CHOICE)
        before, gave, labels, held = target, carrying, design.sets.chosen.labels, _last(design)
        target = midway_links(target, carrying) if alternating and not again else carrying
    rounds = MassRounds(count, settled)
    if not settled:
        design = _best_as_drawn(tried)
    design = scales.settled(replace(design, project=project, rounds=rounds), catalogue)
    if not settled:
        design = _judged_as_drawn(design)
    design = with_report_figures(design, known.motion)
    return replace(design, warnings=(*design.warnings, *_unsettled_sentences(rounds)))


def _best_as_drawn(tried: Sequence[tuple[LegDesign, Leg]]) -> LegDesign:
    """Of rounds, each with the links that its parts give, that whose leg is expected to move nearest to the last one's
    wanted motion.
    """
    wanted = tried[-1][0].wanted

    def expected(design: LegDesign, carrying: Leg) -> float:
        project = design.project
        judge = Judge(wanted, _on_links(design.sets.leg, carrying), project.parts, project.fit.seed)
        return judge.expected(design.sets.chosen.pairs)

    return min(tried, key=lambda each: expected(*each))[0]


def _on_links(leg: Leg, other: Leg) -> Leg:
    """A leg with the links of another one."""
    joints = zip(leg.joints, other.joints, strict=True)
    return replace(leg, joints=tuple(replace(joint, link=own.link) for joint, own in joints))


def _judged_as_drawn(design: LegDesign) -> LegDesign:
    """The design with forecasts and costs of its parts on its drawn links; those of its round had other links."""
    leg = _on_links(design.sets.leg, design.built)
    judge = Judge(design.wanted, leg, design.project.parts, design.project.fit.seed)
    sets = design.sets.judged_by(judge, design.springs.chosen)
    return replace(design, sets=sets, springs=sets.springs, dampers=sets.dampers)


def _last(design: LegDesign) -> LastChoice:
    """Wire of each joint that gets one spring to wind, and free angles."""
    made = zip(design.built.joint_names, (option.design for option in design.springs.chosen), strict=True)
    wires = {name: spring.wire_diameter for name, spring in made if spring is not None and spring.count == 1}
    return LastChoice(wires, built_free_angles(design.sets.leg))


def _unsettled_sentences(rounds: MassRounds) -> list[tuple[str | None, str]]:
    if rounds.settled:
        return []
    return [
        (
            None,
            decisive(
                f"after {rounds.count} rounds the choice of parts still changes with the links' masses; of the rounds' "
                "parts those are taken that do best with their own masses. Responses and costs are those with these "
                "masses, with which other parts may be better",
                "To fix a part, name it by its part number (part) or its wire.",
            ),
        )
    ]


class JointWeights:
    """Computes the masses of a project's joints; caches them by the joints' dimensions."""

    def __init__(self, project: LegProject) -> None:
        self.project = project
        self._known: dict[str, tuple[PartMass, ...]] = {}
        self._last: tuple[LegDimensions, Mapping[str, Pieces]] | None = None

    def on_links(self, design: LegDesign) -> Leg:
        """The project's target with the drawn parts of a design on its links."""
        return with_links(self.project.target, self.links(design))

    def links(self, design: LegDesign, *, near: bool = False) -> tuple[BuiltLink, ...]:
        """The links of a drawn design.

        ``near``: reuse the last masses if the joints' dimensions differ from the last ones by at most ``NEAR_JOINTS``.

        Raises
        ------
        UserError : ``cad: masses`` names an unknown part.
        """
        assert design.drawn is not None
        dimensions, pieces = design.drawn.dimensions, pieces_of(design)
        if (
            near
            and self._last is not None
            and self._last[1] == pieces
            and same_but_for(dimensions, self._last[0], NEAR_JOINTS)
        ):
            dimensions = self._last[0]
        return links_of(design, self._masses(dimensions, pieces))

    def _masses(self, dimensions: LegDimensions, pieces: Mapping[str, Pieces]) -> tuple[PartMass, ...]:
        key = repr((dimensions, sorted(pieces.items())))
        if key not in self._known:
            self._known[key] = joint_masses(dimensions, self.project.cad.masses, pieces)
        self._last = dimensions, pieces
        return self._known[key]

    def settled(self, design: LegDesign, catalogue: Catalogue) -> LegDesign:
        """The design drawn with its own masses on its links, in the wanted rest pose.

        After the first drawing the joints change in their last digits only; the final drawing computes masses again.
        """
        design = draw_up(design, catalogue)
        for _ in range(MOST_SETTLING):
            links = self.links(design, near=True)
            leg = with_links(design.built, links)
            if same_links(leg, design.built):
                break
            carrying = design.wanted.at_rest_like_wanted(leg)
            design = draw_up(simulate_built_leg(replace(design, built=carrying)), catalogue)
        return design


def same_but_for(one: Any, other: Any, off: float) -> bool:
    """Whether two values (dimensions, tuples, text) are equal, with numbers that differ by at most ``off``."""
    if isinstance(one, float | int) and isinstance(other, float | int) and not isinstance(one, bool):
        return abs(one - other) <= off
    if isinstance(one, tuple) and isinstance(other, tuple) and len(one) == len(other):
        return all(same_but_for(a, b, off) for a, b in zip(one, other, strict=True))
    if is_dataclass(one) and type(one) is type(other):
        return all(same_but_for(getattr(one, f.name), getattr(other, f.name), off) for f in fields(one))
    return bool(one == other)


def pieces_of(design: LegDesign) -> dict[str, Pieces]:
    """Number of dampers and springs of each joint."""
    chosen = zip(design.dampers.chosen, design.springs.chosen, strict=True)
    return {
        name: Pieces(damper.arrangement.pieces, spring.number)
        for name, (damper, spring) in zip(design.built.joint_names, chosen, strict=True)
    }


def links_of(design: LegDesign, masses: Sequence[PartMass]) -> tuple[BuiltLink, ...]:
    """The project's links with these parts.

    Raises
    ------
    UserError : ``cad: masses`` names an unknown part.
    """
    project = design.project
    wrong = unknown_parts(project.cad.masses, masses)
    if wrong:
        names = sorted(item.part for item in masses)
        file = str(project.path)
        raise UserError(
            [
                Problem(f'"{name}" is not a part of these joints{near(name, names)}', file, key="cad.masses")
                for name in wrong
            ]
        )
    return built_links(project.target, masses)


def with_drawn_masses(design: LegDesign, masses: Sequence[PartMass]) -> LegDesign:
    """The design with the masses of its drawn parts on its links, its motion simulated with them, and warnings."""
    links = links_of(design, masses)
    design = replace(design, links=links)
    leg = with_links(design.built, links)
    if leg != design.built:
        design = simulate_built_leg(replace(design, built=leg))
    assumed = {item.part: item.basis for item in masses if item.assumed}
    return replace(design, warnings=(*design.warnings, *link_warnings(links, assumed)))
