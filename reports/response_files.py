"""Response tables as panels: one trial's angles, measured against fitted or wanted against built."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePosixPath

from synth.reports.figures.palette import Line
from synth.reports.figures.trials import Curve, TrialPanel
from synth.reports.reading import Result, ResultTable

MOST_TRIALS = 12  # shown; of more, the best and the worst
BEST, WORST = 4, 8  # responses drawn: all up to the sum, else the best and the worst


@dataclass(frozen=True)
class Response:
    """A response file: the trial's name and its table."""

    name: str
    file: str
    table: ResultTable

    def joints(self, kind: str) -> list[str]:
        """Names of the joints that have a column of this kind."""
        ending = f" {kind}"
        return [name.removesuffix(ending) for name in self.table.columns if name.endswith(ending)]

    def rms(self, joint: str, first: str, second: str) -> float | None:
        """Root mean square of the difference of two kinds of one joint, in its column's unit; empty cells left out."""
        columns = self.table.columns
        a, b = columns.get(f"{joint} {first}"), columns.get(f"{joint} {second}")
        if a is None or b is None:
            return None
        squares = [(x - y) ** 2 for x, y in zip(a, b, strict=True) if math.isfinite(x) and math.isfinite(y)]
        return math.sqrt(sum(squares) / len(squares)) if squares else None

    def unit(self, joint: str, kind: str) -> str:
        """The column's unit."""
        return self.table.units.get(f"{joint} {kind}", "")

    def panel(
        self, joint: str, lines: Mapping[str, Line], remark: str, called: Mapping[str, str] | None = None
    ) -> TrialPanel | None:
        """One joint's panel: a curve for each existing kind; None without time or any curve.

        ``called`` : kind -> its curve's name, where that is another.
        """
        times = self.table.columns.get("time", [])
        kinds = [kind for kind in lines if f"{joint} {kind}" in self.table.columns]
        if len(times) < 2 or not kinds:
            return None
        names = {**{kind: kind for kind in kinds}, **(called or {})}
        curves = [Curve(self.table.columns[f"{joint} {kind}"], lines[kind], names[kind]) for kind in kinds]
        unit = self.unit(joint, kinds[0])
        return TrialPanel(joint, unit, times, curves, remark, "angle" if unit in ("deg", "rad") else "")


def read_response(result: Result, file: str) -> Response | None:
    """A response file by its relative path."""
    table = result.table(file)
    return None if table is None else Response(PurePosixPath(file).stem, file, table)


def file_of(trial: str, files: Sequence[str]) -> str | None:
    """The response file of a trial: named by the trial's stem, or by its path with the folders in the name."""
    stem = PurePosixPath(trial).stem
    whole = PurePosixPath(trial).with_suffix("").as_posix()
    wanted = [whole.replace("/", mark) for mark in ("_", "-", "__", "/")] + [stem]
    for name in wanted:
        for file in files:
            if PurePosixPath(file).stem == name:
                return file
    return None


def extremes(names: Sequence[str], error: Mapping[str, float]) -> list[str]:
    """The trials to show, in their order: all, or of many those with the worst and the best fit."""
    if len(names) <= MOST_TRIALS:
        return list(names)
    ranked = sorted(names, key=lambda name: (-error.get(name, math.inf), name))
    kept = {*ranked[:WORST], *ranked[-BEST:]}
    return [name for name in names if name in kept]
