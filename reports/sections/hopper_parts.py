"""The flat layers and mounts of the chosen leg."""

from __future__ import annotations

from typing import Any

from synth.reports.figures.hopper_layers import layers_figure
from synth.reports.reading import Result
from synth.reports.section import AbsentResult, ReportSection, mapping


def content(result: Result) -> dict[str, Any] | AbsentResult:
    """Layers, hinges and drawings."""
    parts = mapping(result.content, "parts")
    if not parts:
        return AbsentResult("parts were not requested, or no design was chosen")
    layers = parts.get("layers") or []
    return {"parts": parts, "drawing": layers_figure(layers) if layers else None}


SECTION = ReportSection("hopper-parts", "Parts", content)
