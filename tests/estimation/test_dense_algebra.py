"""What eliminates or projects unknowns, against the same with all of them written out."""

from __future__ import annotations

import numpy as np
import pytest

from synth.arrays import Array
from synth.estimation.autoregression import best_order
from synth.estimation.consider import Coupling, consider
from synth.estimation.gauss_newton import LocalProblem, gauss_newton
from synth.estimation.information import TrialForecast, expected_information
from synth.estimation.normal_equations import Information


def test_considered_parameters_move_all_unknowns_as_the_whole_system_does() -> None:
    """Two trials, three common unknowns, two and one of their own, two considered parameters."""
    draw = np.random.default_rng(2).normal
    sizes, count, considered = (2, 1), 3, 2
    total = count + sum(sizes)
    jacobian = draw(size=(30, total))
    matrix = jacobian.T @ jacobian
    own = [slice(3, 5), slice(5, 6)]
    matrix[own[0], own[1]] = matrix[own[1], own[0]] = 0.0  # two trials share no unknowns of their own
    coupling = [(draw(size=(count, considered)), draw(size=(size, considered))) for size in sizes]
    beside = draw(size=(count, considered))
    derivative = np.vstack([coupling[0][0] + coupling[1][0] + beside, coupling[0][1], coupling[1][1]])
    expected = -np.linalg.solve(matrix, derivative)
    information = Information(
        matrix[:count, :count], tuple(matrix[:count, each] for each in own), tuple(matrix[each, each] for each in own)
    )
    couplings = [Coupling(*each) for each in coupling]
    found = consider(information, couplings, beside)
    np.testing.assert_allclose(found.sensitivity, expected[:count], rtol=1e-7)
    np.testing.assert_allclose(found.covariance, expected[:count] @ expected[:count].T, rtol=1e-7)
    for made, each in zip(found.own(information, couplings), own, strict=True):
        np.testing.assert_allclose(made, expected[each], rtol=1e-7)


@pytest.mark.parametrize("remainder", [1.0, 3.0])
def test_the_distance_of_forecasts_is_that_of_the_whole_covariance(remainder: float) -> None:
    """Noise, what earlier trials leave open, and 1e4 times as much where anything may be."""
    draw = np.random.default_rng(3).normal
    one, other = (TrialForecast(draw(size=12), draw(size=(12, 3)), draw(size=(12, 2))) for _ in range(2))
    free = 1e4 * other.free
    covariance = remainder**2 * np.eye(12) + other.spread @ other.spread.T + free @ free.T
    apart = one.mean - other.mean
    expected = apart @ np.linalg.solve(covariance, apart)
    assert one.distance(other, other, remainder) == pytest.approx(expected, rel=1e-6)


def test_information_of_two_rivals_lies_between_none_and_one_bit() -> None:
    """Two of equal weight with Bhattacharyya's distance D: 1 - log2(1 + exp(-D)), D an eighth of Mahalanobis'."""
    weights = np.array([0.5, 0.5])
    for squared in (0.0, 4.0, 1e4):
        expected = 1.0 - np.log2(1.0 + np.exp(-squared / 8.0))
        assert expected_information(weights, lambda *_, d=squared: d) == pytest.approx(expected)


def test_a_step_that_fails_is_halved_along_the_same_line() -> None:
    """The cost sqrt(1 + x^2), whose curvature is stated as an eighth of that at 0: the first step goes far beyond."""
    seen: list[float] = []

    def assess(at: Array) -> LocalProblem[float]:
        x = float(at[0])
        seen.append(x)
        cost = float(np.hypot(1.0, x))
        return LocalProblem(x, cost, np.array([[0.125]]), np.array([x / cost]))

    found, where = gauss_newton(assess, np.array([3.0]), rounds=3, least_gain=0.0)
    step = -8.0 * 3.0 / np.sqrt(10.0)
    assert seen == pytest.approx([3.0, 3.0 + step, 3.0 + 0.5 * step])
    assert np.hypot(1.0, seen[1]) > np.hypot(1.0, 3.0) > np.hypot(1.0, seen[2])
    assert found == where[0] == seen[2]


def test_an_order_more_must_pay_two() -> None:
    """Akaike: of n samples, a coefficient r at the next lag lowers n log(variance) by -n log(1 - r^2)."""
    for gain, order in ((1.9, 0), (1.1, 0), (2.1, 1)):
        reflection = np.sqrt(-np.expm1(-gain / 200))
        assert best_order(np.array([1.0, reflection]), 200) == order
