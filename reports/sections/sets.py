"""The chosen set of parts and the next best within tolerances: the forecast response, and its causes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from markupsafe import Markup

from synth.reports.figures.bars import Bar, BarColumn, bar_figure
from synth.reports.forecast_condition import assumed_laws_words
from synth.reports.opening import joined_names
from synth.reports.quantities import brief, interval_of, share_text, text
from synth.reports.reading import Json, Result, value_of
from synth.reports.section import AbsentResult, ReportSection, mapping, sequence

CAUSES_SHOWN = 6  # causes
WIDTH, LABEL = 760.0, 80.0  # px


def content(result: Result) -> dict[str, Any] | AbsentResult:
    """Sets with their expected error, its interval and probability; causes of the spread; record of the search."""
    response = mapping(result.content, "response")
    forecast = mapping(response, "forecast")
    if not forecast:
        return AbsentResult("design.json has no forecast of the response under tolerances")
    joints = list(mapping(result.content, "joints"))
    others = [
        {**item, "free_angles_measured": mapping(item, "free_angles_measured")}
        for item in sequence(response, "alternatives")
        if isinstance(item, Mapping) and "expected" in item
    ]
    measured = mapping(response, "forecast_free_angles_measured")
    chosen = {"parts": _parts(result.content), "rms": mapping(response, "wanted_to_built").get("rms"), **forecast}
    chosen["free_angles_measured"] = measured
    known = [name for name in joints if name in sequence(response, "free_angles_measured")]
    return {
        "joints": joints,
        "sets": [chosen, *others],
        "within": forecast.get("within"),
        "figure": _figure([chosen, *others]),
        "causes": _causes(forecast),
        "measured": measured,
        "assumed": assumed_laws_words(forecast),
        "assumed_measured": assumed_laws_words(measured),
        "known": joined_names(known),
        "to_measure": joined_names([name for name in joints if name not in known]),
        "open": mapping(response, "fit_uncertainty"),
        "measured_causes": _causes(measured),
        "search": mapping(response, "search"),
        "tolerances": [
            {"joint": name, **mapping(joint, "tolerance")}
            for name, joint in mapping(result.content, "joints").items()
            if mapping(joint, "tolerance")
        ],
    }


def _parts(document: Json) -> Json:
    """The chosen spring and damper of each joint, in the words of the other sets."""
    found = {}
    for name, joint in mapping(document, "joints").items():
        spring, damper = mapping(joint, "spring"), mapping(joint, "damper")
        count = value_of(spring.get("count")) or spring.get("count") or 1
        make = mapping(spring, "make")
        words = spring.get("part") or f"wind {text(make.get('wire_diameter'))} {make.get('material') or 'wire'}"
        count = make.get("count") or count
        if isinstance(count, (int, float)) and count > 1:
            words = f"{count:g} x {words}"
        found[name] = {"spring": words, "damper": damper.get("arrangement") or damper.get("part") or "–"}
    return found


def _causes(forecast: Json) -> list[Json]:
    """The largest causes of the spread, and all others as one."""
    causes = [cause for cause in sequence(forecast, "causes") if isinstance(cause, Mapping)]
    shown = [
        {
            **cause,
            "words": str(cause["cause"]) if cause.get("joint") == "all" else f"{cause['joint']}: {cause['cause']}",
        }
        for cause in causes[:CAUSES_SHOWN]
        if "joint" in cause and "cause" in cause
    ]
    return [cause for cause in shown if (value_of(cause.get("share")) or 0.0) >= 0.005]  # rounds to 1 % at least


def _figure(sets: list[Json]) -> Markup | None:
    """Expected errors with their 90 % intervals, the chosen set first."""
    bars, labels, most = [], [], 0.0
    for index, item in enumerate(sets):
        expected = item.get("expected")
        value, interval = value_of(expected), interval_of(expected)
        if value is None or interval is None or None in interval:
            return None
        low, high = interval
        assert low is not None
        assert high is not None
        most = max(most, high)
        chance = share_text(item.get("chance"))
        bars.append(Bar(value, f"{brief(expected)}, {chance}", low, high, strong=index == 0))
        labels.append("chosen" if index == 0 else f"set {index + 1}")
    heading = "expected response error with its 90 % interval, and the probability of staying within the limit"
    return bar_figure("Sets of parts under tolerance", labels, [BarColumn(heading, bars, most, 130.0)], WIDTH, LABEL)


SECTION = ReportSection("sets", "Sets of parts under tolerance", content)
