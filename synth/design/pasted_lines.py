"""The values of ``spring`` and ``damper`` of a joint under ``select`` with which a project names a listed option.

They select that option alone, with its number and gear; an option that no such value names has None.
"""

from __future__ import annotations

from typing import Any

from synth.design.choose_dampers import DamperOption
from synth.design.choose_springs import SpringOption
from synth.files.text_forms import flow_mapping

NO_NUMBER = "the measured damper has no part number; state its part under dampers"
ORDERED = "its torque is chosen with the order, which a part number does not name"


def spring_value(option: SpringOption) -> str:
    """Part and number; of a spring to wind that it is to be wound."""
    if option.row is None:
        return flow_mapping({"make": True})
    return flow_mapping({"part": option.row.part, **({"parallel": option.count} if option.count > 1 else {})})


def damper_value(option: DamperOption) -> str | None:
    """Part, number of pieces, ratio."""
    if why_unnamed(option) or option.row is None:
        return None
    value: dict[str, Any] = {"part": option.row.part}
    arrangement = option.arrangement
    if arrangement.pieces > 1:
        value["parallel"] = arrangement.pieces
    if arrangement.ratio != 1.0:
        value["ratios"] = [arrangement.ratio]
    return flow_mapping(value)


def why_unnamed(option: DamperOption) -> str:
    """Why no value names the option; empty if one does."""
    if option.row is None:
        return NO_NUMBER
    return ORDERED if option.row.ordered else ""
