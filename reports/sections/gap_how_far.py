"""Reduction of the gap: errors before and after on scored trials, and the motions on the same axes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import PurePosixPath
from typing import Any

from markupsafe import Markup

from synth.reports.figures.bars import Bar, BarColumn, bar_figure
from synth.reports.figures.legend import legend
from synth.reports.figures.palette import AFTER, BEFORE, COMMAND, GREEN, ORANGE, PURPLE, RECORDED, SKY, Line
from synth.reports.figures.trials import Curve, TrialPanel, shared_limits, trial_figure
from synth.reports.quantities import brief, interval_of, number, share_text
from synth.reports.reading import Json, Result, value_of
from synth.reports.response_files import Response, extremes, read_response
from synth.reports.section import AbsentResult, FirstFigure, ReportSection, mapping, sequence
from synth.reports.sections.gap_which import leaves_error, name_of, sure_of_none, within_accuracy
from synth.reports.stick_figure import figure_of_trial

STEPS = (
    ("as_designed", "as designed", "the unchanged nominal leg"),
    ("before", "before", "the nominal leg fitted within its tolerances"),
    ("after", "after", "with the explanation"),
    ("best_possible", "best possible", "the best fit with any effects of the library"),
    ("noise_floor", "noise floor", "noise of the sensors"),
)
_LINES = {"command": COMMAND, "measured": RECORDED, "before": BEFORE, "after": AFTER}
MAIN = ((RECORDED, "measured"), (BEFORE, "before: nominal at its best"), (AFTER, "after"))
COMMAND_LEGEND = (COMMAND, "command")  # of a servo
ALONE = (Line(GREEN, 1.5, "8 3"), Line(PURPLE, 1.7, "2 2.5"), Line(ORANGE, 1.7, "8 3 2 3"), Line(SKY, 1.7, "1 3"))
WIDTH, LABEL = 470.0, 110.0  # px


def content(result: Result) -> dict[str, Any] | AbsentResult:
    """Errors as bars and tables, the scored trials as figures."""
    gap = mapping(result.content, "gap")
    if not gap:
        return AbsentResult(f"{result.name} holds no gap")
    trials = [t for t in sequence(result.content, "trials") if isinstance(t, Mapping) and t.get("scored")]
    rms = {str(trial.get("file")): _worst(trial) for trial in trials}
    shown = extremes(list(rms), rms)
    joints = mapping(gap, "joints")
    return {
        "steps": _steps(gap, result.content),
        "figure": _bars(gap),
        "shrink": gap.get("shrink"),
        "of_best": gap.get("shrink_of_best"),
        "joints": [{"name": name, **joint, "noise": mapping(result.content, "noise").get(name)}
                   for name, joint in joints.items()],
        "trials": trials,
        "legend": legend(_main(result, trials), switchable_causes(result)),
        "figures": _figures(result, [trial for trial in trials if str(trial.get("file")) in shown]),
        "total": len(trials),
        "held_out": all(trial.get("held_out") for trial in trials),
        "tied": result.content.get("verdict") == "tie",
        "unknown": result.content.get("verdict") == "unknown",
        "nearest": sequence(result.content, "explanation"),
        "remainder": _remainder(result.content),
        "within": within_accuracy(result.content),
        "left": leaves_error(result.content),
        "worse": (value_of(gap.get("shrink")) or 0.0) < 0.0,
        "fitted": result.content.get("scored_by") == "fitted",
        "explained": result.content.get("verdict") in ("effect", "tie"),
    }  # fmt: skip


def _main(result: Result, trials: Sequence[Mapping[str, Any]]) -> tuple[tuple[Line, str], ...]:
    """Lines and words of the legend; with the command where a servo drives a joint."""
    responses = (read_response(result, str(trial.get("predicted"))) for trial in trials)
    told = any(response is not None and response.joints("command") for response in responses)
    return (*MAIN, COMMAND_LEGEND) if told else MAIN


def _remainder(document: Json) -> Json:
    """What stays unexplained: RMS, shares as text, and the joint and phase that hold most of it.

    A driven leg has no phases of a release.
    """
    left = mapping(document, "remainder")
    if not left:
        return {}
    trials = [trial for trial in sequence(document, "trials") if isinstance(trial, Mapping)]
    kinds = ("joint",) if any(trial.get("driven_by") for trial in trials) else ("joint", "phase")
    where = mapping(left, "where")
    most = [max(each, key=lambda name: each[name]) for key in kinds if (each := mapping(where, key))]
    share, times = left.get("share"), left.get("times_noise")
    return {
        "rms": left.get("rms"),
        "share": f"{100 * share:.0f} %" if isinstance(share, (int, float)) else "–",
        "nothing": not value_of(left.get("rms")),
        "times": number(float(times), 2) if isinstance(times, (int, float)) else "–",
        "where": ", ".join(str(name) for name in most),
    }


def _steps(gap: Json, document: Json) -> list[Json]:
    """Rows of the table; without an accepted explanation, another meaning of ``after``."""
    none = "no effect is missing" if sure_of_none(document) else "no effect was accepted"
    none = "no effect of the library improves it" if leaves_error(document) else none
    verdict = str(document.get("verdict"))
    others = {
        "none": f"the same: {'causes were not judged' if within_accuracy(document) else none}",
        "unknown": "with the nearest explanation, not accepted"
        if sequence(document, "explanation")
        else "the same: no explanation was accepted",
    }
    return [
        {"key": key, "name": name, "what": others.get(verdict, what) if key == "after" else what, "rms": gap.get(key)}
        for key, name, what in STEPS
    ]


def _worst(trial: Mapping[str, Any]) -> float:
    values = [value_of(joint.get("before")) for joint in mapping(trial, "rms").values() if isinstance(joint, Mapping)]
    return max((value for value in values if value is not None), default=0.0)


def _bars(gap: Json) -> Markup:
    """The five errors with their intervals on one axis."""
    bars, labels = [], []
    for key, name, _ in STEPS:
        quantity = gap.get(key)
        value = value_of(quantity)
        if value is None:
            continue
        low, high = interval_of(quantity) or (None, None)
        labels.append(name)
        bars.append(Bar(value, brief(quantity), low, high, strong=key == "after", apart=key == "noise_floor"))
    most = max((max(bar.value, bar.high or 0.0) for bar in bars), default=1.0)
    return bar_figure(
        "RMS angle errors", labels, [BarColumn("RMS angle error on scored trials", bars, most)], WIDTH, LABEL
    )


def _figures(result: Result, trials: list[Mapping[str, Any]]) -> list[Json]:
    """Measured, before and after, and the two errors below; axes of a joint are shared over the trials."""
    found = []
    for trial in trials:
        response = read_response(result, str(trial.get("predicted")))
        if response is not None and (panels := _angles(result, response, trial)):
            found.append((trial, panels, _errors(result, response, trial)))
    limits = shared_limits([panel for _, panels, _ in found for panel in panels])
    error_limits = shared_limits([panel for _, _, panels in found for panel in panels])
    return [
        {
            "trial": str(trial.get("file")),
            "held_out": bool(trial.get("held_out")),
            "svg": trial_figure(f"{trial.get('file')}: measured, before and after", panels, limits, _name(trial)),
            "errors": trial_figure(f"{trial.get('file')}: errors before and after", errors, error_limits, _name(trial)),
        }
        for trial, panels, errors in found
    ]


def worst_figure(result: Result) -> FirstFigure | None:
    """The scored trial and joint with the largest error before: measured, before and after, and what it is."""
    trials = [t for t in sequence(result.content, "trials") if isinstance(t, Mapping) and t.get("scored")]
    for trial in sorted(trials, key=_worst, reverse=True):
        response = read_response(result, str(trial.get("predicted")))
        panels = [] if response is None else _angles(result, response, trial)
        if response is None or not panels:
            continue
        errors = {panel.joint: value_of(mapping(trial, "rms", panel.joint).get("before")) or 0.0 for panel in panels}
        worst = max(panels, key=lambda panel: errors[panel.joint])
        below = [panel for panel in _errors(result, response, trial) if panel.joint == worst.joint]
        upper = trial_figure("measured, before and after", [worst], shared_limits([worst]), _name(trial))
        lower = trial_figure("errors before and after", below, shared_limits(below), _name(trial))
        words = f"{trial.get('file')}, {worst.joint}: the largest error; below, what is left."
        stick = figure_of_trial(result, _name(trial), response.table, "measured")
        return FirstFigure(legend(_main(result, [trial]), switchable_causes(result)) + upper + lower, words, stick)
    return None


def _name(trial: Mapping[str, Any]) -> str:
    """The trial's name, by which its plots know each other."""
    return PurePosixPath(str(trial.get("file"))).stem


