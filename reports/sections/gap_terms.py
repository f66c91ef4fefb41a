"""Definitions of the terms on a gap's page."""

from __future__ import annotations

from synth.reports.reading import Result
from synth.reports.section import ReportSection


def content(result: Result) -> dict[str, object]:
    """No data: the terms are the same for every diagnosis."""
    return {}


SECTION = ReportSection("terms", "What the words mean", content)
