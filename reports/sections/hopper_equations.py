"""How the jumping leg's numbers are computed; words and formulas stand in the template."""

from __future__ import annotations

from typing import Any

from synth.reports.reading import Result
from synth.reports.section import ReportSection


def content(result: Result) -> dict[str, Any]:
    """Nothing varies."""
    return {}


SECTION = ReportSection("hopper-equations", "How each number is computed", content)
