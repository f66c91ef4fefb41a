"""The page of many diagnoses at once."""

from __future__ import annotations

from pathlib import Path

from synth.reports import page
from synth.reports.openings.many_opening import gaps_opening
from synth.reports.reading import read_result
from synth.reports.section import ReportSection
from synth.reports.sections import fits, many_gaps

SECTIONS: tuple[ReportSection, ...] = (
    many_gaps.LEGS,
    many_gaps.CAUSES,
    fits.failed_section("diagnosed"),
    fits.WARNINGS,
)


def write_gaps_report(folder: Path) -> Path:
    """Write ``report.html`` from ``gaps.json``.

    Raises
    ------
    ReportError
        If ``gaps.json`` is missing or no result of many diagnoses.
    """
    result = read_result(folder, "gaps.json", "gaps")
    return page.write_page(result, "Why many legs move differently", SECTIONS, gaps_opening(result))
