"""Friction of bearings and thrust washers against the formulas it rests on."""

from __future__ import annotations

import math

import pytest

from synth.design.bearing_friction import friction_of


def test_ball_bearing_friction_equals_the_makers_formula() -> None:
    """SKF's estimate, written out: 100 N on a bore of 8 mm turn with 0.5 * 0.0015 * 100 * 8 = 0.6 N*mm."""
    found = friction_of(8e-3, 14e-3, 40.0, 60.0)
    assert found.bearings == pytest.approx(0.6e-3)
    # A degree off level 40 N press 0.698 N on the washer, whose mean radius is 5.5 mm.
    assert found.washers == pytest.approx(0.2 * 40.0 * math.sin(math.radians(1.0)) * 5.5e-3)
    assert found.torque == pytest.approx(found.bearings + found.washers)


def test_friction_is_zero_without_a_load() -> None:
    assert friction_of(8e-3, 14e-3, 0.0, 0.0).torque == 0.0


def test_the_friction_estimate_states_its_basis() -> None:
    written = friction_of(8e-3, 14e-3, 40.0, 60.0).as_json()
    assert written["torque"]["unit"] == "N*m"
    assert "SKF" in written["basis"]
