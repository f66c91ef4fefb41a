"""Inseparable causes: groups, the trials that would separate them, and the angles between all responses."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from synth.reports.figures.grid import GridCell, grid_figure
from synth.reports.quantities import number
from synth.reports.reading import Result
from synth.reports.section import AbsentResult, ReportSection, sequence

CELL = 11.0  # px


def name_of(cause: Mapping[str, Any]) -> str:
    """Effect and place in words."""
    return f"{str(cause.get('effect')).replace('_', ' ')}, {cause.get('joint')}"


def content(result: Result) -> dict[str, Any] | AbsentResult:
    """Groups with their remedies, and the grid."""
    causes = [item for item in sequence(result.content, "causes") if isinstance(item, Mapping)]
    sines = sequence(result.content, "sines")
    if not causes:
        return AbsentResult("a fault must be corrected first")
    names = [name_of(cause) for cause in causes]
    rows = [f"{name}  {index}" for index, name in enumerate(names, start=1)]
    heads = [str(index) for index in range(1, len(names) + 1)]
    cells = [
        [GridCell(0.0 if r == c else 1.0 - float(sines[r][c])) for c in range(len(names))] for r in range(len(names))
    ]
    groups = []
    for group in sequence(result.content, "not_told_apart"):
        members = [name_of(cause) for cause in sequence(group, "causes")]
        times = {"times": _times(group.get("sine")), "then": _times(group.get("sine_with_trial"))}
        groups.append({"names": members, "remedy": group.get("remedy")} | times)
    return {"groups": groups, "figure": grid_figure("Similarity of the causes", rows, heads, cells, CELL)}


def _times(sine: object) -> str:
    """Factor over the smallest visible size from which a cause differs from the most similar one."""
    value = float(sine) if isinstance(sine, (int, float)) else 0.0
    return f"{number(1.0 / value, 2)}" if value > 0.02 else "more than 50"  # 1 / 50


SECTION = ReportSection("apart", "Inseparable causes", content, "check-apart")
