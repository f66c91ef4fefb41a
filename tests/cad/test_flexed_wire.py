"""The bent spring: its rate in closed form against quadrature, and its large motions against energy and statics."""

from __future__ import annotations

import math

import numpy as np
import pytest

from synth.cad import flexed_wire
from synth.cad.flexed_wire import effective_length, flex_wire

SPRINGS = [(10.0, 2.17, 14.0), (13.0, 7.17, 16.0), (18.25, 1.04, 27.0), (8.5, 6.17, 12.0), (5.0, 3.6, 0.001)]


def wire(radius, coils, arm, n=20_001):
    """Points of the unloaded wire and their lengths, from its definition."""
    t = np.linspace(0.0, arm, n)
    phi = np.linspace(0.0, 2 * math.pi * coils, n)
    end = phi[-1]
    first = np.column_stack([np.full(n, radius), t - arm])
    coil = radius * np.column_stack([np.cos(phi), np.sin(phi)])
    last = coil[-1] + t[:, None] * np.array([-math.sin(end), math.cos(end)])
    return [(first, t), (coil, radius * phi), (last, t)]


@pytest.mark.parametrize(("radius", "coils", "arm"), SPRINGS)
def test_the_effective_length_equals_castiglianos(radius, coils, arm):
    """Compliance by quadrature: of moment and two forces on the turning end, with the axis held."""
    compliance = np.zeros((3, 3))
    for points, length in wire(radius, coils, arm):
        moments = np.column_stack([np.ones(len(points)), points[:, 1], -points[:, 0]])
        compliance += np.trapezoid(moments[:, :, None] * moments[:, None, :], length, axis=0)
    stiffness = np.linalg.inv(compliance)  # EI = 1; turned by one with no shift of the axis
    assert effective_length(radius, coils, arm) == pytest.approx(1.0 / stiffness[0, 0], rel=1e-6)


def test_many_coils_are_as_stiff_as_a_straight_wire():
    assert effective_length(5.0, 200.0, 3.0) == pytest.approx(2 * math.pi * 5.0 * 200.0 + 6.0, rel=1e-4)


@pytest.mark.parametrize(("radius", "coils", "arm"), SPRINGS[:4])
@pytest.mark.parametrize("closing", [-50.0, -1.0, 1.0, 50.0])
def test_torque_is_the_derivative_of_the_energy(radius, coils, arm, closing):
    def energy(angle):
        found = flex_wire(radius, coils, arm, angle)
        free = np.zeros(len(found.curvature))
        free[found.first : found.last] = 1.0 / radius
        return float(np.sum((found.curvature - free) ** 2 * np.diff(found.lengths)) / 2)

    step = 0.02
    slope = (energy(closing + step) - energy(closing - step)) / math.radians(2 * step)
    assert flex_wire(radius, coils, arm, closing).torque == pytest.approx(slope, rel=2e-4)


@pytest.mark.parametrize(("radius", "coils", "arm"), SPRINGS[:4])
def test_small_motions_have_the_closed_form_rate(radius, coils, arm):
    torque = (flex_wire(radius, coils, arm, 0.5).torque - flex_wire(radius, coils, arm, -0.5).torque) / math.radians(
        1.0
    )
    assert torque == pytest.approx(1.0 / effective_length(radius, coils, arm), rel=5e-4)


def test_the_wire_keeps_its_length_and_its_end_turns_about_the_axis():
    radius, coils, arm = SPRINGS[0]
    free, bent = flex_wire(radius, coils, arm, 1e-9), flex_wire(radius, coils, arm, 40.0)
    assert bent.lengths[-1] == pytest.approx(2 * math.pi * radius * coils + 2 * arm)
    angle = math.radians(40.0)
    turned = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]) @ free.points[-1]
    assert bent.points[-1] == pytest.approx(turned, abs=1e-4)
    assert bent.points[0] == pytest.approx(free.points[0])


def test_a_wire_bent_too_far_gives_none():
    assert flex_wire(5.0, 0.6, 0.1, 2000.0) is None


@pytest.mark.parametrize(("radius", "coils", "arm"), SPRINGS[:4])
@pytest.mark.parametrize("closing", [-80.0, 20.0, 120.0])
def test_load_and_shape_found_together_or_in_turn_are_the_same(monkeypatch, radius, coils, arm, closing):
    """Two ways to the same equations; the first one is the fast one."""
    together = flex_wire(radius, coils, arm, closing)
    monkeypatch.setattr(flexed_wire, "_solve_together", lambda *given: None)
    in_turn = flex_wire(radius, coils, arm, closing)
    assert together.points == pytest.approx(in_turn.points, abs=1e-5)
    assert together.torque == pytest.approx(in_turn.torque, rel=1e-5)


def test_the_far_end_is_where_the_joint_takes_it():
    """The boundary conditions, to a thousandth of what a print can show."""
    radius, arm, closing = 10.0, 14.0, 70.0
    free, bent = flex_wire(radius, 3.17, arm, 0.0), flex_wire(radius, 3.17, arm, closing)
    turn = math.radians(closing)
    c, s = math.cos(turn), math.sin(turn)
    x, y = free.points[-1]
    assert bent.points[-1] == pytest.approx([c * x - s * y, s * x + c * y], abs=1e-6)
    heading = float(np.sum((bent.curvature - free.curvature) * np.diff(free.lengths)))
    assert heading == pytest.approx(turn, abs=1e-6)


@pytest.mark.parametrize("closing", [-70.0, 55.0, 150.0])
@pytest.mark.parametrize(("radius", "coils", "arm"), SPRINGS[:2])
def test_solutions_on_the_way_do_not_decide_the_last_one(monkeypatch, radius, coils, arm, closing):
    """They are only starts, so they are not followed to the last digit: that takes half of the rounds."""
    rounds, points_of = [], flexed_wire._points

    def counted(*given):
        rounds.append(given)
        return points_of(*given)

    monkeypatch.setattr(flexed_wire, "_points", counted)
    found, taken = flex_wire(radius, coils, arm, closing), len(rounds)
    rounds.clear()
    monkeypatch.setattr(flexed_wire, "UNDER_WAY", flexed_wire.SETTLED)
    exact = flex_wire(radius, coils, arm, closing)
    assert found.points == pytest.approx(exact.points, abs=1e-8)
    assert found.torque == pytest.approx(exact.torque, rel=1e-9)
    assert taken < 0.75 * len(rounds)
