"""Many designs: each leg's parts and how far it is from the wanted motion, and the checks that failed."""

from __future__ import annotations

from typing import Any

from synth.reports.reading import Json, Result
from synth.reports.section import AbsentResult, ReportSection, mapping, records, sequence

MOST_ROWS = 400  # of the table; the CSV holds all


def _legs(result: Result) -> dict[str, Any] | AbsentResult:
    """Each leg's joints with their parts."""
    rows: list[Json] = []
    for leg in records(result.content, "legs"):
        for index, (joint, about) in enumerate(mapping(leg, "joints").items()):
            rows.append(
                {
                    "leg": leg["name"] if index == 0 else "",
                    "report": leg["report"],
                    "whole": leg["rms"] if index == 0 else None,
                    "joint": joint,
                    "wanted": mapping(about, "wanted"),
                    "spring": about.get("spring") or "none",
                    "damper": about.get("damper") or "none",
                    "rms": mapping(leg, "joint_rms").get(joint),
                }
            )
    if not rows:
        return AbsentResult("no project could be designed")
    return {"rows": rows[:MOST_ROWS], "left": max(0, len(rows) - MOST_ROWS)}


def _checks(result: Result) -> dict[str, Any] | AbsentResult:
    """Legs whose drawn joints fail a check."""
    found = [
        {"name": leg["name"], "messages": sequence(leg, "failed_checks")}
        for leg in records(result.content, "legs")
        if sequence(leg, "failed_checks")
    ]
    if found:
        return {"failed": found}
    drawn = any(leg.get("drawn") is not False for leg in records(result.content, "legs"))
    return AbsentResult("every drawn joint passes its checks" if drawn else "no joint is drawn (--no-cad)")


LEGS = ReportSection("designs-legs", "Leg by leg", _legs)
CHECKS = ReportSection("designs-checks", "Checks that failed", _checks)
