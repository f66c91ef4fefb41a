"""The chosen jumping leg, the cost of its neighbours, its tolerances, and the map of all designs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from synth.reports.figures.hopper_map import Map, map_figure
from synth.reports.quantities import percent
from synth.reports.reading import Json, Result, value_of
from synth.reports.section import AbsentResult, ReportSection, mapping, sequence

MOST_DESIGNS = 12  # designs of the front in the table


def shown_height(document: Json) -> str:
    """Key of the height that a study is about: the one chosen by, else that of its relative heights."""
    settings = mapping(document, "settings")
    chosen = settings.get("choose")
    if chosen in ("clearance", "total_height"):
        return str(chosen)
    return "total_height" if settings.get("height") == "total" else "clearance"


def content(result: Result) -> dict[str, Any] | AbsentResult:
    """Best design, neighbours with what they cost, tolerances, the front."""
    best = mapping(result.content, "best")
    if not best:
        return AbsentResult("no design was chosen")
    height = shown_height(result.content)
    reference = value_of(best.get(height))
    neighbours = [
        {**item, "off": percent(value_of(item.get(height)), reference)}
        for item in sequence(result.content, "neighbours")
        if isinstance(item, Mapping)
    ]
    front = [item for item in sequence(result.content, "pareto") if isinstance(item, Mapping)]
    step = max(1, -(-len(front) // MOST_DESIGNS))
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
        "height": height.replace("_", " "),
    }


def map_content(result: Result) -> dict[str, Any] | AbsentResult:
    """Clearance or total height over ratio and length."""
    found, height = mapping(result.content, "map"), shown_height(result.content)
    ratios, lengths, heights = (found.get(name) or [] for name in ("gear_ratio", "leg_length_m", f"{height}_m"))
    if not ratios:
        return AbsentResult(str(result.content.get("none_because") or "no design was chosen"))
    if len(lengths) < 2:
        return AbsentResult("there are fewer than two lengths")
    best = mapping(result.content, "best")

    def design(item: Mapping[str, Any]) -> tuple[float, float]:
        return float(item["gear_ratio"]), value_of(item["leg_length"]) or 0.0

    own = str(best.get("motor", "")).rpartition(" ")[0]
    front = [design(item) for item in sequence(result.content, "pareto")
             if isinstance(item, Mapping) and str(item.get("motor", "")).startswith(own)]  # fmt: skip
    title = f"{height.replace('_', ' ')} over gear ratio and link length, {found.get('family')}"
    data = Map(ratios, lengths, heights, found.get("feasible") or ())
    return {
        "svg": map_figure(title, data, front, design(best) if best else None),
        "chosen": bool(best),
        "family": found.get("family"),
        "height": height.replace("_", " ").capitalize(),
    }


SECTION = ReportSection("hopper-choice", "The chosen leg", content)
MAP = ReportSection("hopper-map", "Height over ratio and length", map_content)
