"""What the words of a gap's page mean."""

from __future__ import annotations

from reports.reading import Result
from reports.section import ReportSection


def content(result: Result) -> dict[str, object]:
    """Nothing: the words are the same for every diagnosis."""
    return {}


SECTION = ReportSection("terms", "What the words mean", content)
