"""The chosen jumping leg, the cost of its neighbours, its tolerances, and the map of all designs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from synth.reports.figures.hopper_map import Map, map_figure
from synth.reports.quantities import percent
from synth.reports.reading import Result, value_of
from synth.reports.section import AbsentResult, ReportSection, mapping, sequence

MOST = 12  # designs of the front in the table


def content(result: Result) -> dict[str, Any] | AbsentResult:
    """Best design, neighbours with what they cost, tolerances, the front."""
    best = mapping(result.content, "best")
    if not best:
        return AbsentResult("no design was chosen")
    reference = value_of(best.get("clearance"))
    neighbours = [
        {**item, "off": percent(value_of(item.get("clearance")), reference)}
        for item in sequence(result.content, "neighbours")
        if isinstance(item, Mapping)
    ]
    front = [item for item in sequence(result.content, "pareto") if isinstance(item, Mapping)]
    step = max(1, -(-len(front) // MOST))
    return {
        "best": best,
        "constants": mapping(best, "motor_constants"),
        "leg": mapping(best, "leg"),
        "neighbours": neighbours,
        "tolerances": sequence(result.content, "tolerances"),
        "front": front[::step],
        "front_size": len(front),
        "counts": mapping(result.content, "counts"),
        "settings": mapping(result.content, "settings"),
    }


def map_content(result: Result) -> dict[str, Any] | AbsentResult:
    """Clearance over ratio and length."""
    found = mapping(result.content, "map")
    ratios, lengths, heights = (found.get(name) or [] for name in ("gear_ratio", "leg_length_m", "clearance_m"))
    if len(lengths) < 2 or not ratios:
        return AbsentResult("there are fewer than two lengths")
    best = mapping(result.content, "best")

    def design(item: Mapping[str, Any]) -> tuple[float, float]:
        return float(item["gear_ratio"]), value_of(item["leg_length"]) or 0.0

    own = str(best.get("motor", "")).rpartition(" ")[0]
    front = [design(item) for item in sequence(result.content, "pareto")
             if isinstance(item, Mapping) and str(item.get("motor", "")).startswith(own)]  # fmt: skip
    title = f"clearance over gear ratio and link length, {found.get('family')}"
    return {"svg": map_figure(title, Map(ratios, lengths, heights), front, design(best)), "family": found.get("family")}


SECTION = ReportSection("hopper-choice", "The chosen leg", content)
MAP = ReportSection("hopper-map", "Clearance over ratio and length", map_content)
