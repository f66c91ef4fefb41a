"""The loop on mass: parts are chosen for links that carry them, round by round until the parts stay.

A round draws the joints of the chosen parts, weighs them, puts them on the links and chooses anew: the motion that is
wanted is fitted to these links, and every leg that is tried carries them. Parts that choose themselves are the end. A
spring to wind keeps its wire from round to round where it can; else two neighbouring sizes would take turns for ever.
The first round starts from each joint's best parts by themselves and leaves out what could stand in for each part, so
that it costs half of a full one.

A round that weighs needs the solids alone: no meshes, gates, pictures or files. On the built-in example that takes 3 s
of a processor where drawing in full takes 20; a joint whose dimensions stay is not built again.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import TYPE_CHECKING, Any

from synth.design.choice_rounds import Stage
from synth.design.drawn_springs import draw_up, simulated_again
from synth.design.leg_design import Known, LegDesign, MassRounds, design_for, known_beforehand
from synth.design.link_masses import BuiltLink, alike, built_links, link_warnings, with_links
from synth.design.part_masses import PartMass, masses_of, unknown_parts
from synth.errors import Problem, UserError
from synth.files.leg_project import LegProject
from synth.files.validate import near
from synth.parts.catalogs import Catalogue
from synth.swing.leg_model import Leg

if TYPE_CHECKING:
    from synth.cad import LegDimensions

MOST_ROUNDS = 5  # of choosing; the built-in example and the lab's project take two
NEAR = 0.03  # mm, deg, N m: joints drawn that near weigh alike to 1e-3, a fifth of what counts as settled
MOST_SETTLING = 4  # drawings by which free angles and masses come to agree; two are enough but for a last digit


def design_with_masses(project: LegProject, catalogue: Catalogue, stage: Stage) -> LegDesign:
    """The design of a leg whose links carry the parts that are drawn on them.

    Raises
    ------
    UserError : as ``design_leg``; ``cad: masses`` names a part that is not there.
    cad.DimensionError : the joints of the chosen parts cannot be drawn.
    """
    from synth import cad

    known, target, scales = known_beforehand(project, stage), project.target, JointWeights(project)
    labels: tuple[object, ...] = ()
    try:
        started = design_for(project, catalogue, known, target, stage, first=True)
        with stage("weighing the joints' parts"):
            target, labels = scales.on_links(draw_up(started, catalogue)), started.sets.chosen.labels
    except cad.DimensionError:
        pass  # the first parts are no more than a start; those that are chosen may well be drawn
    return _rounds(project, catalogue, known, (target, labels), scales, stage)


def _rounds(
    project: LegProject,
    catalogue: Catalogue,
    known: Known,
    start: tuple[Leg, tuple[object, ...]],
    scales: JointWeights,
    stage: Stage,
) -> LegDesign:
    """Choose and weigh until the parts are those that the links carry, or nearly weigh the same."""
    target, labels = start
    held: dict[str, float] = {}
    for count in range(1, MOST_ROUNDS + 1):
        design = design_for(project, catalogue, known, target, stage, swaps=count > 1, held=held)
        with stage("weighing the joints' parts"):
            carrying = scales.on_links(draw_up(design, catalogue))
        settled = count > 1 and (design.sets.chosen.labels == labels or alike(target, carrying))
        if settled:
            break
        target, labels, held = carrying, design.sets.chosen.labels, _wires(design)
    rounds = MassRounds(count, settled)
    design = replace(design, project=project, rounds=rounds, warnings=(*design.warnings, *_said(rounds)))
    return scales.settled(design, catalogue)


def _wires(design: LegDesign) -> dict[str, float]:
    """Wire (m) of each joint that gets one spring to wind."""
    made = zip(design.built.joint_names, (option.design for option in design.springs.chosen), strict=True)
    return {name: spring.wire_diameter for name, spring in made if spring is not None and spring.count == 1}


def _said(rounds: MassRounds) -> list[tuple[str | None, str]]:
    if rounds.settled:
        return []
    return [
        (
            None,
            f"after {rounds.count} rounds of choosing and weighing the parts still change with the links' masses; "
            "those of the last round are taken, their masses simulated; a part asked for by its number would stay",
        )
    ]


class JointWeights:
    """Weighs the joints of a project; keeps what a joint of the same dimensions weighed."""

    def __init__(self, project: LegProject) -> None:
        self.project = project
        self._known: dict[str, tuple[PartMass, ...]] = {}
        self._last: tuple[LegDimensions, Mapping[str, int]] | None = None

    def on_links(self, design: LegDesign) -> Leg:
        """The project's target with the drawn parts of a design on its links."""
        return with_links(self.project.target, self.links(design))

    def links(self, design: LegDesign, *, near: bool = False) -> tuple[BuiltLink, ...]:
        """The links of a design that is drawn up.

        ``near``: with what the joints last weighed, where these are the same but for ``NEAR``.

        Raises
        ------
        UserError : ``cad: masses`` names a part that is not there.
        """
        assert design.drawn is not None
        dimensions, pieces = design.drawn.dimensions, pieces_of(design)
        if (
            near
            and self._last is not None
            and self._last[1] == pieces
            and same_but_for(dimensions, self._last[0], NEAR)
        ):
            dimensions = self._last[0]
        return links_of(design, self._masses(dimensions, pieces))

    def _masses(self, dimensions: LegDimensions, pieces: Mapping[str, int]) -> tuple[PartMass, ...]:
        from synth import cad

        key = repr((dimensions, sorted(pieces.items())))
        if key not in self._known:
            self._known[key] = masses_of(cad.build_leg(dimensions), self.project.cad.masses, pieces)
        self._last = dimensions, pieces
        return self._known[key]

    def settled(self, design: LegDesign, catalogue: Catalogue) -> LegDesign:
        """The design drawn up with its own masses on its links, resting as wanted.

        Once drawn, joints change in their last digits only: they are weighed anew when they are drawn for good.
        """
        design = draw_up(design, catalogue)
        for _ in range(MOST_SETTLING):
            links = self.links(design, near=True)
            leg = with_links(design.built, links)
            if alike(leg, design.built):
                break
            carrying = design.wanted.at_rest_like_wanted(leg)
            design = draw_up(simulated_again(replace(design, built=carrying)), catalogue)
        return design


