"""Many diagnoses: each leg's verdict, and how often each cause is named."""

from __future__ import annotations

from collections import defaultdict
from typing import Any

from synth.reports.figures.bars import Bar, BarColumn, bar_figure
from synth.reports.quantities import share_text
from synth.reports.reading import Json, Result
from synth.reports.section import AbsentResult, ReportSection, mapping, records, sequence
from synth.reports.sections.gap_which import name_of

MOST_ROWS = 400  # of the table; the CSV holds all
MOST_BARS = 20  # causes drawn
MOST_NAMED = 5  # legs that are named beside a cause
WIDTH, LABEL = 800.0, 236.0  # px


def causes(result: Result) -> dict[str, list[str]]:
    """Cause -> the legs whose accepted explanation holds it, the commonest first."""
    found: dict[str, list[str]] = defaultdict(list)
    for leg in records(result.content, "legs"):
        for cause in sequence(leg, "explanation") if is_accepted(leg) else ():
            found[name_of(cause)].append(str(leg["name"]))
    return dict(sorted(found.items(), key=lambda item: (-len(item[1]), item[0])))


def is_accepted(leg: Json) -> bool:
    """Whether the leg's ``explanation`` was accepted; with the verdict unknown it is the nearest that was not."""
    return str(leg.get("verdict")) != "unknown"


def _legs(result: Result) -> dict[str, Any] | AbsentResult:
    """Each leg's verdict and likeliest cause."""
    rows = []
    for leg in records(result.content, "legs"):
        ranked = sequence(leg, "ranked")
        first = ranked[0] if ranked else {}
        rows.append(
            {
                "leg": leg["name"],
                "report": leg["report"],
                "verdict": leg["verdict"],
                "causes": [name_of(cause) for cause in sequence(leg, "explanation")],
                "accepted": is_accepted(leg),
                "likeliest": name_of(first) if first else "",
                "probability": share_text(first.get("probability")) if first else "",
                "shrink": first.get("shrink"),
                "rms": mapping(leg, "rms"),
            }
        )
    if not rows:
        return AbsentResult("no project could be diagnosed")
    return {"rows": rows[:MOST_ROWS], "left": max(0, len(rows) - MOST_ROWS)}


def _causes(result: Result) -> dict[str, Any] | AbsentResult:
    """How often each cause is named."""
    found = causes(result)
    if not found:
        return AbsentResult("no leg's explanation names a cause")
    shown = list(found.items())[:MOST_BARS]
    most = float(max(len(legs) for _, legs in shown))
    bars = [Bar(float(len(legs)), str(len(legs)), strong=len(legs) == most) for _, legs in shown]
    title = "Legs whose explanation holds the cause"
    figure = bar_figure(title, [name for name, _ in shown], [BarColumn("legs", bars, most)], WIDTH, LABEL)
    rows = [{"cause": name, "count": len(legs), "legs": legs[:MOST_NAMED]} for name, legs in shown]
    return {"figure": figure, "title": title, "rows": rows, "left": len(found) - len(shown)}


LEGS = ReportSection("gaps-legs", "Leg by leg", _legs)
CAUSES = ReportSection("gaps-causes", "Causes across the legs", _causes)
