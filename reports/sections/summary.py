"""The design in one table."""

from __future__ import annotations

from typing import Any

from synth.reports.quantities import percent
from synth.reports.reading import Result, value_of
from synth.reports.section import AbsentResult, ReportSection, mapping
from synth.reports.wanted_rate import off_wanted, wanted_rate


def content(result: Result) -> dict[str, Any] | AbsentResult:
    """Wanted and chosen by joint."""
    joints = mapping(result.content, "joints")
    if not joints:
        return AbsentResult("design.json names no joint")
    response = mapping(result.content, "response", "wanted_to_built")
    rows = []
    for name, joint in joints.items():
        wanted, spring = mapping(joint, "wanted"), mapping(joint, "spring")
        refit, make = mapping(joint, "refit"), mapping(spring, "make")
        target = wanted_rate(joint)
        rate = make.get("rate") or spring.get("rate")
        count = make.get("count") or 1
        each = value_of(rate)
        together = None if each is None else each * count
        rows.append(
            {
                "name": name,
                "wanted": wanted,
                "refit": refit,
                "free_angle": spring.get("free_angle"),
                "spring": _bought(spring) or ("to make" if make else "none chosen"),
                "none": not spring.get("part") and not make,
                "rate": rate,
                "count": count,
                "off": percent(together, value_of(target)) if make else off_wanted(spring, target),
                "target": target,
                "damper": {**mapping(joint, "damper"), "words": mapping(joint, "damper").get("arrangement")},
                "arm_offset": joint.get("arm_offset"),
                "rms": mapping(response, "joints").get(name),
            }
        )
    return {"joints": rows, "rms": response.get("rms")}


def _bought(spring: dict[str, Any]) -> str:
    """The part, with the number of parallel springs if there are several."""
    part, count = spring.get("part"), spring.get("count")
    return f"{count} x {part}" if part and isinstance(count, int) and count > 1 else str(part or "")


SECTION = ReportSection("summary", "The design in short", content)