def same_but_for(one: Any, other: Any, off: float) -> bool:
    """Whether two values are alike, numbers in them apart by at most ``off``: dimensions, tuples, text."""
    if isinstance(one, float | int) and isinstance(other, float | int) and not isinstance(one, bool):
        return abs(one - other) <= off
    if isinstance(one, tuple) and isinstance(other, tuple) and len(one) == len(other):
        return all(same_but_for(a, b, off) for a, b in zip(one, other, strict=True))
    if is_dataclass(one) and type(one) is type(other):
        return all(same_but_for(getattr(one, f.name), getattr(other, f.name), off) for f in fields(one))
    return bool(one == other)


def pieces_of(design: LegDesign) -> dict[str, int]:
    """How many dampers each joint has."""
    return {
        joint.name: option.arrangement.pieces
        for joint, option in zip(design.built.joints, design.dampers.chosen, strict=True)
    }


def links_of(design: LegDesign, masses: Sequence[PartMass]) -> tuple[BuiltLink, ...]:
    """The project's links with these parts.

    Raises
    ------
    UserError : ``cad: masses`` names a part that is not there.
    """
    project = design.project
    wrong = unknown_parts(project.cad.masses, masses)
    if wrong:
        names = sorted(item.part for item in masses)
        file = str(project.path)
        raise UserError(
            [
                Problem(f'"{name}" is no part of these joints{near(name, names)}', file, key="cad.masses")
                for name in wrong
            ]
        )
    return built_links(project.target, masses)


def weighed(design: LegDesign, masses: Sequence[PartMass]) -> LegDesign:
    """The design with the links that its drawn parts make, its motion simulated with them, and what is to be said."""
    links = links_of(design, masses)
    design = replace(design, links=links)
    leg = with_links(design.built, links)
    if leg != design.built:
        design = simulated_again(replace(design, built=leg))
    assumed = {item.part: item.basis for item in masses if item.assumed}
    return replace(design, warnings=(*design.warnings, *link_warnings(links, assumed)))
