"""The page of many fits at once."""

from __future__ import annotations

from pathlib import Path

from reports import page
from reports.openings.tables_opening import fits_opening
from reports.reading import read_result
from reports.section import ReportSection
from reports.sections import fits

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
