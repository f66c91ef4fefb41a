"""The requirements on a spring as the library takes them: quantities as text with a unit, or in SI and radians."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields
from numbers import Real
from typing import Any

from synth.errors import Problem, UserError
from synth.files.validate import near, raise_if_any
from synth.spring.spring_requirements import SpringRequirements
from synth.spring.spring_result import SpringLimits
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

TWICE = ("rate", "travel")


def spring_wish(rate: object, travel: object, wish: Mapping[str, Any]) -> SpringRequirements:
    """The requirements, fields of ``SpringRequirements``; ``limits`` may be a mapping of ``SpringLimits``' fields.

    Raises
    ------
    UserError
        With every unknown name and every value that cannot be read.
    """
    problems: list[Problem] = []
    problems += [Problem("is an argument of its own; leave it out of wish", key=key) for key in TWICE if key in wish]
    wanted = _read({**wish, "rate": rate, "travel": travel}, SpringRequirements, UNITS, "", problems)
    if isinstance(limits := wanted.get("limits"), Mapping):
        wanted["limits"] = _read(limits, SpringLimits, LIMITS, "limits.", problems)
    elif limits is not None and not isinstance(limits, SpringLimits):
        problems.append(Problem(f'{limits!r:.80} is no mapping: write {{"max_outer_diameter": "20 mm"}}', key="limits"))
    raise_if_any(problems)
    if isinstance(limits, Mapping):
        wanted["limits"] = SpringLimits(**wanted["limits"])
    return SpringRequirements(**wanted)


def _read(
    given: Mapping[str, Any], into: type[Any], units: Mapping[str, str], prefix: str, problems: list[Problem]
) -> dict[str, Any]:
    """The fields with their numbers in SI; mistakes go to ``problems``."""
    known = [item.name for item in fields(into)]
    found: dict[str, Any] = {}
    for name, value in given.items():
        key = f"{prefix}{name}"
        if name not in known:
            inside = f'; it is one of the limits: "limits": {{"{name}": ...}}' if not prefix and name in LIMITS else ""
            problems.append(Problem(f"is no requirement on a spring{inside or near(name, known)}", key=key))
            continue
        try:
            found[name] = _value(value, units[name].split()) if name in units and value is not None else value
        except UserError as error:
            problems.append(Problem(error.problems[0].text, key=key))
    return found


def _value(value: object, units: list[str]) -> object:
    """One number or two in SI, each given as such or as text with its unit."""
    if len(units) == 1:
        return _number(value, units[0])
    if isinstance(value, str) or not hasattr(value, "__len__") or len(value) != len(units):
        raise UserError(f"{value!r:.80} is not allowed: write {len(units)} values, (..., ...)")
    return tuple(_number(each, unit) for each, unit in zip(value, units, strict=True))  # type: ignore[call-overload]


def _number(value: object, unit: str) -> float:
    if isinstance(value, str):
        return parse(value, unit)
    if isinstance(value, bool) or not isinstance(value, Real) or math.isnan(value):
        raise UserError(f"{value!r:.80} is not allowed: write a number in {unit}, or text with a unit")
    return float(value)
