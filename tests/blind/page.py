"""The score as one page, ``blind.html``, and as ``blind.json``."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment

from blind.figures import confusion_matrix, reliability_diagram
from blind.score import Answer, Level, Score, confusion, odds, right, shrink_of, strength, true_keys
from blind.views import Key, View
from synth.reports.figures.palette import BLUE, ORANGE, VERMILION

COLOURS = (BLUE, VERMILION, ORANGE)


@dataclass(frozen=True)
class Method:
    """One column of the table: a method's name, its diagnosis of every case, its scores, and its description."""

    name: str
    views: Mapping[str, View]
    scores: Sequence[Score]
    words: str = ""


def write_page(folder: Path, answers: Mapping[str, Answer], methods: Sequence[Method], made: str) -> Path:
    """``blind.html`` and ``blind.json`` in ``folder``; the first method is the tested one."""
    ours = methods[0]
    template = Environment(autoescape=True).from_string(Path(__file__).with_name("blind.html").read_text("utf-8"))
    seconds = [view.seconds for view in ours.views.values() if math.isfinite(view.seconds)]
    page = template.render(
        title=f"The gap: {len(answers)} cases whose effect was withheld",
        opening=_opening(answers, ours, seconds),
        methods=[method.name for method in methods],
        rows=_rows(methods),
        confusion=confusion_matrix(confusion(answers, ours.views)),
        reliability=reliability_diagram(
            [(m.name, odds(answers, m.views), c) for m, c in zip(_with_odds(methods), COLOURS, strict=False)]
        ),
        strengths=_strengths(answers, ours.views),
        failures=_failures(answers, ours.views),
        baselines=[(method.name, method.words) for method in methods[1:]],
        made=made,
    )
    (folder / "blind.html").write_text(page, encoding="utf-8")
    document = {
        "format": "synth/blind/1",
        "cases": len(answers),
        "made": made,
        "scores": {method.name: {score.key: score.as_json() for score in method.scores} for method in methods},
        "confusion": [[*pair, n] for pair, n in sorted(confusion(answers, ours.views).items())],
        "list": {name: _case(answers[name], ours.views[name]) for name in answers},
    }
    (folder / "blind.json").write_text(json.dumps(document, indent=1, allow_nan=False) + "\n")
    return folder / "blind.html"


def _with_odds(methods: Sequence[Method]) -> list[Method]:
    return [m for m in methods if any(score.key == "calibration" for score in m.scores)]


def _opening(answers: Mapping[str, Answer], ours: Method, seconds: Sequence[float]) -> str:
    found = {score.key: score for score in ours.scores}
    levels = [score for score in ours.scores if score.level is not None and score.count]
    goal = sum(score.reached == "goal" for score in levels)
    strong = sum(score.reached in ("goal", "strong") for score in levels)
    time = f" A case takes {np.median(seconds):.0f} s (median)." if len(seconds) else ""
    return (
        f"Of clear single effects {found['top1'].value:.0%} are named first and {found['top3'].value:.0%} are among "
        f"the first three; {goal} of {len(levels)} lines reach the goal, {strong} at least the strong level; "
        f"{sum(not right(a, ours.views[n]) for n, a in answers.items())} of {len(answers)} cases fail in some way."
        f"{time}"
    )


def shown(value: float, unit: str) -> str:
    """A score as shown in the table."""
    if not math.isfinite(value):
        return "–"
    if unit == "%":
        return f"{100 * value:.0f} %"
    return f"{value:+.0f}" if unit == "points" else f"{value:.2f}"


def _rows(methods: Sequence[Method]) -> list[dict[str, Any]]:
    tables = [{score.key: score for score in method.scores} for method in methods]
    rows = []
    for score in methods[0].scores:
        cells = []
        for table in tables:
            mine = table.get(score.key)
            if mine is None or not mine.count:
                cells.append({"value": "–", "interval": ""})
                continue
            low, high = (shown(end, mine.unit).removesuffix(" %") for end in mine.interval)
            cells.append({"value": shown(mine.value, mine.unit), "interval": f"{low} … {high}"})
        level, reached = "", ""
        if score.level is not None:
            level = _levels(score.level, score.unit)
            reached = (score.reached or f"under {score.level.least}") * bool(score.count)
        rows.append({"what": score.what, "count": score.count, "level": level, "reached": reached, "cells": cells})
    return rows


