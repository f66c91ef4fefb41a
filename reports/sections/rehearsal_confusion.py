"""The confusion matrix: the diagnosis of each planted cause."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from synth.reports.figures.grid import GridCell, grid_figure
from synth.reports.reading import Result
from synth.reports.section import AbsentResult, ReportSection, mapping, sequence

CELL = 15.0  # px
# Diagnoses that name no cause: ties first, with the planted cause among those that may be there, and without it
VERDICTS = ("tied with others", "tie of others", "none", "unknown", "failed")


def content(result: Result) -> dict[str, Any] | AbsentResult:
    """Rows are planted causes, columns diagnoses; verdicts without a cause come last."""
    rows = [row for row in sequence(result.content, "confusion") if isinstance(row, Mapping) and row.get("cases")]
    if not rows:
        return AbsentResult("no large cause was planted")
    planted = [f"{row['effect']} ({row['joint']})" for row in rows]
    diagnosed = {name for row in rows for name in mapping(row, "diagnoses")}
    others = sorted(diagnosed - {*planted, *VERDICTS})
    columns = [*planted, *others, *(name for name in VERDICTS if name in diagnosed)]
    columns = [name for name in columns if name in diagnosed]
    cells = [[_cell(row, name, true) for name in columns] for row, true in zip(rows, planted, strict=True)]
    names = [name.replace("_", " ") for name in columns]
    figure = grid_figure("Planted and diagnosed", [p.replace("_", " ") for p in planted], names, cells, CELL)
    return {"figure": figure, "rung": sequence(result.content, "rungs")[2]}


def _cell(row: Mapping[str, Any], name: str, true: str) -> GridCell:
    count = mapping(row, "diagnoses").get(name, 0)
    return GridCell(count / row["cases"], str(count) if count else "", framed=name == true)


SECTION = ReportSection("confusion", "Confusion matrix", content, "rehearsal-confusion")
