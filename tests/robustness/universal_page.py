"""The comparison of costs as one page, ``universal.html``, and as ``universal.json``."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment
from markupsafe import Markup

from robustness.universal import AS_IN_THE_THESIS, CONTESTANTS, FOLLOWED, OURS, Share, groups, legs_followed
from synth.reports.figures.axes import Axes, AxisScale
from synth.reports.figures.palette import BLUE, GREY, VERMILION
from synth.reports.figures.svg import Svg

COLOURS = dict(zip(CONTESTANTS, (BLUE, "#009e73", "#56b4e9", VERMILION, "#cc79a7", "#e69f00"), strict=True))
LEAST, MOST = 1e-3, 10.0


def write_page(results: Sequence[dict[str, Any]], folder: Path) -> Path:
    """Write both files; the page's path."""
    shares, legs = groups(results), legs_followed(results)
    template = Environment(autoescape=True).from_string(Path(__file__).with_name("universal.html").read_text("utf-8"))
    page = template.render(
        title=f"One cost for every response: {len(results)} random legs",
        sentences=sentences(results, shares, legs),
        contestants=CONTESTANTS,
        groups=[
            {"name": name, "joints": found[OURS].joints, "cells": [_cell(found[c]) for c in CONTESTANTS]}
            for name, found in shares.items()
        ],
        legs=[f"{legs[name]} of {len(results)}" for name in CONTESTANTS],
        figure=_figure(results),
        followed=f"{FOLLOWED:.0%}",
        worse=_worse(results),
    )
    folder.mkdir(parents=True, exist_ok=True)
    target = folder / "universal.html"
    target.write_text(page, encoding="utf-8")
    content = {
        "format": "synth/universal/1",
        "legs": len(results),
        "legs_followed": legs,
        "groups": {name: {c: _plain(share) for c, share in found.items()} for name, found in shares.items()},
        "results": list(results),
    }
    (folder / "universal.json").write_text(json.dumps(content, indent=1) + "\n", encoding="utf-8")
    return target


def sentences(
    results: Sequence[dict[str, Any]], shares: dict[str, dict[str, Share]], legs: dict[str, int]
) -> list[str]:
    """Sentences on the figures: ours first, then the others in comparison, each with its worst group."""
    count = len(results)
    said = [
        f"Ours follows every joint of {legs[OURS]} of {count} legs within {FOLLOWED:.0%} of its swing, without being "
        f"told anything; {_weakest(shares, OURS)}."
    ]
    for name in CONTESTANTS[1:]:
        given = (
            "its starts and free angles read off the recordings"
            if name == AS_IN_THE_THESIS
            else "with all else given and begun at the truth"
        )
        said.append(f"{name[0].upper()}{name[1:]}, {given}: {legs[name]} of {count} legs; {_weakest(shares, name)}.")
    said.append(
        "Trajectory and transient are squares of angle errors, as ours is: such a cost needs no choice by joint or by "
        "response. What ours adds is that starts and free angles need not be given, nor a place to begin; set as the "
        f"thesis sets them, the same cost follows {legs[AS_IN_THE_THESIS]} of {count} legs."
    )
    return said


def _weakest(shares: dict[str, dict[str, Share]], name: str) -> str:
    """The group with the least share of followed joints."""
    held = {label: found[name] for label, found in shares.items() if found[name].joints and label != "all joints"}
    label, share = min(held.items(), key=lambda item: item[1].followed / item[1].joints)
    if share.followed == share.joints:
        return "every joint of every kind is followed"
    return f"at its weakest with {label} ({share.followed} of {share.joints} joints followed)"


def _worse(results: Sequence[dict[str, Any]]) -> list[str]:
    """Legs that ours does not follow, with the methods that do."""
    lost = []
    for result in results:
        ours = result["errors"][OURS]
        if ours is not None and max(ours) <= FOLLOWED:
            continue
        others = [n for n in CONTESTANTS[1:] if result["errors"][n] and max(result["errors"][n]) <= FOLLOWED]
        off = "no fit" if ours is None else f"{100 * max(ours):.1f} % off"
        lost.append(
            f"seed {result['seed']}: {off}, {result['joints']} links, {result['trials']} trials, {result['noise']:.2f} "
            f"deg noise, {result['counts']} counts; followed by {', '.join(others) or 'none'}"
        )
    return lost


def _cell(share: Share) -> dict[str, str]:
    if not share.joints:
        return {"followed": "–", "median": ""}
    return {
        "followed": f"{100 * share.followed / share.joints:.1f} %",
        "median": f"{100 * share.median:.2g} %, {100 * share.worst:.2g} %".replace(" %", "\u00a0%"),
    }


def _plain(share: Share) -> dict[str, Any]:
    return {key: None if isinstance(v, float) and math.isnan(v) else v for key, v in asdict(share).items()}


def _figure(results: Sequence[dict[str, Any]]) -> Markup:
    """Share of joints over their error, one line per method."""
    svg = Svg(760, 380, "Share of joints that are followed within an error, by cost")
    axes = Axes(AxisScale(LEAST, MOST, 55, 750, logarithmic=True), AxisScale(0, 100, 330, 12))
    axes.frame(svg)
    svg.line((axes.x(FOLLOWED), 12), (axes.x(FOLLOWED), 330), f'stroke="{GREY}" stroke-width="1"')
    for index, name in enumerate(CONTESTANTS):
        errors = [e for r in results for e in (r["errors"][name] or [MOST] * r["joints"])]
        order = np.sort(np.clip(errors, LEAST, MOST))
        share = 100 * np.arange(1, len(order) + 1) / len(order)
        svg.polyline(axes.points(list(zip(order, share, strict=True))), f'stroke="{COLOURS[name]}" stroke-width="1.8"')
        svg.text((66, 28 + 16 * index), name, f'font-size="12" fill="{COLOURS[name]}"')
    svg.text((400, 370), "error on a fresh release, share of the joint's swing", f'text-anchor="middle" fill="{GREY}"')
    middle = f'text-anchor="middle" transform="rotate(-90 14 170)" fill="{GREY}"'
    svg.text((14, 170), "joints within it, %", middle)
    return svg.markup
