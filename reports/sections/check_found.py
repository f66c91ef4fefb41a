"""Faults of recordings, channels and clocks, with remedies."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from synth.reports.reading import Result
from synth.reports.section import ReportSection, sequence


def content(result: Result) -> dict[str, Any]:
    """Findings, worst first; channels, recordings, ranges and lags as tables."""
    document = result.content
    return {
        "findings": [item for item in sequence(document, "findings") if isinstance(item, Mapping)],
        "channels": sequence(document, "channels"),
        "recordings": sequence(document, "recordings"),
        "coverage": sequence(document, "coverage"),
        "lags": sequence(document, "lags"),
    }


SECTION = ReportSection("found", "Recordings, channels, clocks", content, "check-found")
