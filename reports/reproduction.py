"""The page of a reproduction: a study's tables, with published values and ours."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from synth.reports import page
from synth.reports.openings.tables_opening import reproduction_opening
from synth.reports.reading import Json, Result, read_result
from synth.reports.section import AbsentResult, ReportSection, mapping, sequence


def write_reproduction_report(folder: Path) -> Path:
    """Write ``report.html`` from ``reproduction.json``.

    Raises
    ------
    ReportError
        If ``reproduction.json`` is missing or not a reproduction.
    """
    result = read_result(folder, "reproduction.json", "reproduction")
    kind = "Published against ours"
    return page.write_page(result, kind, _sections(result), reproduction_opening(result))


def _sections(result: Result) -> tuple[ReportSection, ...]:
    """One section per table, in the result's order, and the inputs."""
    tables = [table for table in sequence(result.content, "tables") if isinstance(table, dict)]
    return (
        *(_section(index, table) for index, table in enumerate(tables)),
        ReportSection("inputs-read", "Inputs", _inputs),
    )


def _section(index: int, table: Json) -> ReportSection:
    def content(result: Result) -> dict[str, Any] | AbsentResult:
        rows = [row for row in sequence(table, "rows") if isinstance(row, dict)]
        return {"table": table, "rows": rows, "index": index} if rows else AbsentResult("no row")

    title = f"{table.get('name')}: {table.get('title')}"
    return ReportSection(f"table-{index + 1}", title, content, "reproduction-table")


def _inputs(result: Result) -> dict[str, Any]:
    return {"inputs": mapping(result.content, "inputs"), "seed": result.content.get("seed")}
