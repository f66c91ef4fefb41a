"""The page of many fits at once."""

from __future__ import annotations

from pathlib import Path

from synth.reports import page
from synth.reports.openings.tables_opening import fits_opening
from synth.reports.reading import read_result
from synth.reports.section import ReportSection
from synth.reports.sections import fits

SECTIONS: tuple[ReportSection, ...] = (fits.LEGS, fits.ACROSS, fits.FAILED, fits.WARNINGS)


def write_fits_report(folder: Path) -> Path:
    """Write ``report.html`` from ``fits.json``.

    Raises
    ------
    ReportError
        If ``fits.json`` is missing or no result of many fits.
    """
    result = read_result(folder, "fits.json", "fits")
    return page.write_page(result, "Fits of many legs", SECTIONS, fits_opening(result, fits.ACROSS))
