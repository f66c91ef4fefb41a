"""The largest moments of a wire with clamped arms: small angles by Castigliano, large ones by the bent shape."""

from __future__ import annotations

import math

import numpy as np
import pytest

from synth.cad.flexed_wire import effective_length, flex_wire
from synth.cad.wire_moments import peak_moments

SPRINGS = [(10.0, 2.17, 14.0), (13.0, 7.17, 16.0), (28.6, 3.1667, 33.1), (8.5, 6.4, 6.0), (6.0, 2.5, 15.0)]


def by_quadrature(radius, coils, arm, n=20_001):
    """Peaks in coil and arms over the torque for a small angle: the wire's end turns about the axis and stays on it."""
    t, phi = np.linspace(0.0, arm, n), np.linspace(0.0, 2 * math.pi * coils, n)
    c, s = math.cos(phi[-1]), math.sin(phi[-1])
    pieces = [
        (np.column_stack([np.full(n, radius), t - arm]), t),
        (radius * np.column_stack([np.cos(phi), np.sin(phi)]), radius * phi),
        (np.column_stack([radius * c - t * s, radius * s + t * c]), t),
    ]
    moments = [(np.column_stack([np.ones(n), points]), length) for points, length in pieces]
    sums = sum(np.trapezoid(m[:, :, None] * m[:, None, :], length, axis=0) for m, length in moments)
    load = np.linalg.solve(sums, [1.0, 0.0, 0.0])  # turned by one, no shift of the end from its circle
    peaks = [float(np.abs(m @ load).max() / load[0]) for m, _ in moments]
    return peaks[1], max(peaks[0], peaks[2])


def by_shape(radius, coils, arm, closing):
    """The same from the bent shape; the arms' curvature is extrapolated to their ends."""
    wire = flex_wire(radius, coils, arm, closing)
    free = np.zeros(len(wire.curvature))
    free[wire.first : wire.last] = 1.0 / radius
    bent = wire.curvature - free
    first, last = bent[: wire.first], bent[wire.last :]
    ends = [1.5 * a - 0.5 * b for a, b in (first[:2], first[:-3:-1], last[:2], last[:-3:-1])]
    torque = abs(math.radians(closing)) / effective_length(radius, coils, arm)
    return float(np.abs(bent[wire.first : wire.last]).max()) / torque, float(np.abs(ends).max()) / torque


@pytest.mark.parametrize(("radius", "coils", "arm"), SPRINGS)
def test_small_angles_have_castiglianos_moments(radius, coils, arm):
    coil, arms = by_quadrature(radius, coils, arm)
    for closing in (0.0, 1e-3, -1e-3):
        found = peak_moments(radius, coils, arm, closing)
        assert found.coil == pytest.approx(coil, rel=1e-5)
        assert found.arms == pytest.approx(arms, rel=1e-5)


def test_the_peak_of_a_knee_spring():
    """3.1667 coils of 57.2 mm with arms of 33.1 mm: 1.208 for small angles, 1.176 for 44 deg (by hand, see above)."""
    assert peak_moments(28.5924, 3.1667, 33.1, 0.0).coil == pytest.approx(1.208, abs=1e-3)
    assert peak_moments(28.5924, 3.1667, 33.1, 44.07).coil == pytest.approx(1.176, abs=1e-3)


@pytest.mark.parametrize("coils", [2.0, 2.17, 2.5, 3.17, 3.67, 5.4, 9.8])
@pytest.mark.parametrize("arm", [5.0, 12.0, 20.0, 30.0])
def test_large_angles_agree_with_the_bent_shape(coils, arm):
    for closing in (-80.0, -45.0, -20.0, -2.0, 2.0, 20.0, 45.0, 90.0, 170.0):
        found, (coil, arms) = peak_moments(10.0, coils, arm, closing), by_shape(10.0, coils, arm, closing)
        assert found.coil == pytest.approx(coil, rel=0.02)
        assert found.arms == pytest.approx(arms, abs=0.06)
        if abs(closing) <= 45.0 and arm <= 20.0:
            assert found.coil == pytest.approx(coil, rel=0.004)


@pytest.mark.parametrize("closing", [-60.0, 1.0, 60.0])
def test_with_many_coils_the_moment_is_the_torque(closing):
    assert peak_moments(10.0, 150.2, 12.0, closing).coil == pytest.approx(1.0, abs=0.01)


def test_the_arms_bear_no_more_than_the_coil():
    """So the curvature factor, which only the coil has, decides where the wire yields first."""
    for coils in np.arange(2.0, 8.0, 0.1):
        for arm in (5.0, 10.0, 15.0, 20.0, 30.0):
            for closing in (-60.0, -20.0, 5.0, 30.0, 100.0):
                found = peak_moments(10.0, float(coils), arm, closing)
                assert found.arms <= 1.02 * found.coil
