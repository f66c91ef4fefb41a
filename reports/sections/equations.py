"""How each number is computed: the equations, what they stand for, and where they come from.

They are words and formulas, so they stand in the template; the other sections refer to them by name (``E1`` ...).
"""

from __future__ import annotations

from typing import Any

from synth.reports.reading import Result
from synth.reports.section import ReportSection


def content(result: Result) -> dict[str, Any]:
    """All equations for a design, those of the estimation for a fit."""
    return {"design": "stages" in result.content}


SECTION = ReportSection("equations", "How each number is computed", content)