def _angles(result: Result, response: Response, trial: Mapping[str, Any]) -> list[TrialPanel]:
    """Measured, before and after; a locked joint, of which nothing was measured, is left out."""
    panels = []
    for joint in response.joints("measured"):
        if response.rms(joint, "measured", "before") is None:
            continue
        error = mapping(trial, "rms", joint)
        remark = f"{brief(error.get('before'))} → {brief(error.get('after'))}" if error else ""
        if (panel := response.panel(joint, _LINES, remark)) is not None:
            more = [Curve(values, line, cause, hidden=True) for cause, line, values in _alone(result, trial, joint)]
            panels.append(replace(panel, curves=[*panel.curves, *more]))
    return panels


def switchable_causes(result: Result) -> list[tuple[Line, str, str]]:
    """Line, curve and words of the single causes that can be switched on beside the scored trials."""
    names: dict[str, None] = {}
    for trial in sequence(result.content, "trials"):
        table = result.table(str(trial.get("alone"))) if isinstance(trial, Mapping) and trial.get("alone") else None
        for column in table.columns if table is not None else ():
            if " with " in column:
                names.setdefault(column.rpartition(" with ")[2])
    odds = {
        f"{entry.get('effect')} @ {entry.get('joint')}": share_text(entry.get("probability"))
        for entry in sequence(result.content, "ranked")
        if isinstance(entry, Mapping)
    }
    return [
        (line, name, f"{_words(name)} alone ({odds.get(name, '–')})") for line, name in zip(ALONE, names, strict=False)
    ]


