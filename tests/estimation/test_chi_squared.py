"""The chi-squared distribution against scipy's, and against its closed forms of one and two degrees."""

from __future__ import annotations

import math

import pytest
from scipy.special import chdtrc, chdtri

from synth.estimation.chi_squared import chi_squared_above, chi_squared_exceeded


@pytest.mark.parametrize("freedom", [1, 2, 3, 4, 7, 8, 33, 100, 999, 4000])
@pytest.mark.parametrize("times", [0.01, 0.5, 0.9, 1.0, 1.1, 2.0, 10.0])
def test_probabilities_are_those_of_scipy(freedom: int, times: float) -> None:
    value = times * freedom
    assert chi_squared_above(freedom, value) == pytest.approx(chdtrc(freedom, value), rel=1e-9, abs=1e-290)


@pytest.mark.parametrize("freedom", [1, 2, 5, 6, 34, 999])
@pytest.mark.parametrize("probability", [0.001, 0.05, 0.5, 0.95, 0.999])
def test_quantiles_are_those_of_scipy(freedom: int, probability: float) -> None:
    found = chi_squared_exceeded(freedom, probability)
    assert found == pytest.approx(chdtri(freedom, probability), rel=1e-9)
    assert chi_squared_above(freedom, found) == pytest.approx(probability, rel=1e-9)


@pytest.mark.parametrize(("freedom", "probability"), [(0, 0.05), (3, 0.0), (3, 1.0), (3, math.nan)])
def test_quantiles_that_do_not_exist_are_refused(freedom: int, probability: float) -> None:
    """Of no degrees the search for one never ended."""
    with pytest.raises(ValueError, match="at least 1 degree, and between 0 and 1"):
        chi_squared_exceeded(freedom, probability)


def test_closed_forms() -> None:
    assert chi_squared_above(2, 3.0) == pytest.approx(math.exp(-1.5), rel=1e-14)
    assert chi_squared_above(1, 4.0) == pytest.approx(math.erfc(math.sqrt(2.0)), rel=1e-14)  # two standard deviations
    assert chi_squared_above(5, 0.0) == 1.0
