"""Fisher's F against scipy's, and its limit of a known noise."""

from __future__ import annotations

import math

import pytest
from scipy.special import fdtrc

from synth.estimation.chi_squared import chi_squared_above
from synth.estimation.f_distribution import square_above


@pytest.mark.parametrize("freedom", [1, 2, 3, 9, 40, 400])
@pytest.mark.parametrize("of_noise", [1.0, 2.0, 3.5, 10.0, 100.0, 9e4])
@pytest.mark.parametrize("times", [0.01, 0.5, 1.0, 1.5, 4.0, 30.0])
def test_probabilities_are_those_of_scipy(freedom: int, of_noise: float, times: float) -> None:
    expected = fdtrc(freedom, of_noise, times)
    assert square_above(freedom, times * freedom, of_noise) == pytest.approx(expected, rel=1e-9, abs=1e-280)


def test_a_known_noise_is_the_limit() -> None:
    assert square_above(9, 33.7) == chi_squared_above(9, 33.7)
    assert square_above(9, 33.7, 9.99e4) == pytest.approx(chi_squared_above(9, 33.7), rel=2e-3)
    assert square_above(9, 0.0, 3.0) == 1.0


@pytest.mark.parametrize("of_noise", [0.0, -1.0, math.nan])
def test_no_degree_is_refused(of_noise: float) -> None:
    with pytest.raises(ValueError, match="more than 0 are needed"):
        square_above(3, 1.0, of_noise)