def _words(name: str) -> str:
    """``coulomb friction, knee`` of ``coulomb_friction @ knee``."""
    effect, _, joint = name.partition(" @ ")
    return name_of({"effect": effect, "joint": joint})


def _alone(result: Result, trial: Mapping[str, Any], joint: str) -> list[tuple[str, Line, Sequence[float]]]:
    """Cause, line and the joint's angles with that cause alone."""
    table = result.table(str(trial.get("alone"))) if trial.get("alone") else None
    if table is None:
        return []
    found = [(line, name, table.columns.get(f"{joint} with {name}")) for line, name, _ in switchable_causes(result)]
    return [(name, line, values) for line, name, values in found if values is not None]


def _errors(result: Result, response: Response, trial: Mapping[str, Any]) -> list[TrialPanel]:
    """Predicted less measured, before and after, for the same joints; switched on too, with single causes."""
    columns, times = response.table.columns, response.table.columns.get("time", [])
    panels = []
    for joint in response.joints("measured"):
        measured = columns[f"{joint} measured"]
        if response.rms(joint, "measured", "before") is None:
            continue
        curves = [
            Curve([x - y for x, y in zip(columns[f"{joint} {kind}"], measured, strict=True)], _LINES[kind], kind)
            for kind in ("before", "after")
        ]
        for cause, line, values in _alone(result, trial, joint):
            away = [x - y for x, y in zip(values, measured, strict=True)]
            curves.append(Curve(away, line, cause, hidden=True))
        panels.append(TrialPanel(joint, response.unit(joint, "measured"), times, curves, "", "error"))
    return panels


SECTION = ReportSection("how-far", "Reduction of the gap", content)
