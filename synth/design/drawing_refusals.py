"""The message for a joint that cannot be drawn: the key to change, or what the program chose and what decides it."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from synth.errors import Problem, UserError
from synth.files.leg_project import LegProject

REMEDY = "Or leave the solids out with --no-cad"
_CAD = {
    "shaft_diameter": "shaft_diameter",
    "clearance": "clearance",
    "wall": "wall",
    "link_width": "link_width",
    "tube_wall": "tube_wall",
    "bed": "bed",
    "strength": "print_strength",
    "density": "print_density",
    "between_layers": "between_layers",
    "safety": "safety",
}  # of a joint and of its printing -> key under `cad`
DAMPER_KEYS = {
    "outer_diameter": "outer_diameter",
    "body_length": "body_length",
    "bolt_circle": "bolt_circle",
    "bolt_count": "bolts",
    "bolt_diameter": "bolt_diameter",
    "bore.size": "shaft_size",
    "bore.form": "shaft_form",
    "bore.hub": "hub",
    "adapter.output_diameter": "shaft_size",
    "adapter.form": "shaft_form",
}  # of a drawn damper -> key under `cad: {dampers: {JOINT: ...}}`
_WITHOUT_UNIT = re.compile(r"count|springs|closes|sign|coils|hand|form|hub|name|joints|between_layers|safety")
_IN_DEGREES = re.compile(r"angle|range|stops|travel|tilt|overhang")
_SPRING = "another spring (select.joints.{joint}.spring)"
_TRAVEL = "a smaller range of {joint} in the target leg"
# What no key states: in words what it is, and what changes it.
_CHOSEN = {
    "upper_arm_angle": ("the direction of the upper arm, which the program chooses,", f"{_TRAVEL}, or {_SPRING}"),
    "free_angle": (
        "the free angle, at which the spring balances the leg's weight in its rest pose,",
        "a stiffer spring (select.joints.{joint}.spring), whose free angle is nearer",
    ),
    "spring.included_angle": (
        "the angle between the spring's arms",
        "another angle (select.joints.{joint}.spring.included_angle), another spring, or a smaller range of {joint}",
    ),
    "range": ("the drawn travel, that of the motion with a margin,", f"{_SPRING}, or {_TRAVEL}"),
    "stops": ("the place of the stops", f"{_TRAVEL}, or {_SPRING}"),
    "link_length": ("the link's length", "a longer link of {joint} in the target leg, a smaller spring or damper"),
    "spring": ("of the spring", _SPRING),
    "damper": ("of the damper as drawn", "another damper (select.joints.{joint}.damper)"),
    "encoder": ("of the encoder's seat, which the program chooses,", "cad: {{encoder: false}}"),
    "mount": ("of the mount's flange, which the program chooses,", "cad: {{mount: false}}"),
    "": ("which the program chooses,", f"{_SPRING}, another damper (select.joints.{{joint}}.damper), or {_TRAVEL}"),
}


@dataclass(frozen=True)
class _Place:
    """Where a user states a dimension: its key; None, what it is in words. ``remedy``: what else changes it."""

    key: str | None
    what: str
    remedy: str


def not_drawable(error: Any, project: LegProject) -> UserError:
    """The user's message for joints that cannot be drawn; ``error`` is a ``cad.DimensionError``."""
    return UserError([_refusal(problem, project) for problem in error.problems])


def _refusal(problem: Any, project: LegProject) -> Problem:
    """One ``cad.DimensionProblem`` in the words of the project."""
    joint, name = _parts(problem.dimension, project.target.joint_names)
    place = _place(joint, name, project)
    value = _with_unit(name, problem.value)
    said = f"{place.what} is {value}: " if place.what else f"{value}: "
    text = f"{said}allowed is {problem.allowed}; {problem.reason}"
    remedy = f"; to change: {place.remedy}" if place.remedy else ""
    return Problem(f"{text}{remedy}. {REMEDY}", str(project.path), key=place.key or "cad")


def _parts(dimension: str, joints: tuple[str, ...]) -> tuple[str, str]:
    """The joint that a dimension belongs to, and its name there; names of joints may have dots."""
    for joint in sorted(joints, key=len, reverse=True):
        if dimension.startswith(f"{joint}."):
            return joint, dimension[len(joint) + 1 :]
    return "", dimension.removeprefix("printing.")


def _place(joint: str, name: str, project: LegProject) -> _Place:
    if name in _CAD:
        return _Place(f"cad.{_CAD[name]}", "", "")
    kind, _, rest = name.partition(".")
    if kind == "damper" and rest in DAMPER_KEYS:
        key = DAMPER_KEYS[rest]
        shape = project.cad.dampers.get(joint)
        stated = shape is not None and getattr(shape, key, None) is not None
        told = "" if stated else f"not stated in the project; of {joint}'s damper as drawn it"
        remedy = "" if stated else f"measure and write it, or {_CHOSEN['damper'][1]}"
        return _Place(f"cad.dampers.{joint}.{key}", told, remedy.format(joint=joint))
    known = dict(zip(project.target.joint_names, project.target.joints, strict=True)).get(joint)
    if name == "range" and known is not None and known.range is not None:
        remedy = f"{_SPRING}, or another range"
        return _Place(None, f"the range of {joint} in the target leg", remedy.format(joint=joint))
    what, remedy = _CHOSEN.get(name) or _CHOSEN.get(kind) or _CHOSEN[""]
    plain = (rest if kind in _CHOSEN and rest else name).replace("_", " ").replace(".", ", ")
    whole = what if name in _CHOSEN else f"{plain} {what}" if what.startswith("of ") else f"{plain}, {what}"
    return _Place(None, f"{joint}: {whole}" if joint else whole, remedy.format(joint=joint or "the joint"))


def _with_unit(name: str, value: object) -> str:
    """A dimension of ``cad``, in mm or deg, with its unit."""
    last = name.rpartition(".")[2]
    if isinstance(value, tuple):
        unit = "deg" if _IN_DEGREES.search(last) else "mm"
        return f"{' to '.join(f'{each:.6g}' for each in value)} {unit}"
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return repr(value) if value is not None else "none"
    if _WITHOUT_UNIT.search(last):
        return f"{value:.6g}"
    units = {"strength": "MPa", "density": "g/cm^3"}
    return f"{value:.6g} {units.get(last, 'deg' if _IN_DEGREES.search(last) else 'mm')}"
