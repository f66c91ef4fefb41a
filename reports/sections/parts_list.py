"""The chosen parts, their sources, and the cost of the next best ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from synth.reports.reading import Json, Result, value_of
from synth.reports.section import AbsentResult, ReportSection, mapping, sequence
from synth.reports.wanted_rate import off_wanted, wanted_rate

ALTERNATIVES_SHOWN = 8  # alternatives of each part
OFFERED_RATE = 4.0  # largest ratio to the wanted rate; a spring farther off makes another leg


def content(result: Result) -> dict[str, Any] | AbsentResult:
    """Spring, damper, substitutes and excluded rows, by joint."""
    joints = mapping(result.content, "joints")
    rows = [_joint(name, joint) for name, joint in joints.items() if isinstance(joint, Mapping)]
    if not any(row["spring"] or row["damper"] for row in rows):
        return AbsentResult("design.json names no part")
    return {
        "joints": rows,
        "most": ALTERNATIVES_SHOWN,
        "forecast": bool(mapping(result.content, "response", "forecast")),
    }


def _joint(name: str, joint: Mapping[str, Any]) -> Json:
    spring = mapping(joint, "spring")
    wanted = wanted_rate(joint)
    alternatives = [dict(item) for item in sequence(joint, "spring_alternatives") if isinstance(item, Mapping)]
    alternatives = [item for item in alternatives if is_near(item, wanted)]
    for item in alternatives:
        item["off"] = off_wanted(item, wanted)
    made = mapping(spring, "make")
    return {
        "name": name,
        "spring": {} if made else spring,
        "made": made,
        "no_spring": not made and any(key in spring for key in ("make", "binding", "nearest")),
        "wanted": mapping(joint, "wanted"),
        "wanted_rate": wanted,
        "off": off_wanted(spring, wanted),
        "damper": mapping(joint, "damper"),
        "arm_offset": joint.get("arm_offset"),
        "springs": _by_cost(alternatives),
        "dampers": _by_cost([i for i in sequence(joint, "damper_alternatives") if isinstance(i, Mapping)]),
        "left_out": [found for kind in ("springs", "dampers") if (found := _left_out(joint, kind))],
    }


def _by_cost(alternatives: Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """The substitutes by the cost that is shown, that of their expected error."""
    return sorted(alternatives, key=lambda item: value_of(item.get("cost")) or 0.0)


def is_near(alternative: Mapping[str, Any], wanted: object) -> bool:
    """Whether a spring's rate is near enough to the wanted one to be offered in its place."""
    rate, aim = value_of(alternative.get("rate")), value_of(wanted)
    return rate is None or not aim or aim / OFFERED_RATE <= rate <= aim * OFFERED_RATE


def _left_out(joint: Mapping[str, Any], kind: str) -> Json | None:
    """Reasons with the number of parts that they exclude, largest first."""
    reasons = mapping(joint, "left_out", kind)
    counted = [(int(count), reason) for reason, count in reasons.items() if isinstance(count, (int, float))]
    total = sum(count for count, _ in counted)
    ranked = sorted(counted, key=lambda item: (-item[0], item[1]))
    return {"kind": kind, "total": total, "reasons": ranked} if ranked else None


SECTION = ReportSection("parts", "Chosen parts", content)
