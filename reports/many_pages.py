"""The pages of many projects at once: fits, diagnoses, designs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from synth.reports import page
from synth.reports.opening import Opening
from synth.reports.openings.many_opening import gaps_opening, legs_opening
from synth.reports.openings.tables_opening import fits_opening
from synth.reports.reading import Result, read_result
from synth.reports.section import ReportSection
from synth.reports.sections import fits, many_gaps, many_legs

FITS = (fits.LEGS, fits.ACROSS, fits.FAILED, fits.WARNINGS)
GAPS = (many_gaps.LEGS, many_gaps.CAUSES, fits.failed_section("diagnosed"), fits.WARNINGS)
LEGS = (many_legs.LEGS, many_legs.CHECKS, fits.failed_section("designed"), fits.WARNINGS)


def write_fits_report(folder: Path) -> Path:
    """Write ``report.html`` from ``fits.json``.

    Raises
    ------
    ReportError
        If ``fits.json`` is missing or not a result of many fits.
    """
    return _write(folder, "fits", "Fits of many legs", FITS, lambda result: fits_opening(result, fits.ACROSS))


def write_gaps_report(folder: Path) -> Path:
    """Write ``report.html`` from ``gaps.json``.

    Raises
    ------
    ReportError
        If ``gaps.json`` is missing or not a result of many diagnoses.
    """
    return _write(folder, "gaps", "Why many legs move differently", GAPS, gaps_opening)


def write_legs_report(folder: Path) -> Path:
    """Write ``report.html`` from ``legs.json``.

    Raises
    ------
    ReportError
        If ``legs.json`` is missing or not a result of many designs.
    """
    return _write(folder, "legs", "Many designed legs", LEGS, legs_opening)


def _write(
    folder: Path, kind: str, title: str, sections: Sequence[ReportSection], opening: Callable[[Result], Opening]
) -> Path:
    result = read_result(folder, f"{kind}.json", kind)
    return page.write_page(result, title, sections, opening(result))
