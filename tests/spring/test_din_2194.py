"""Quality grades of DIN 2194: formulas that agree with each other, scope, and the grade that is ordered."""

from __future__ import annotations

import math

import pytest

from synth.parts.coil_rate import rate
from synth.spring.din_2194 import grade_tolerances, suitable_grade


@pytest.mark.parametrize(("wire", "index", "coils"), [(0.5, 6.0, 3.0), (1.0, 8.0, 4.17), (4.75, 4.3, 12.0)])
def test_torque_s_tolerance_is_the_rate_times_the_angle_s(wire: float, index: float, coils: float) -> None:
    d = wire * 1e-3
    for each in grade_tolerances("music wire", d, index * d, coils, (0.02, 0.02)):
        assert each.torque == pytest.approx(rate(206.6e9, d, index * d, coils) * each.free_angle, rel=2e-3)


def test_grades_of_a_spring_of_one_millimetre() -> None:
    """By hand: D = 8, w = 8, n = 4: 0.025 x 8 = 0.2 mm; 2.4 x 4^0.76 x 8^0.5 = 19.47 deg; (0.2 + 1) 0.8 = 0.96 mm."""
    first, second, third = grade_tolerances("music wire", 1e-3, 8e-3, 4.0, (0.02, 0.04))
    assert second.mean_diameter == pytest.approx(0.2e-3)
    assert math.degrees(second.free_angle) == pytest.approx(19.47, abs=0.01)
    assert second.leg_lengths == pytest.approx((0.96e-3, 1.56e-3))
    assert first.free_angle / second.free_angle == pytest.approx(0.63)
    assert third.torque / second.torque == pytest.approx(1.6)
    stainless = grade_tolerances("stainless 302", 1e-3, 8e-3, 4.0, ())[1]
    assert stainless.torque / second.torque == pytest.approx(90 / 104)


@pytest.mark.parametrize(
    ("wire", "tolerance"), [(0.5, 0.025 * 4.0 * 1.12505), (4.0, 0.025 * 32.0 / 1.26576), (10.0, 0.025 * 80.0 / 1.47911)]
)
def test_the_diameter_s_tolerance_grows_slower_than_the_wire(wire: float, tolerance: float) -> None:
    """Of index 8: 0.025 D / d^0.17 mm in grade 2; 2^0.17 = 1.12505, 4^0.17 = 1.26576, 10^0.17 = 1.47911."""
    second = grade_tolerances("music wire", wire * 1e-3, 8e-3 * wire, 4.0, ())[1]
    assert second.mean_diameter == pytest.approx(tolerance * 1e-3, rel=1e-5)


def test_outside_the_scope_there_are_no_grades() -> None:
    assert grade_tolerances("music wire", 1e-3, 3e-3, 4.0, ()) == ()  # index 3
    assert grade_tolerances("music wire", 1e-3, 8e-3, 1.9, ()) == ()
    assert grade_tolerances("music wire", 1e-3, 8e-3, 4.0, (2.0,)) == ()  # m


def test_the_coarsest_grade_that_keeps_the_free_angle_is_ordered() -> None:
    grades = grade_tolerances("music wire", 1e-3, 8e-3, 4.0, ())
    chosen = [suitable_grade(grades, math.radians(within)) for within in (40.0, 20.0, 13.0, 5.0)]
    assert [each.grade for each in chosen if each is not None] == [3, 2, 1, 1]
    assert suitable_grade((), 1.0) is None
