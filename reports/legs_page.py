"""The page of many designs at once."""

from __future__ import annotations

from pathlib import Path

from synth.reports import page
from synth.reports.openings.many_opening import legs_opening
from synth.reports.reading import read_result
from synth.reports.section import ReportSection
from synth.reports.sections import fits, many_legs

SECTIONS: tuple[ReportSection, ...] = (many_legs.LEGS, many_legs.CHECKS, fits.failed_section("designed"), fits.WARNINGS)


def write_legs_report(folder: Path) -> Path:
    """Write ``report.html`` from ``legs.json``.

    Raises
    ------
    ReportError
        If ``legs.json`` is missing or no result of many designs.
    """
    result = read_result(folder, "legs.json", "legs")
    return page.write_page(result, "Many designed legs", SECTIONS, legs_opening(result))
