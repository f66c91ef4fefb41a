"""Many fits: what could not be fitted, how the legs differ, and each leg's estimates."""

from __future__ import annotations

import statistics
from collections.abc import Mapping
from typing import Any

from synth.reports.figures.interval_bars import IntervalRow, interval_figure
from synth.reports.reading import Json, Result
from synth.reports.section import AbsentResult, ReportSection, mapping, sequence
from synth.reports.sections.warnings import of_leg

MOST_ROWS = 400  # of the table; the CSV holds all
MOST_WARNINGS = 100  # of different words
MOST_DRAWN = 40  # legs in a figure; more would be a grey block
RATES = (("spring_rate", "spring rate"), ("damper_rate", "damper rate"))


def _failed_fits(result: Result) -> dict[str, Any] | AbsentResult:
    found = _items(result, "failed")
    return {"failed": found} if found else AbsentResult("none was left out")


def _across(result: Result) -> dict[str, Any] | AbsentResult:
    """A joint's rates over the legs: median, least and greatest, and each leg's ratio to the median."""
    legs = _items(result, "legs")
    rows, figures = [], []
    for joint in _joints(legs):
        drawn: list[IntervalRow] = []
        for key, words in RATES:
            held = [(leg["name"], _estimate(leg, joint, key)) for leg in legs]
            known = [(name, estimate) for name, estimate in held if estimate is not None]
            if len(known) < 2:
                continue
            values = [estimate["value"] for _, estimate in known]
            middle = statistics.median(values)
            unit = known[0][1]["unit"]
            ends = [{"value": value, "unit": unit} for value in (middle, min(values), max(values))]
            rows.append({"joint": joint, "what": words, "legs": len(known), "ends": ends})
            group = 0 if key == "spring_rate" else 1
            for index, (name, estimate) in enumerate(known[:MOST_DRAWN]):
                ends90 = estimate.get("interval90") or (None, None)
                low, high = (None if end is None else end / middle for end in ends90)
                first = index == 0 and group == 1
                drawn.append(IntervalRow(f"{name}, {words}", group, estimate["value"] / middle, low, high, first))
        if drawn:
            title = f"{joint}: each leg's rates over the median of all legs"
            figures.append({"title": title, "drawing": interval_figure(title, "rate over the legs' median", drawn)})
    if not rows:
        return AbsentResult("fewer than two legs share a joint's name")
    return {"rows": rows, "figures": figures, "drawn": MOST_DRAWN, "legs": len(legs)}


def _legs(result: Result) -> dict[str, Any] | AbsentResult:
    """Each leg's joints."""
    legs = _items(result, "legs")
    rows: list[Json] = []
    for leg in legs:
        for index, (joint, estimates) in enumerate(mapping(leg, "joints").items()):
            rows.append(
                {
                    "leg": leg["name"] if index == 0 else "",
                    "report": leg["report"],
                    "joint": joint,
                    "trials": leg["trials"] if index == 0 else "",
                    "estimates": estimates,
                    "rms": mapping(leg, "rms", joint),
                }
            )
    if not rows:
        return AbsentResult("no project could be fitted")
    return {"rows": rows[:MOST_ROWS], "left": max(0, len(rows) - MOST_ROWS)}


def _warnings(result: Result) -> dict[str, Any] | AbsentResult:
    """Warnings with the legs that have them; the same words of many legs once."""
    where: dict[str, list[str]] = {}
    for leg in _items(result, "legs"):
        for words in dict.fromkeys(of_leg(leg)):
            where.setdefault(words, []).append(leg["name"])
    if not where:
        return AbsentResult("none has a warning")
    common = sorted(where.items(), key=lambda item: -len(item[1]))[:MOST_WARNINGS]
    return {"warnings": [{"text": words, "legs": legs[:5], "count": len(legs)} for words, legs in common]}


def _items(result: Result, key: str) -> list[Json]:
    return [dict(item) for item in sequence(result.content, key) if isinstance(item, Mapping)]


def _joints(legs: list[Json]) -> list[str]:
    return list(dict.fromkeys(joint for leg in legs for joint in mapping(leg, "joints")))


def _estimate(leg: Json, joint: str, key: str) -> Json | None:
    found = mapping(leg, "joints", joint, key)
    return found if isinstance(found.get("value"), (int, float)) and found["value"] > 0 else None


def failed_section(done: str) -> ReportSection:
    """What could not be ``done``, "fitted"."""
    return ReportSection("failed", f"Could not be {done}", _failed_fits, "fits-failed")


FAILED = failed_section("fitted")
ACROSS = ReportSection("fits-across", "Across the legs", _across)
LEGS = ReportSection("fits-legs", "Leg by leg", _legs)
WARNINGS = ReportSection("fits-warnings", "Warnings of single legs", _warnings)
