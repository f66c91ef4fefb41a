"""The chosen leg by every model, and leaning."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from synth.reports.figures.model_bars import ModelBar, models_figure
from synth.reports.reading import Result, value_of
from synth.reports.section import AbsentResult, ReportSection, mapping, sequence
from synth.reports.sections.hopper_choice import shown_height

EVEN = 0.01  # of a height: the two engines differ by as much with one law


def content(result: Result) -> dict[str, Any] | AbsentResult:
    """A figure and a table of the ladder."""
    models = {name: item for name, item in mapping(result.content, "models").items() if isinstance(item, Mapping)}
    if not models:
        return AbsentResult("no design was chosen")
    height = shown_height(result.content)
    interval = mapping(result.content, "best", height).get("interval90") or [None, None]
    words = height.replace("_", " ")
    used = mapping(result.content, "settings").get("model")
    bars = [
        ModelBar(name, value_of(item.get(height)) or 0.0, *(interval if name == used else (None, None)))
        for name, item in models.items()
    ]
    return {
        "svg": models_figure(f"{words} of the chosen leg by model", bars, ()),
        "height": words.capitalize(),
        "models": models,
        "used": used,
        "own_contact": _own_contact(models, height),
        "planar": sequence(result.content, "planar"),
    }


def _own_contact(models: Mapping[str, Any], height: str) -> str:
    """How model C on its own contact law compares with it on A's; empty without both."""
    same, own = (value_of(mapping(models, name).get(height)) for name in ("C", "C, its own contact"))
    if same is None or own is None:
        return ""
    default = "MuJoCo's default ground deforms elastically by millimetres under the push"
    if abs(own - same) < EVEN * same:
        return f"With its own contact law C jumps about as high: {default}."
    if own > same:
        return f"With its own contact law C jumps higher: {default} and returns the energy."
    return f"With its own contact law C jumps lower: {default}, and not all of that energy is back at takeoff."


SECTION = ReportSection("hopper-models", "Models side by side", content)
