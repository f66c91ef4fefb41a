"""The study as one page, ``robustness.html``, and as ``robustness.json``."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from statistics import NormalDist
from typing import Any

import numpy as np
from jinja2 import Environment
from markupsafe import Markup

from robustness.numbers import (
    NEAR,
    QUANTITIES,
    TIGHT,
    Line,
    Record,
    estimates,
    exact_lines,
    groups,
    hand_lines,
    hands,
    headline,
    line,
    succeeded,
)
from synth.reports.figures.axes import Axes, AxisScale
from synth.reports.figures.palette import BLUE, GREY, VERMILION
from synth.reports.figures.svg import Svg

COLOURS = (BLUE, VERMILION, "#009e73")
LEVELS = tuple(range(10, 100, 5))


def write_page(folder: Path, records: Sequence[Record], made: str) -> Path:
    """Write both files; the page's path."""
    whole = line("all", [headline(record) for record in records])
    tables = groups(records)
    template = Environment(autoescape=True).from_string(Path(__file__).with_name("robustness.html").read_text("utf-8"))
    page = template.render(
        title=f"How often the fit is right: {len(records)} random legs",
        opening=_opening(whole, records),
        tables=[(title, [_cells(item) for item in lines]) for title, lines in (("All", [whole]), *tables)],
        exact=[_cells(item) for item in exact_lines(records)],
        hand=[_cells(item) for item in hand_lines(records)],
        hands=hands(records),
        failures=_failures(records),
        calibration=_calibration(records),
        errors=_errors(records),
        tight=f"{TIGHT:.0%}",
        near=f"{NEAR:.0%}",
        made=made,
    )
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "robustness.html").write_text(page, encoding="utf-8")
    content = {
        "format": "synth/robustness/1",
        "made": made,
        "all": _plain(whole),
        "tables": {title: [_plain(item) for item in lines] for title, lines in tables},
        "exact": [_plain(item) for item in exact_lines(records)],
        "hand": [_plain(item) for item in hand_lines(records)],
        "hands_seen": hands(records),
        "failures": _failures(records),
    }
    (folder / "robustness.json").write_text(json.dumps(content, indent=1) + "\n")
    return folder / "robustness.html"


def _opening(whole: Line, records: Sequence[Record]) -> str:
    seconds = [headline(r)["cpu"] for r in records if headline(r)["done"]]
    return (
        f"{whole.success:.1%} of {whole.legs} fits succeed; {whole.held:.1%} (± {2 * whole.error:.1%}, two standard "
        f"errors) of {whole.intervals} intervals that claim 90 % hold the truth (target 88 to 92 %); the median error "
        f"is {whole.bias:+.2f} standard deviations. A fit takes {np.median(seconds):.2f} s of one core (median)."
    )


def _cells(item: Line) -> dict[str, str]:
    return {
        "name": item.name,
        "legs": str(item.legs),
        "success": _share(item.success),
        "held": _share(item.held),
        "error": "" if math.isnan(item.error) else f"± {200 * item.error:.1f}",
        "mark": "" if math.isnan(item.held) else "within" if item.within else "outside",
        "bias": "–" if math.isnan(item.bias) else f"{item.bias:+.2f}".replace("-", "−"),
        "rate": "–" if math.isnan(item.rate) else f"{100 * item.rate:.2g} %",
        "width": "–" if math.isnan(item.width) else f"± {100 * item.width:.2g} %",
    }


def _share(value: float) -> str:
    return "–" if math.isnan(value) else f"{100 * value:.1f} %"


def _plain(item: Line) -> dict[str, Any]:
    return {key: None if isinstance(v, float) and math.isnan(v) else v for key, v in asdict(item).items()}


def _failures(records: Sequence[Record]) -> list[str]:
    found = []
    for record in records:
        fit = headline(record)
        if not succeeded(fit):
            why = f"leaves {math.exp(fit['over']) - 1:.0%} more than the true leg" if fit["done"] else fit["message"]
            found.append(
                f"seed {record['seed']}: {why} ({len(record['joints'])} links, {record['trials']} trials, "
                f"{record['noise']:.2f} deg, {record['counts']} counts, {record['rate']:.0f} Hz"
                f"{', 5 % lost' if record['lost'] else ''}{', driven' if record['driven'] else ''})"
            )
    return found


def _calibration(records: Sequence[Record]) -> Markup:
    """Coverage of the intervals over their nominal level."""
    svg = Svg(430, 330, "Share of intervals that hold the truth over the level that they claim")
    axes = Axes(AxisScale(0, 100, 50, 420), AxisScale(0, 100, 290, 12))
    axes.frame(svg)
    svg.line((axes.x(0), axes.y(0)), (axes.x(100), axes.y(100)), f'stroke="{GREY}" stroke-width="1"')
    for (name, words), colour in zip(QUANTITIES.items(), COLOURS, strict=True):
        scores = np.array(
            [
                abs(error) / max((high - low) / 2, 1e-12) * NormalDist().inv_cdf(0.95)
                for record in records
                for _, error, low, high in estimates(headline(record), [name])
            ]
        )
        points = [(lv, 100 * float(np.mean(scores < NormalDist().inv_cdf(0.5 + lv / 200)))) for lv in LEVELS]
        place = axes.points(points)
        svg.polyline(place, f'stroke="{colour}" stroke-width="1.6"')
        svg.dots(place, 5, colour)
        row = 30 + 16 * list(QUANTITIES).index(name)
        svg.text((62, row), words, f'font-size="12" fill="{colour}"')
    svg.text((235, 324), "level claimed, %", f'text-anchor="middle" font-size="11" fill="{GREY}"')
    middle = f'text-anchor="middle" transform="rotate(-90 12 150)" font-size="11" fill="{GREY}"'
    svg.text((12, 150), "hold the truth, %", middle)
    return svg.markup


def _errors(records: Sequence[Record]) -> Markup:
    """Each rate's error over its interval's half-width."""
    svg = Svg(430, 330, "Error of each rate over the half-width of its interval")
    ends = (2e-4, 3.0)
    axes = Axes(AxisScale(*ends, 60, 420, logarithmic=True), AxisScale(2e-5, 3.0, 290, 12, logarithmic=True))
    axes.frame(svg)
    at = [(x, axes.x(x), axes.y(x)) for x in ends]
    svg.line((at[0][1], at[0][2]), (at[1][1], at[1][2]), f'stroke="{GREY}" stroke-width="1"')
    for name, colour in zip(("spring_rate", "damper_rate"), COLOURS, strict=False):
        points = [
            (axes.x(min(max((high - low) / 2, ends[0]), ends[1])), axes.y(min(max(abs(error), 2e-5), 3.0)))
            for record in records
            for _, error, low, high in estimates(headline(record), [name])
        ]
        svg.dots(points, 2.6, colour)
    svg.text((240, 324), "half-width of the 90 % interval, share", f'text-anchor="middle" font-size="11" fill="{GREY}"')
    svg.text(
        (14, 150), "error, share", f'text-anchor="middle" transform="rotate(-90 14 150)" font-size="11" fill="{GREY}"'
    )
    return svg.markup
