"""Covariances from information: the inverse where there is one, and a message where the fit diverged."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import stdtr, stdtrit

from synth.errors import UserError
from synth.estimation.intervals import NULL, Estimate, NotFiniteError, covariance_of, student, student95
from synth.fit.draws import DRAWS, draws
from synth.units import factor


def test_a_regular_information_is_inverted() -> None:
    root = np.random.default_rng(1).normal(size=(4, 4)) * np.array([1e-6, 1.0, 1e3, 1e5])
    information = root.T @ root
    scale = np.sqrt(np.outer(np.diag(information), np.diag(information)))
    np.testing.assert_allclose(covariance_of(information) * scale, np.linalg.inv(information / scale), rtol=1e-6)


def test_a_direction_without_information_gets_a_huge_variance() -> None:
    covariance = covariance_of(np.array([[1.0, 1.0], [1.0, 1.0]]))
    along, across = np.array([1.0, 1.0]) / np.sqrt(2), np.array([1.0, -1.0]) / np.sqrt(2)
    assert along @ covariance @ along == pytest.approx(0.5, abs=1e-3)
    assert across @ covariance @ across == pytest.approx(1.0 / NULL, rel=1e-6)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_matrix_that_is_not_finite_is_reported(bad: float) -> None:
    matrix = np.diag([1.0, bad, 2.0])
    with pytest.raises(NotFiniteError, match="not finite"):
        covariance_of(matrix)
    with pytest.raises(UserError, match="the simulated motion diverges"):
        draws(np.zeros(3), matrix, None, None, 0)


def test_students_distribution_has_at_least_one_degree() -> None:
    """Of none it was that of four."""
    assert student95(1) == pytest.approx(6.314)
    with pytest.raises(ValueError, match="at least 1"):
        student95(0)


def test_draws_have_the_covariance_they_are_drawn_from() -> None:
    """Sample covariance of n normal draws: relative deviation of an element about sqrt(2/n)."""
    root = np.array([[1.0, 0.0], [1.9, 0.1]])
    covariance = root @ root.T
    found = np.cov(draws(np.array([3.0, -1.0]), covariance, None, None, 4), rowvar=False)
    scale = np.sqrt(np.outer(np.diag(covariance), np.diag(covariance)))
    assert np.abs(found - covariance).max() < 4.0 * np.sqrt(2.0 / DRAWS) * scale.max()
    correlation = found[0, 1] / np.sqrt(found[0, 0] * found[1, 1])
    assert correlation > 0.99


@pytest.mark.parametrize("degrees", [1, 2, 3, 4, 9, 10, 200])
def test_student_s_distribution_is_that_of_scipy(degrees: int) -> None:
    for value in (-np.inf, -8.0, -0.3, 0.0, 2.0, np.inf):
        assert student(value, degrees) == pytest.approx(stdtr(degrees, value), abs=1e-12)


@pytest.mark.parametrize("degrees", [*range(1, 61), 100, 1000, 10**6])
def test_the_95_percent_point_is_that_of_the_distribution(degrees: int) -> None:
    """Within what the docstring states; the expansion is worst where it begins."""
    found = student95(degrees)
    assert found == pytest.approx(stdtrit(degrees, 0.95), rel=0.005)
    assert student(found, degrees) == pytest.approx(
        0.95, abs=2e-5 if degrees < 5 else max(6e-4 * (5 / degrees) ** 2, 1e-8)
    )


UNITS = ["deg", "deg/s", "mH", "cm", "1/cm", "ms", "%", "1", "N*m/rad", "N*m*s^2/rad^2", "1/rad", "kg*m^2", "ohm", "V"]


@pytest.mark.parametrize("shown_in", UNITS)
def test_a_value_in_its_unit_is_that_of_the_file(shown_in: str) -> None:
    """An angle in radians said that its unit was deg."""
    estimate = Estimate(1.8326, shown_in, 1.8, 1.9)
    written = estimate.as_json()
    scale = factor(estimate.unit, written["unit"])
    assert estimate.value * scale == pytest.approx(written["value"], rel=1e-12)
    assert [estimate.low, estimate.high] == pytest.approx([end / scale for end in written["interval90"]], rel=1e-12)
    assert factor(estimate.unit, estimate.unit) == pytest.approx(1.0)


def test_it_shows_itself_as_tables_do() -> None:
    angle = Estimate(np.radians(105.003), "deg", np.radians(104.99), np.radians(105.01))
    assert (angle.unit, angle.shown_in) == ("rad", "deg")
    assert repr(angle) == f"{angle}" == "Estimate(105.003 deg, 90 %: 104.99 to 105.01)"
    assert repr(Estimate(0.5, "N*m/rad", 0.2, np.inf)) == "Estimate(0.5 N*m/rad, 90 %: 0.2 to inf)"
    assert repr(Estimate(0.012, "%")) == "Estimate(1.2 %)"


def test_an_interval_without_width_has_words() -> None:
    """Of a cause that takes all of the gap they ended in a domain error of the logarithm."""
    assert Estimate(1.0, "1", 1.0, 1.0).words == "1 to 1"
    assert Estimate(0.0, "deg", 0.0, 0.0).words == "0 to 0 deg"
    assert Estimate(2.5, "N*m/rad", 1.25, np.inf).words == "anything"
    assert Estimate(0.0, "N*m/rad", -1.25, np.inf).words == "-1.25 to inf N*m/rad"
    assert repr(Estimate(1.0, "1", 0.9, 1.0)) == "Estimate(1, 90 %: 0.9 to 1)"
