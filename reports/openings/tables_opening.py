"""Pages that are tables foremost: many fits, and the reproduction of the thesis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from markupsafe import Markup

from synth.reports.opening import Cell, Figures, Opening, joined_names
from synth.reports.quantities import text
from synth.reports.reading import Result
from synth.reports.section import AbsentResult, ReportSection, mapping, sequence
from synth.reports.sections.warnings import of_leg

NEXT = "Open a leg's page below; each leg's `fitted.leg.yaml` can be the source of `synth leg`."


def fits_opening(result: Result, across: ReportSection) -> Opening:
    """How many were fitted, how the legs differ, and what failed."""
    legs, failed = sequence(result.content, "legs"), sequence(result.content, "failed")
    warned = sum(bool(of_leg(leg)) for leg in legs)
    found = across.content(result)
    rows, figure, caption = [], Markup(""), ""
    if not isinstance(found, AbsentResult):
        rows = [
            [Cell(f"{row['joint']}, {row['what']}"), Cell(str(row["legs"])), *(Cell(text(end)) for end in row["ends"])]
            for row in found["rows"]
        ]
        if found["figures"]:
            figure, caption = found["figures"][0]["drawing"], found["figures"][0]["title"]
    total = len(legs) + len(failed)
    names = [str(mapping(item).get("name")) for item in failed[:3]]
    more = f" and {len(failed) - 3} more" if len(failed) > 3 else ""
    return Opening(
        f"{len(legs)} of {total} projects {'was' if len(legs) == 1 else 'were'} fitted.",
        f"{warned} of the fits {'has' if warned == 1 else 'have'} warnings."
        if warned
        else "No fit has a warning."
        if legs
        else "",
        [f"Correct {joined_names(names)}{more}, and repeat the command: finished fits are kept."] if failed else [NEXT],
        figure,
        caption,
        Figures(("Rate", "Legs", "Median", "Least", "Greatest"), rows) if rows else None,
        not failed,
        wide=True,
    )


def reproduction_opening(result: Result) -> Opening:
    """Which claims hold, if the tables judge claims, and the reproduced tables."""
    tables = [table for table in sequence(result.content, "tables") if isinstance(table, Mapping)]
    rows = [
        [Cell(str(table.get("name"))), Cell(str(table.get("title"))), Cell(str(len(sequence(table, "rows"))))]
        for table in tables
    ]
    return Opening(
        _answer(tables),
        "Nothing is tuned to the published numbers unless a table says so.",
        ["Open a table below; its last lines explain the differences."],
        figures=Figures(("Table", "Content", "Rows"), rows) if rows else None,
    )


def _answer(tables: Sequence[Mapping[str, Any]]) -> str:
    """How many of the published claims hold and which do not; without claims what the tables compare."""
    judged = [row for table in tables for row in sequence(table, "rows") if "holds" in mapping(row)]
    if judged:
        failed = [str(row["label"]) for row in judged if not row["holds"]]
        but = f"; not: {'; '.join(failed)}" if failed else ""
        return f"{len(judged) - len(failed)} of {len(judged)} published claims hold{but}."
    beside = sum(any("published" in str(head) for head in sequence(table, "columns")) for table in tables)
    return f"{len(tables)} tables, {beside} of them with published values beside ours, and the reasons of differences."
