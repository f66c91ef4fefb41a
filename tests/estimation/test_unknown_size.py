"""Cost and weight of residuals of unknown size."""

from __future__ import annotations

import numpy as np
import pytest

from synth.estimation.unknown_size import UnknownSize


def test_the_cost_is_least_squares_at_the_noise_and_a_logarithm_far_above() -> None:
    size, unknowns = UnknownSize(50.0), np.array([1.0, -2.0])
    assert size.cost(1e-6, unknowns) == pytest.approx(1e-6 + 2.5)
    assert size.cost(50.0 * np.expm1(3.0), np.zeros(2)) == pytest.approx(150.0)


def test_many_costs_and_the_weight_are_those_of_the_cost() -> None:
    size, generator = UnknownSize(30.0), np.random.default_rng(0)
    squares, unknowns = np.exp(generator.uniform(-3.0, 9.0, 40)), generator.standard_normal((40, 3))
    each = [size.cost(float(square), own) for square, own in zip(squares, unknowns, strict=True)]
    np.testing.assert_allclose(size.costs(squares, unknowns), each, rtol=1e-13)
    step = 1e-6 * squares
    slopes = (size.costs(squares + step, unknowns) - size.costs(squares - step, unknowns)) / (2.0 * step)
    np.testing.assert_allclose(size.weight(squares), 2.0 * slopes, rtol=1e-6)
    assert size.weight(float(squares[0])) == size.weight(squares)[0]
