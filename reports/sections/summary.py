"""The design in one table."""

from __future__ import annotations

from typing import Any

from reports.quantities import percent
from reports.reading import Result, value_of
from reports.section import Missing, Section, mapping


def content(result: Result) -> dict[str, Any] | Missing:
    """Wanted and chosen by joint."""
    joints = mapping(result.content, "joints")
    if not joints:
        return Missing("design.json names no joint")
    response = mapping(result.content, "response", "wanted_to_built")
    rows = []
    for name, joint in joints.items():
        wanted, spring = mapping(joint, "wanted"), mapping(joint, "spring")
        refit, make = mapping(joint, "refit"), mapping(spring, "make")
        target = refit.get("spring_rate") or wanted.get("spring_rate")
        rate = make.get("rate") or spring.get("rate")
        count = make.get("count") or 1
        value = value_of(rate)
        rows.append(
            {
                "name": name,
                "wanted": wanted,
                "refit": refit,
                "spring": spring.get("part") or ("to make" if make else "none chosen"),
                "none": not spring.get("part") and not make,
                "rate": rate,
                "count": count,
                "off": percent(None if value is None else value * count, value_of(target)),
                "damper": mapping(joint, "damper"),
                "arm_offset": joint.get("arm_offset"),
                "rms": mapping(response, "joints").get(name),
            }
        )
    return {"joints": rows, "rms": response.get("rms")}


SECTION = Section("summary", "The design in short", content)
