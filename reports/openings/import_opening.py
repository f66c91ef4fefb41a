"""The opening of an import's page: what was read, and the resulting leg."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from markupsafe import Markup

from synth.reports import stick_figure
from synth.reports.opening import Cell, Figures, Opening, joined_names
from synth.reports.quantities import text
from synth.reports.reading import Result
from synth.reports.section import AbsentResult, mapping, sequence


def import_opening(result: Result) -> Opening:
    """How many trials, the first as a stick figure, and a row a trial."""
    trials = [trial for trial in sequence(result.content, "trials") if isinstance(trial, Mapping)]
    joints = [str(mapping(joint).get("name")) for joint in sequence(result.content, "leg", "joints")]
    missing = sum(_missing(trial) for trial in trials)
    kept = sum(int(trial.get("samples") or 0) for trial in trials)
    total = sum(int(trial.get("samples_in_source") or 0) for trial in trials)
    notes = sum(len(sequence(trial, "notes")) for trial in trials)
    drawn = stick_figure.content(result)
    figure = Markup("")
    if not isinstance(drawn, AbsentResult):
        figure = next((trial["stick"] for trial in drawn["trials"] if "stick" in trial), Markup(""))
    rows = [
        [
            Cell(str(trial.get("file"))),
            Cell(f"{trial.get('samples')} of {trial.get('samples_in_source')}", stick_figure.missing_words(trial)),
            Cell(text(trial.get("rate"))),
        ]
        for trial in trials[:8]
    ]
    many = f"The first 8 of {len(trials)} trials." if len(trials) > 8 else ""
    return Opening(
        f"{len(trials)} trial{'s' if len(trials) != 1 else ''} of a leg with {joined_names(joints) or 'no joint'}: "
        f"{kept} of {total} samples kept{f', {missing} joint readings in them missing' if missing else ''}.",
        f"{notes} note{'s' if notes != 1 else ''} on what was changed or left out, with each trial below."
        if notes
        else "No sample was changed or left out.",
        [_next(result)],
        figure,
        "Blue: first pose; vermilion: last." if figure else "",
        Figures(("Trial", "Samples kept", "Rate"), rows, many) if rows else None,
    )


def _missing(trial: Mapping[str, Any]) -> int:
    return sum(int(count) for count in mapping(trial, "missing").values())


def _next(result: Result) -> str:
    """What to check, and the command that runs the project beside the page."""
    text = "Check that the leg bends as it did, which shows a wrong sign, side or zero; "
    if result.path("gap.yaml") is None:
        return text + "then run `synth fit fit.yaml --out fit` in this folder."
    return text + "and that each joint follows its command. Then run `synth gap gap.yaml --out gap` in this folder."
