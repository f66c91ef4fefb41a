"""The parts of a designed leg in a comparison read as its bill of materials orders them."""

from __future__ import annotations

from typing import Any

from synth.comparison.opened import _with_parts
from synth.comparison.side import ComparedJoint

DAMPER = {"arrangement": "4 x DA", "law": "concave"}


def _stated(spring: dict[str, Any]) -> str:
    return _with_parts(ComparedJoint(), {"spring": spring, "damper": DAMPER}).spring_part


def _made(count: int = 1) -> dict[str, Any]:
    """A spring of 4 1/6 coils whose clamped arms bend as much as another 0.43."""
    return {
        "make": {
            "wire_diameter": {"value": 4.7498, "unit": "mm"},
            "material": "music wire",
            "body_coils": {"value": 4.166666667, "unit": "1"},
            "active_coils": {"value": 4.598752016, "unit": "1"},
            "count": count,
        }
    }


def test_springs_side_by_side_are_counted_bought_or_wound() -> None:
    """Their rate stands beside it and is that of all."""
    assert _stated({"part": "H2", "count": 2}) == "2 x H2"
    assert _stated({"part": "K2", "count": 1}) == "K2"
    assert _stated(_made(2)) == "2 x wind 4.75 mm music wire, 4.167 coils"


def test_a_wound_spring_states_the_coils_to_wind_and_not_those_that_bend() -> None:
    assert _stated(_made()) == "wind 4.75 mm music wire, 4.167 coils"
