"""Measured against fitted motion, trial by trial, and the response characteristics."""

from __future__ import annotations

import math
from pathlib import PurePosixPath
from typing import Any

from markupsafe import Markup

from synth.reports.figures.legend import legend
from synth.reports.figures.palette import FITTED, RECORDED
from synth.reports.figures.trials import shared_limits, trial_figure
from synth.reports.quantities import brief, number, unit_text
from synth.reports.reading import Json, Result, value_of
from synth.reports.response_files import MOST_TRIALS, Response, extremes, file_of, read_response
from synth.reports.section import AbsentResult, FirstFigure, ReportSection, fit_key, fit_of, mapping, sequence
from synth.reports.stick_figure import figure_of_trial

FOLDER = "responses/source"
_LINES = {"measured": RECORDED, "fitted": FITTED}
# Of a motion that is given by its figures, which nobody measured; its column in the response file is the same.
_CALLED = {"measured": "wanted"}
_CHARACTERISTICS = ("rise_time", "damping_ratio", "damped_frequency", "overshoot", "settling_time", "initial_rate")


def content(result: Result) -> dict[str, Any] | AbsentResult:
    """Figures of the trials to show and the table of all."""
    fit = fit_of(result)
    trials = [trial for trial in sequence(fit, "trials") if isinstance(trial, dict)]
    files = result.files(FOLDER)
    if not trials and not files:
        return AbsentResult(f"{result.name} names no trial and there is no file in {FOLDER}")
    if not trials:
        trials = [{"file": file} for file in files]
    names = [str(trial.get("file")) for trial in trials]
    shown = extremes(names, {name: _error(trial) for name, trial in zip(names, trials, strict=True)})
    responses = {name: _response(result, name, files) for name in shown}
    joints = list(mapping(fit, "joints")) or _joints(responses)
    rows, notes = _table(trials, joints)
    out = mapping(result.content, "held_out")
    given, called = _given(fit)
    scored_by = mapping(result.content, "stages", "target") or fit  # the fit whose leg predicts them
    return {
        "figures": _figures({str(trial.get("file")): trial for trial in trials}, responses, joints, called),
        "absent": [name for name, response in responses.items() if response is None],
        "section_title": f"{given.capitalize()} against fitted motion",
        "given": given,
        "legend": _legend(given),
        "folder": FOLDER,
        "total": len(trials),
        "shown": len(shown),
        "rows": [row for row in rows if row["trial"] in shown],
        "rest": [row for row in rows if row["trial"] not in shown] if len(trials) > MOST_TRIALS else [],
        "notes": notes,
        "prefix": fit_key(result),
        "held_out": out,
        "own_free_angles": mapping(scored_by, "free_angle").get("mode") == "per_trial",
        "joints": joints,
    }


def worst_figure(result: Result) -> FirstFigure | None:
    """The trial that fits worst, and what it is; None where no response is in the folder."""
    fit, files = fit_of(result), result.files(FOLDER)
    given, called = _given(fit)
    trials = [trial for trial in sequence(fit, "trials") if isinstance(trial, dict)]
    known = [trial for trial in trials if math.isfinite(_error(trial))]
    for trial in sorted(known, key=_error, reverse=True):
        name = str(trial.get("file"))
        response = _response(result, name, files)
        joints = list(mapping(fit, "joints"))
        found = _figures({name: trial}, {name: response}, joints, called) if response else []
        if found and response is not None:
            many = f" of {len(trials)}" if len(trials) > 1 else ""
            stem = PurePosixPath(name).stem
            stick = (
                figure_of_trial(result, stem, response.table, "measured", given)
                if "stages" not in result.content
                else Markup("")
            )
            caption = f"{name}." if called else f"{name}: the trial{many} that fits worst."
            return FirstFigure(_legend(given) + Markup(found[0]["svg"]), caption, stick)
    return None


def _given(fit: Json) -> tuple[str, dict[str, str]]:
    """What the motion is that was fitted, and how its column is called: ``wanted`` where it is given by figures."""
    called = _CALLED if mapping(fit, "wanted") else {}
    return called.get("measured", "measured"), called


def _legend(given: str) -> Markup:
    return legend([(RECORDED, given), (FITTED, "fitted")])


def _error(trial: Json) -> float:
    values = [value for q in mapping(trial, "rms").values() if (value := value_of(q)) is not None]
    return math.sqrt(sum(value**2 for value in values) / len(values)) if values else math.inf


def _response(result: Result, trial: str, files: list[str]) -> Response | None:
    file = file_of(trial, files)
    return None if file is None else read_response(result, file)


def _joints(responses: dict[str, Response | None]) -> list[str]:
    return list(dict.fromkeys(joint for r in responses.values() if r for joint in r.joints("measured")))


def _figures(
    trials: dict[str, Json], responses: dict[str, Response | None], joints: list[str], called: dict[str, str]
) -> list[Json]:
    found, given = [], called.get("measured", "measured")
    for name, response in responses.items():
        if response is None:
            continue
        panels = []
        for joint in joints:
            stated = mapping(trials[name], "rms").get(joint)
            own = response.rms(joint, "measured", "fitted")
            unit = unit_text(response.unit(joint, "fitted"))
            remark = (
                f"rms {brief(stated)}" if stated else ("" if own is None else f"rms {number(own, 3, bare=False)}{unit}")
            )
            if (panel := response.panel(joint, _LINES, remark, called)) is not None:
                panels.append(panel)
        if panels:
            found.append((name, response, panels))
    limits = shared_limits([panel for _, _, panels in found for panel in panels])
    return [
        {
            "trial": name,
            "file": response.file,
            "held_out": bool(trials[name].get("held_out")),
            "svg": trial_figure(f"{name}: {given} and fitted angles", panels, limits, PurePosixPath(name).stem),
        }
        for name, response, panels in found
    ]


def _table(trials: list[Json], joints: list[str]) -> tuple[list[Json], list[str]]:
    """Rows by trial and joint, and the remarks that their letters stand for."""
    rows: list[Json] = []
    notes: list[str] = []
    for trial in trials:
        for joint in joints:
            validity = mapping(trial, "damping_ratio_validity").get(joint)
            if validity and validity != "valid" and validity not in notes:
                notes.append(str(validity))
            row: Json = {key: mapping(trial, key).get(joint) for key in (*_CHARACTERISTICS, "rms", "free_angle")}
            row |= {"trial": str(trial.get("file")), "joint": joint, "held_out": bool(trial.get("held_out"))}
            row["note"] = notes.index(str(validity)) + 1 if validity in notes else None
            row["first"] = not rows or rows[-1]["trial"] != row["trial"]
            if any(row[key] is not None for key in (*_CHARACTERISTICS, "rms")):
                rows.append(row)
    return rows, notes


SECTION = ReportSection("motion", "Measured against fitted motion", content)
