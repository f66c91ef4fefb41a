"""What the words of a gap's page mean."""

from __future__ import annotations

from synth.reports.reading import Result
from synth.reports.section import ReportSection


def content(result: Result) -> dict[str, object]:
    """Nothing: the words are the same for every diagnosis."""
    return {}


SECTION = ReportSection("terms", "What the words mean", content)
