"""Sections of a jumping leg's gap only: its location in the push, and its trend across designs."""

from __future__ import annotations

from typing import Any

from synth.reports.figures.hopper_across import STAGES, Trend, across_figure
from synth.reports.figures.legend import legend
from synth.reports.quantities import in_si
from synth.reports.reading import Result, value_of
from synth.reports.section import AbsentResult, ReportSection, mapping, sequence
from synth.reports.sections import gap_where

# Key in ``across`` -> axis, size of a drawn unit in SI, key of a design's value.
AXES = {"length": ("upper link [mm]", 1e-3, "leg_length"), "gear_ratio": ("gear ratio", 1.0, "gear_ratio")}


def content(result: Result) -> dict[str, Any] | AbsentResult:
    """Rises trial by trial, and the error's trends."""
    found = mapping(result.content, "across")
    designs = [item for item in sequence(found, "designs") if isinstance(item, dict)]
    if not designs:
        return AbsentResult("no scored jump has a measured rise; it needs a force plate")
    figures = []
    for by, (axis, unit, key) in AXES.items():
        slopes = mapping(found, "slope", by)
        if not slopes:
            continue
        x = [(in_si(item[key]) or 0.0) / unit if isinstance(item[key], dict) else float(item[key]) for item in designs]
        trends = []
        for stage, line in STAGES.items():
            errors = [value_of(mapping(item, "error").get(stage)) or 0.0 for item in designs]
            slope = _slope(slopes.get(stage))
            trends.append(Trend(x, errors, None if slope is None else 100.0 * slope * unit, line))
        figures.append(across_figure(f"Error of the rise against {axis}", axis, trends))
    names = {"as_designed": "as designed", "after": "with the explanation"}
    return {
        "says": sequence(found, "says"),
        "designs": designs,
        "figures": figures,
        "legend": legend([(line, names[stage]) for stage, line in STAGES.items()]),
        "slopes": [
            {"by": by.replace("_", " "), "stage": names[stage], "slope": mapping(found, "slope", by).get(stage)}
            for by in AXES
            for stage in STAGES
            if mapping(found, "slope", by)
        ],
    }


def _slope(quantity: object) -> float | None:
    """Relative error per metre of length, or per unit of ratio."""
    value = value_of(quantity)
    if value is None:
        return None
    unit = quantity.get("unit") if isinstance(quantity, dict) else ""
    return 100.0 * value if unit == "1/cm" else value


WHERE = ReportSection(
    "hopper-where",
    "Where the gap lies",
    lambda result: gap_where.content(result, "upper link from the crouch", ("settle", "rest")),
)
ACROSS = ReportSection("hopper-across", "How high, and across designs", content)
