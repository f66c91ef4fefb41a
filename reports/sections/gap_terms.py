"""Definitions of the terms on a gap's page."""

from __future__ import annotations

from synth.reports.reading import Result
from synth.reports.section import ReportSection


def content(result: Result) -> dict[str, object]:
    """The phases are those of a jump, or of a swing; all other terms are the same for every diagnosis."""
    return {"jump": False}


SECTION = ReportSection("terms", "What the words mean", content)
OF_A_JUMP = ReportSection("terms", "What the words mean", lambda result: {"jump": True})
