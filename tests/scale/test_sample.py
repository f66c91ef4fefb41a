"""A small honest sample of ``make scale``: the exponent's arithmetic, and one case measured."""

from __future__ import annotations

from pathlib import Path

import pytest

from scale.__main__ import LEAST_SECONDS, Growth, Measured, exponent, measured
from scale.cases import CASES

SIZES = (250.0, 500.0, 1000.0)


@pytest.mark.parametrize("power", [1.0, 2.0])
def test_the_exponent_of_a_power_is_that_power(power: float) -> None:
    values = [5.0 + 1e-2 * size**power for size in SIZES]
    assert exponent(SIZES, values, 5.0, LEAST_SECONDS) == pytest.approx(power, rel=1e-9)
    assert exponent(SIZES, [5.0, 5.1, 5.2], 5.0, LEAST_SECONDS) is None  # too little growth to tell


def test_quadratic_growth_fails() -> None:
    fixed = Measured(2, 1.0, 1.0, 1e8)
    assert Growth("a", fixed, (), 1.1, None).linear
    assert not Growth("a", fixed, (), 2.0, 1.0).linear
    assert not Growth("a", fixed, (), None, 1.5).linear


def test_a_catalogue_is_measured_and_removed(tmp_path: Path) -> None:
    (parts,) = (case for case in CASES if case.name == "parts")
    found = measured(parts, 200, tmp_path)
    assert found.size == 200
    assert found.processor > 0.1
    assert 3e7 < found.memory < 2e9
    assert list(tmp_path.iterdir()) == []
