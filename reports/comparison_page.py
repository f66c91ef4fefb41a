"""The page of a comparison: legs and recordings side by side."""

from __future__ import annotations

from pathlib import Path

from synth.reports import page
from synth.reports.openings.comparison_opening import comparison_opening
from synth.reports.reading import read_result
from synth.reports.section import ReportSection
from synth.reports.sections import compared

SECTIONS: tuple[ReportSection, ...] = (compared.RESPONSES, compared.PARAMETERS, compared.DIFFERENCES, compared.ORIGINS)


def write_comparison_report(folder: Path) -> Path:
    """Write ``report.html`` from ``compare.json`` and ``responses/*.csv``.

    Raises
    ------
    ReportError
        If ``compare.json`` is missing or not a comparison.
    """
    result = read_result(folder, "compare.json", "compare")
    return page.write_page(result, "Side by side", SECTIONS, comparison_opening(result))
