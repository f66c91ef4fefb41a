"""Pages from result files: one self-contained HTML file each. Reads results; imports no other room of ``synth``."""

from __future__ import annotations

from synth.reports.page import write_check_report as write_check_report
from synth.reports.page import write_fit_report as write_fit_report
from synth.reports.page import write_gap_report as write_gap_report
from synth.reports.page import write_import_report as write_import_report
from synth.reports.page import write_leg_report as write_leg_report
from synth.reports.page import write_rehearsal_report as write_rehearsal_report
from synth.reports.reading import ReportError as ReportError
from synth.reports.spring_page import write_winding_sheet as write_winding_sheet

__all__ = [
    "ReportError",
    "write_check_report",
    "write_fit_report",
    "write_gap_report",
    "write_import_report",
    "write_leg_report",
    "write_rehearsal_report",
    "write_winding_sheet",
]