def _levels(level: Level, unit: str) -> str:
    return " / ".join(shown(value, unit).removesuffix(" %") for value in (level.plain, level.strong, level.goal))


def _strengths(answers: Mapping[str, Answer], views: Mapping[str, View]) -> list[dict[str, str]]:
    """Shares of right answers by strength and by effect, for single causes without a rival."""
    single = {name: answer for name, answer in answers.items() if answer["kind"] == "single"}
    groups: dict[str, list[str]] = {}
    for size in sorted({strength(answer) for answer in single.values()}):
        groups[f"{size:g}"] = [name for name, answer in single.items() if strength(answer) == size]
    for true in sorted({true_keys(answer)[0][0] for answer in single.values()}):
        groups[true.replace("_", " ")] = [n for n, a in single.items() if true_keys(a)[0][0] == true]
    rows = []
    for what, names in groups.items():
        effect = sum(views[n].first[0][0] == true_keys(single[n])[0][0] for n in names)
        both = sum(views[n].first[0] == true_keys(single[n])[0] for n in names)
        rows.append({"what": what, "count": str(len(names)), "effect": str(effect), "both": str(both)})
    return rows


def _failures(answers: Mapping[str, Answer], views: Mapping[str, View]) -> list[dict[str, str]]:
    rows = []
    for name, answer in sorted(answers.items(), key=lambda item: (item[1]["kind"], item[0])):
        if right(answer, views[name]):
            continue
        view = views[name]
        likely = [f"{_named(key)} {p:.0%}" for key, p in view.ranked[:3]]
        likely += [f"none {view.none:.0%}"] * (view.none > 0.005) + [f"unknown {view.unknown:.0%}"] * (
            view.unknown > 0.005
        )
        share = _case(answer, view)["shrink_of_best"]
        accepted = " + ".join(_named(key) for key in view.explanation)
        verdict = f"{view.verdict}: {accepted}" if accepted else view.verdict
        if view.tied:
            verdict += " or " + ", ".join(" + ".join(_named(key) for key in keys) for keys in view.tied)
        rows.append(
            {"name": name, "kind": answer["kind"], "truth": _truth(answer), "verdict": verdict,
             "odds": ", ".join(likely), "shrink": "" if share is None else f"{share:.2f}"}
        )  # fmt: skip
    return rows


def _named(key: Key) -> str:
    return f"{key[0].replace('_', ' ')} ({key[1]})"


def _truth(answer: Answer) -> str:
    causes = [f"{_named((e['effect'], e['joint']))}, {e['form']}, {e['reached']:.1f} floors" for e in answer["effects"]]
    rivals = [_named((e, j)) for e, j in answer["cannot_be_told_apart"] if (e, j) not in true_keys(answer)]
    return " + ".join(causes) + (f"; alike: {', '.join(rivals)}" if rivals else "")


def _case(answer: Answer, view: View) -> dict[str, Any]:
    """One case in ``blind.json``."""
    possible = shrink_of(answer["best_possible_deg"], answer["before_deg"], answer["noise_floor_deg"])
    share = None
    if math.isfinite(view.after) and answer["effects"] and possible > 0.05:
        share = round(shrink_of(view.after, answer["before_deg"], answer["noise_floor_deg"]) / possible, 4)
    return {
        "kind": answer["kind"],
        "truth": [list(key) for key in true_keys(answer)],
        "strength": strength(answer),
        "verdict": view.verdict,
        "explanation": [list(key) for key in view.explanation],
        "tied": [[list(key) for key in keys] for keys in view.tied],
        "ranked": [[*key, round(p, 6) if math.isfinite(p) else None] for key, p in view.ranked[:5]],
        "none": round(view.none, 6) if math.isfinite(view.none) else None,
        "unknown": round(view.unknown, 6) if math.isfinite(view.unknown) else None,
        "shrink_of_best": share,
        "right": right(answer, view),
        "seconds": view.seconds if math.isfinite(view.seconds) else None,
    }
