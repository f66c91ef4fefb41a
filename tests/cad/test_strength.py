"""Closed-form stresses against equilibrium and textbook cases, the layers' knock-down, and sizing by them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from cad import JointDimensions, LoadDimensions, PrintDimensions, SpringDimensions, sized
from cad.layout import lay_out
from cad.sizing import overload
from cad.strength import Stress, _share, arm_force, check_strength, key_pressure, stresses

KNEE = JointDimensions("knee", SpringDimensions(3.429, 26.035, 7.17, 120.0), 111.0, 119.0)
LOADED = replace(KNEE, loads=LoadDimensions(spring_rate=2.0, damper_torque=0.3))
PRINTING = PrintDimensions()


def value(dimensions, name):
    return next(s.value for s in stresses(dimensions, lay_out(dimensions), PRINTING) if s.name == name)


def test_the_arm_presses_with_the_torque_over_its_length():
    # 2 N*m/rad over 111 - 60 = 51 deg: 1.780 N*m.
    assert LOADED.spring_torque == pytest.approx(2.0 * math.radians(51.0))
    layout = lay_out(LOADED)
    bearing, tangent = layout.upper.bearing, layout.upper.tangent
    along = math.cos(math.radians(layout.upper.direction)), math.sin(math.radians(layout.upper.direction))
    lever = (bearing[0] - tangent[0]) * along[0] + (bearing[1] - tangent[1]) * along[1]
    assert arm_force(LOADED, layout) == pytest.approx(LOADED.spring_torque * 1e3 / lever)


def test_a_dowel_bends_like_a_cantilever():
    # Steel 4 mm dowel, 100 N at 5 mm: sigma = M c/I = 500 * 2 / (pi 4^4/64) = 79.577 MPa.
    assert 500.0 * 2.0 / (math.pi * 4.0**4 / 64) == pytest.approx(79.577, abs=1e-3)
    layout = lay_out(LOADED)
    lever = value(LOADED, "lower dowel, bending") * math.pi * 4.0**3 / 32 / arm_force(LOADED, layout)
    # The contact's height over the floor: clearance, half a wire, and the arm's fall beyond its shaft (1.03 d a turn).
    fall = 1.03 * 3.429 / (math.pi * 26.035) * (layout.arm_reach - layout.pin_reach)
    assert lever == pytest.approx(KNEE.clearance + 3.429 / 2 + fall)


def test_the_seat_s_pressure_balances_force_and_moment():
    layout = lay_out(LOADED)
    force, depth, pin = arm_force(LOADED, layout), LOADED.plate, LOADED.pin_diameter
    peak = value(LOADED, "lower dowel's seat, pressure") * pin  # N/mm of depth at the seat's face
    # Linear over the depth with the force's resultant: q(0) = peak, and mean q = F/t.
    depths = np.linspace(0.0, depth, 100_001)
    pressure = peak + (2 * force / depth - 2 * peak) * depths / depth
    assert np.trapezoid(pressure, depths) == pytest.approx(force)
    lever = value(LOADED, "lower dowel, bending") * math.pi * pin**3 / 32 / force
    # Moments about the seat's face: the force outside at `lever` and the pressure inside.
    assert -np.trapezoid(pressure * depths, depths) == pytest.approx(force * lever, rel=1e-6)


def test_the_key_s_pressure_bears_the_torque():
    torque, diameter, length = 0.3, 8.0, 6.0
    peak = key_pressure(torque, diameter, length)
    half = math.sqrt(4.0**2 - 3.2**2)  # the flat of an 8 mm shaft lies 3.2 mm from its axis
    across = np.linspace(0.0, half, 10_001)
    assert np.trapezoid(peak * across / half * across * length, across) == pytest.approx(torque * 1e3)


@pytest.mark.parametrize(("angle", "left"), [(0.0, 1.0), (90.0, 0.5), (45.0, 2 * 0.5 / 1.5)])
def test_print_is_weaker_across_its_layers(angle, left):
    """Hankinson: at 45 deg the harmonic mean of both strengths."""
    pull = (math.cos(math.radians(angle)), math.sin(math.radians(angle)), 0.0)
    assert _share(pull, (0.0, 1.0, 0.0), 0.5) == pytest.approx(left)


def test_steel_knows_no_layers():
    steel = Stress("x", "shaft", 1.0, 240.0, (), ())
    assert steel.allowed(PRINTING, (0.0, 0.0, 1.0)) == steel.allowed(PRINTING, None) == pytest.approx(160.0)


def test_without_a_load_nothing_is_checked_and_with_a_large_one_the_gate_names_a_dimension():
    assert check_strength(KNEE, lay_out(KNEE), PRINTING, {}) == []
    heavy = replace(KNEE, loads=LoadDimensions(spring_rate=40.0))
    failed = [c for c in check_strength(heavy, lay_out(heavy), PRINTING, {}) if not c.passed]
    assert {"strength: upper dowel's seat, pressure", "strength: lower lug, torsion"} <= {c.name for c in failed}
    assert all("a larger " in c.text for c in failed)


def test_a_joint_grows_until_it_bears_its_load_and_no_further():
    heavy = replace(KNEE, loads=LoadDimensions(spring_rate=8.0, damper_torque=0.8))
    grown = sized(heavy, PRINTING)
    assert max(overload(s, PRINTING) for s in stresses(grown, lay_out(grown), PRINTING)) <= 1.0
    assert max(overload(s, PRINTING) for s in stresses(heavy, lay_out(heavy), PRINTING)) > 1.0
    assert grown.plate > heavy.plate or grown.pin_diameter > heavy.pin_diameter
    assert grown.shaft_diameter == heavy.shaft_diameter  # the user's own
    assert sized(LOADED, PRINTING) == LOADED  # bears its load as it is
    thinner = replace(grown, floor=grown.floor_thickness - 1.0)
    assert max(overload(s, PRINTING) for s in stresses(thinner, lay_out(thinner), PRINTING)) > 1.0
