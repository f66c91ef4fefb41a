"""White noise and counts of a series, from the readings alone, and that the package has one place for each."""

from __future__ import annotations

import re
from pathlib import Path
from statistics import NormalDist

import numpy as np
import pytest

from synth.arrays import Array, finite_median
from synth.motion.counts import COARSE_NOISE, coarse_count
from synth.noise import MAD_TO_SD, robust_deviation, unit_differences, white_noise

ROOT = Path(__file__).resolve().parents[2]
NOISE = np.radians(0.05)


def swing(count: int) -> Array:
    """A decaying swing of 20 degrees at 2 Hz over 2 s, rad."""
    time = np.linspace(0.0, 2.0, count)
    return np.asarray(np.radians(20.0) * np.exp(-time) * np.cos(4.0 * np.pi * time))


def noisy(count: int, seed: int = 0) -> Array:
    return swing(count) + np.random.default_rng(seed).normal(0.0, NOISE, count)


def test_the_factor_is_that_of_a_normal_distribution() -> None:
    assert pytest.approx(1.0 / NormalDist().inv_cdf(0.75), abs=1e-5) == MAD_TO_SD


@pytest.mark.parametrize("order", [3, 4, 6])
def test_white_noise_on_a_swing_is_found(order: int) -> None:
    found = np.median([white_noise(noisy(1000, seed), order) for seed in range(20)])
    assert found == pytest.approx(NOISE, rel=0.03)


def test_outliers_do_not_count() -> None:
    values = noisy(1000)
    values[::100] += 1.0
    assert white_noise(values, 4) == pytest.approx(NOISE, rel=0.2)


def test_differences_of_uneven_samples_show_the_noise_of_even_ones() -> None:
    random = np.random.default_rng(0)
    time = np.linspace(0.0, 2.0, 1000) + random.uniform(-2e-4, 2e-4, 1000)
    values = np.radians(20.0) * np.cos(4.0 * np.pi * time) + random.normal(0.0, NOISE, 1000)
    assert robust_deviation(unit_differences(time, values, 6)) == pytest.approx(NOISE, rel=0.15)


def test_counts_are_coarse_only_where_noise_is_less() -> None:
    count = 2 * np.pi / 1024
    read = count * np.round(swing(500) / count)
    assert coarse_count(read, 0.0) == pytest.approx(count, rel=1e-9)
    assert coarse_count(read, 1.01 * COARSE_NOISE * count) == 0.0
    assert coarse_count(noisy(500), NOISE) == 0.0
    assert coarse_count(np.zeros(10), 0.0) == 0.0


@pytest.mark.parametrize("known", [[], [3.0], [5.0, 1.0], [2.0, 9.0, 4.0]])
def test_the_median_of_what_is_finite(known: list[float]) -> None:
    found = finite_median(np.array([np.nan, *known, np.inf]))
    assert found == np.median(known) if known else np.isnan(found)


def test_the_factor_and_the_differences_are_written_once() -> None:
    """The factor stood in eleven places, the differences in six."""
    factor, binomials = re.compile(r"1\.4826|0\.6745"), re.compile(r"comb\(\w+, k\) \*\* 2")
    places = {
        path.relative_to(ROOT).as_posix()
        for tree in ("synth", "cad", "reports")
        for path in (ROOT / tree).rglob("*.py")
        if factor.search(text := path.read_text(encoding="utf-8")) or binomials.search(text)
    }
    assert places == {"synth/noise.py"}
