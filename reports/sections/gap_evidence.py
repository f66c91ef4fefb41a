"""Evidence for each of the most probable causes: the error with it by joint, and the trials for and against it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from synth.reports.quantities import number, unit_text
from synth.reports.reading import Result
from synth.reports.response_files import Response, read_response
from synth.reports.section import AbsentResult, ReportSection, sequence
from synth.reports.sections.gap_how_far import switchable_causes

ANGLES = ("deg", "rad")  # units of the channels by which trials are counted; a ground force is shown only
UNCHANGED_ERROR = 0.02  # relative change of a trial's error below which it is no evidence: a line's width in the plot


@dataclass
class _Squares:
    """Sums of squared errors and their count, before and with the cause."""

    before: float = 0.0
    alone: float = 0.0
    count: int = 0

    def add(self, other: _Squares) -> None:
        self.before, self.alone = self.before + other.before, self.alone + other.alone
        self.count += other.count

    def rms(self) -> tuple[float, float]:
        """Before, and with the cause."""
        return math.sqrt(self.before / max(1, self.count)), math.sqrt(self.alone / max(1, self.count))


@dataclass
class _Evidence:
    """One cause: squares by channel, and of each trial the angles' errors before and with it."""

    channels: dict[str, _Squares] = field(default_factory=dict)
    trials: dict[str, tuple[float, float]] = field(default_factory=dict)


def content(result: Result) -> dict[str, Any] | AbsentResult:
    """A row a cause; channels in columns."""
    causes = switchable_causes(result)
    found = {name: _Evidence() for _, name, _ in causes}
    units: dict[str, str] = {}
    for trial in sequence(result.content, "trials"):
        if isinstance(trial, Mapping) and trial.get("scored") and trial.get("alone"):
            _add_trial(result, trial, found, units)
    rows = [_row(words, found[name], list(units)) for _, name, words in causes if found[name].trials]
    if not rows:
        return AbsentResult("no single cause was predicted on the scored trials")
    return {"rows": rows, "channels": [f"{name} [{unit_text(unit)}]" for name, unit in units.items()]}


def _add_trial(result: Result, trial: Mapping[str, Any], found: Mapping[str, _Evidence], units: dict[str, str]) -> None:
    response = read_response(result, str(trial.get("predicted")))
    table = result.table(str(trial.get("alone")))
    if response is None or table is None:
        return
    for cause, evidence in found.items():
        angles = _Squares()
        for channel in response.joints("measured"):
            values = table.columns.get(f"{channel} with {cause}")
            squares = None if values is None else _squares(response, channel, values)
            if squares is None or not squares.count:
                continue
            units[channel] = response.unit(channel, "measured")
            evidence.channels.setdefault(channel, _Squares()).add(squares)
            if units[channel] in ANGLES:
                angles.add(squares)
        if angles.count:
            evidence.trials[str(trial.get("file"))] = angles.rms()


def _squares(response: Response, channel: str, values: Sequence[float]) -> _Squares:
    columns, sums = response.table.columns, _Squares()
    measured, before = columns[f"{channel} measured"], columns.get(f"{channel} before", [])
    for m, b, a in zip(measured, before, values, strict=False):
        if math.isfinite(m) and math.isfinite(b) and math.isfinite(a):
            sums.add(_Squares((b - m) ** 2, (a - m) ** 2, 1))
    return sums


def _row(words: str, evidence: _Evidence, channels: Sequence[str]) -> dict[str, Any]:
    """Errors by channel, numbers of trials that are better and worse with it, and the two largest changes."""
    gains = {name: 1.0 - alone / before for name, (before, alone) in evidence.trials.items() if before > 0.0}
    most = max(gains, key=lambda name: gains[name], default="")
    least = min(gains, key=lambda name: gains[name], default="")
    return {
        "cause": words,
        "errors": [_change(evidence.channels.get(channel)) for channel in channels],
        "better": sum(gain > UNCHANGED_ERROR for gain in gains.values()),
        "worse": sum(gain < -UNCHANGED_ERROR for gain in gains.values()),
        "trials": len(gains),
        "most_for": f"{most}: {_percent(-gains[most])}" if most and gains[most] > UNCHANGED_ERROR else "–",
        "most_against": f"{least}: {_percent(-gains[least])}" if least and gains[least] < -UNCHANGED_ERROR else "–",
    }


def _change(squares: _Squares | None) -> str:
    if squares is None:
        return "–"
    before, alone = squares.rms()
    return f"{number(before, 2)} → {number(alone, 2)}"


def _percent(share: float) -> str:
    return f"{100.0 * share:+.0f}\u00a0%".replace("-", "\u2212")


SECTION = ReportSection("evidence", "Evidence, cause by cause", content)
