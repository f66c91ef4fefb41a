"""The requirements on a spring as the library takes them: quantities as text with a unit, or in SI and radians."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields
from numbers import Real
from typing import Any

from synth.errors import Problem, UserError
from synth.files.validate import near, raise_if_any
from synth.spring.calibration import WindingCalibration
from synth.spring.requirement_ranges import RANGES, RISING
from synth.spring.spring_requirements import SpringRequirements
from synth.spring.spring_task import SameArm, SpringLimits
from synth.units import parse

# The unit of every requirement that is a number; "m m": two of them.
UNITS = {
    "rate": "N*m/rad", "travel": "rad", "opening_travel": "rad", "included_angle": "rad", "held_wire": "m",
    "pitch": "1", "leg_lengths": "m m", "wire_range": "m m",
}  # fmt: skip
LIMITS = {
    "arbor_diameter": "m", "arbor_gap": "1", "min_inside_diameter": "m", "max_outer_diameter": "m",
    "max_body_length": "m", "index_range": "1 1", "min_coils": "1", "max_coils": "1", "safety": "1", "cycles": "1",
    "fatigue_safety": "1", "bend_radius": "m", "min_outer_diameter": "m", "min_body_length": "m",
}  # fmt: skip

ARM_RANGE = "leg_lengths"  # whose range a clamped arm's free length has
TWICE = ("rate", "travel")


def spring_wish(rate: object, travel: object, wish: Mapping[str, Any]) -> SpringRequirements:
    """The requirements, fields of ``SpringRequirements``; ``limits`` may be a mapping of ``SpringLimits``' fields.

    Raises
    ------
    UserError
        With every unknown name, and every value that cannot be read or is outside the command's range.
    """
    problems: list[Problem] = []
    problems += [Problem("is an argument of its own; leave it out of wish", key=key) for key in TWICE if key in wish]
    wanted = _read_fields({**wish, "rate": rate, "travel": travel}, SpringRequirements, UNITS, "", problems)
    if (arm := wanted.get("free_arm")) is not None and not callable(arm):
        try:
            wanted["free_arm"] = SameArm(_number(arm, ARM_RANGE, "m"))
        except UserError as error:
            problems.append(Problem(error.problems[0].text, key="free_arm"))
    limits = wanted.pop("limits", None)
    if isinstance(limits, SpringLimits):
        limits = {item.name: getattr(limits, item.name) for item in fields(limits)}
    if not isinstance(limits, Mapping | None):
        problems.append(Problem(f'{limits!r:.80} is no mapping: write {{"max_outer_diameter": "20 mm"}}', key="limits"))
        limits = None
    limited = _read_fields(limits or {}, SpringLimits, LIMITS, "limits.", problems)
    for low, high in RISING:
        if (least := limited.get(low)) is not None and (most := limited.get(high)) is not None and least > most:
            problems.append(Problem(f"{least:.6g} is above {high}, {most:.6g}", key=f"limits.{low}"))
    problems += _of_another_class(wanted)
    raise_if_any(problems)
    return SpringRequirements(**wanted, limits=SpringLimits(**limited))


def _of_another_class(wanted: Mapping[str, Any]) -> list[Problem]:
    """The values of a wrong class that are neither numbers nor one of a few words."""
    read = "read the file with read_calibration of synth.spring.wound_samples"
    classes = {"material": (str, "write a wire's name as text"), "calibration": (WindingCalibration, read)}
    return [
        Problem(f"{wanted[name]!r:.80} is not allowed: {how}", key=name)
        for name, (wanted_class, how) in classes.items()
        if name in wanted and not isinstance(wanted[name], wanted_class)
    ]


def _read_fields(
    given: Mapping[str, Any], into: type[Any], units: Mapping[str, str], prefix: str, problems: list[Problem]
) -> dict[str, Any]:
    """The fields with their numbers in SI; mistakes go to ``problems``."""
    known = {item.name: item.default for item in fields(into)}
    found: dict[str, Any] = {}
    for name, value in given.items():
        key = f"{prefix}{name}"
        if name not in known:
            inside = f'; it is one of the limits: "limits": {{"{name}": ...}}' if not prefix and name in LIMITS else ""
            problems.append(Problem(f"is no requirement on a spring{inside or near(name, known)}", key=key))
            continue
        if value is None and known[name] is not None and name != "limits":
            problems.append(Problem("None is not allowed: leave it out for the default", key=key))
            continue
        try:
            found[name] = value if value is None or name not in units else _value(value, name, units[name].split())
        except UserError as error:
            problems.append(Problem(error.problems[0].text, key=key))
    return found


def _value(value: object, name: str, units: list[str]) -> object:
    """One number or two in SI and in the range of the requirement, each given as such or as text with its unit."""
    if len(units) == 1:
        return _number(value, name, units[0])
    if isinstance(value, str) or not hasattr(value, "__len__") or len(value) != len(units):
        raise UserError(f"{value!r:.80} is not allowed: write {len(units)} values, (..., ...)")
    found = tuple(_number(each, name, unit) for each, unit in zip(value, units, strict=True))  # type: ignore[call-overload]
    if name.endswith("_range") and found[0] > found[1]:
        raise UserError(f"{value!r:.80} is not allowed: write the lower end first")
    return found


def _number(value: object, name: str, unit: str) -> float:
    shown, bare = f'"{value}"', ""
    if isinstance(value, str):
        found = parse(value, unit)
    elif isinstance(value, bool) or not isinstance(value, Real) or math.isnan(value):
        raise UserError(f"{value!r:.80} is not allowed: write a number in {unit}, or text with a unit")
    else:
        found = float(value)
        if unit == "1":
            shown = f"{found:.6g}"
        else:
            shown, bare = f"{found:.6g} {unit}", f"; a number without a unit is in {unit}"
    if not RANGES[name].has(found):
        raise UserError(f"{shown} {RANGES[name].words}{bare}")
    return found
