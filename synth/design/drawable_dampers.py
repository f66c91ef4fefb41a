"""Whether a damper can be drawn on its joint's shaft, and a joint in its links, before anything is chosen.

Both are judged by the smallest joint that the shaft allows (``synth.cad.least_joint``): what does not fit there fits
with no spring.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from synth.design.damper_sizes import drawn_damper, known_sizes
from synth.design.drawing_refusals import DAMPER_KEYS
from synth.errors import Problem, UserError
from synth.files.leg_project import LegProject
from synth.files.project_options import SHAFTS, CadOptions, DamperShape
from synth.parts.rows import DamperRow
from synth.swing.leg_model import Leg

if TYPE_CHECKING:
    from synth.cad import DamperDimensions, DimensionProblem, JointDimensions

# The smallest that a project may state: a rod of 3 mm, two lines of print, the thinnest tube and the least clearance.
SMALLEST = CadOptions(shaft_diameter=SHAFTS[0], clearance=1e-4, wall=1.2e-3, link_width=6e-3, tube_wall=5e-4)
ROUNDING = 1e-6  # mm, of a converted length
# Reasons of ``damper_does_not_fit`` by the end of the dimension's name, as text with the joint's key.
_REASONS = {
    "bolt_circle": "its circle of screws is too small for the shaft of {shaft} and the damper's bracket",
    "body_length": "its body is too short for the screws of the bracket",
    "bore.size": "its bore does not fit the shaft of {shaft}",
    "bore.hub": "nothing is known to hold the shaft in its round bore (cad.dampers.{joint}.hub)",
    "outer_diameter": "its body is too small for the shaft of {shaft}, or for what joins it to that",
}
Against = Callable[[int, DamperRow], str | None]  # index of the joint, the damper -> why it cannot be drawn there


def reasons_in(leg: Leg, cad: CadOptions) -> Against:
    """The first reason why a damper cannot be drawn at a joint of ``leg``; None: none is known beforehand.

    The reasons are the same text for all dampers of a joint, so that they can be counted.
    """
    others = [_least(cad, joint.name) for joint in leg.joints]

    def against(j: int, row: DamperRow) -> str | None:
        return next(_reasons(row, j, leg, cad, others), None)

    return against


def _least(cad: CadOptions, name: str, damper: DamperDimensions | None = None) -> JointDimensions:
    from synth.cad.least_joint import least_joint

    tube = (cad.link_width * 1e3, cad.tube_wall * 1e3)
    joint = least_joint(cad.shaft_diameter * 1e3, cad.clearance * 1e3, cad.wall * 1e3, tube, damper)
    return replace(joint, name=name)


def _reasons(row: DamperRow, j: int, leg: Leg, cad: CadOptions, others: Sequence[JointDimensions]) -> Iterator[str]:
    from synth.cad.least_joint import damper_does_not_fit, least_links

    name, shaft = leg.joints[j].name, cad.shaft_diameter * 1e3
    joint = _least(cad, name, drawn_damper(known_sizes(row, name, cad), shaft, f"cad.dampers.{name}"))
    problems, of_itself = damper_does_not_fit(joint), joint.damper.problems(f"{name}.damper.")
    if any(_is_stated(problem, name, cad) for problem in problems):
        return  # a mistake in the project, of every damper: the drawing names its key
    for problem in problems:
        yield _text(problem, name, shaft, out_of_range=problem in of_itself and problem.least is None)
    if problems or cad.dampers.get(name, DamperShape()).bolt_circle is not None:
        return
    whole = least_links([*others[:j], joint, *others[j + 1 :]])
    for k in (j - 1, j):
        if k >= 0 and leg.joints[k].link.length * 1e3 < whole[k] - ROUNDING:
            assumed = "" if row.bolt_circle is not None else ", drawn with assumed sizes,"
            size = f"{leg.joints[k].link.length * 1e3:.4g} mm"
            yield f"its bracket{assumed} is too wide for the link of {size} beside it (cad.dampers.{name}.bolt_circle)"


def _is_stated(problem: DimensionProblem, name: str, cad: CadOptions) -> bool:
    """Whether the project states the size that a problem names."""
    key = DAMPER_KEYS.get(problem.dimension.removeprefix(f"{name}.damper."))
    stated = key is not None and getattr(cad.dampers.get(name, DamperShape()), key) is not None
    return stated or (key in ("shaft_size", "shaft_form") and name in cad.damper_shafts)


def _text(problem: DimensionProblem, name: str, shaft: float, *, out_of_range: bool) -> str:
    """One problem of a damper in words that do not depend on its sizes."""
    for end, text in _REASONS.items():
        if problem.dimension.endswith(end) and (not out_of_range or end == "bore.hub"):
            return text.format(shaft=f"{shaft:g} mm (cad.shaft_diameter)", joint=name)
    key = problem.dimension.removeprefix(f"{name}.damper.")
    return f"cannot be drawn: its {key.replace('_', ' ').replace('.', ', ')} is out of range"


def refuse_short_links(project: LegProject) -> None:
    """Raise UserError for links in which no joint can be drawn, whatever spring and damper it gets."""
    problems = [_short_link(project, k, least) for k, least in _short_links(project.target, project.cad)]
    if problems:
        raise UserError(problems)


def _short_links(leg: Leg, cad: CadOptions) -> Iterator[tuple[int, float]]:
    """Index and least length (mm) of each link that is shorter than the smallest joints at its ends."""
    from synth.cad.least_joint import least_links

    least = least_links([_least(cad, joint.name) for joint in leg.joints])
    for k, joint in enumerate(leg.joints):
        if joint.link.length * 1e3 < least[k] - ROUNDING:
            yield k, least[k]


def _short_link(project: LegProject, k: int, least: float) -> Problem:
    from synth.cad.limits import rounded_up

    leg, cad = project.target, project.cad
    joint, last = leg.joints[k], k + 1 == len(leg.joints)
    hinges = "its hinge" if last else "its two hinges"
    sizes = f"a shaft of {cad.shaft_diameter * 1e3:g} mm, walls of {cad.wall * 1e3:g} mm and a tube of"
    text = (
        f"the link of {joint.name} is {joint.link.length * 1e3:.4g} mm long: allowed is at least {rounded_up(least)} "
        f"mm, which {hinges} and the tube's {'socket' if last else 'sockets'} take with {sizes} "
        f"{cad.link_width * 1e3:g} mm, even with the thinnest spring and the smallest damper"
    )
    smaller = dict(_short_links(leg, SMALLEST))
    by_keys = (
        f"shaft_diameter: {SMALLEST.shaft_diameter * 1e3:g} mm, wall: {SMALLEST.wall * 1e3:g} mm, "
        f"clearance: {SMALLEST.clearance * 1e3:g} mm, link_width: {SMALLEST.link_width * 1e3:g} mm, "
        f"tube_wall: {SMALLEST.tube_wall * 1e3:g} mm"
    )
    if k in smaller:
        remedy = (
            f"The smallest sizes that cad: allows take {rounded_up(smaller[k])} mm, so no joint can be drawn in it: "
            "give a target leg of longer links, with scale: {time: froude} for the same motion"
        )
    else:
        remedy = f"Smaller sizes can do it, down to cad: {{{by_keys}}}"
    return Problem(f"{text}. {remedy}. Or leave the solids out with --no-cad", str(project.path), key="target")
