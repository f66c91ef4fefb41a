"""The power that effects' lane loops call, and which effects ask for the bearing force."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from swing.effects.one_joint import leg
from synth.swing.chain import compiled_chain
from synth.swing.effects.inlined import power


@njit(fastmath=True, error_model="numpy")  # type: ignore[untyped-decorator]
def _each(base, exponent, out):  # type: ignore[no-untyped-def]
    for i in range(len(out)):
        out[i] = power(base[i], exponent[i])


@pytest.mark.parametrize(("low", "high", "most"), [(1e-12, 1e-3, 7.0), (1e-3, 1e3, 8.0), (0.99, 1.01, 100.0)])
def test_the_power_is_the_library_s(low: float, high: float, most: float) -> None:
    generator = np.random.default_rng(0)
    base = np.exp(generator.uniform(np.log(low), np.log(high), 4000))
    exponent = generator.uniform(-most, most, len(base))
    found = np.empty(len(base))
    _each(base, exponent, found)
    np.testing.assert_allclose(found, base**exponent, rtol=1e-13)


def test_a_power_stays_finite() -> None:
    found = np.empty(4)
    _each(np.array([1e-12, 1e12, 1.0, 2.0]), np.array([90.0, 90.0, 1e9, 3.0]), found)
    np.testing.assert_allclose(found, [2.0**-1000, 2.0**1000, 1.0, 8.0], rtol=1e-13)


@pytest.mark.parametrize(("strengths", "passes"), [({"share": 0.1}, 1), ({"radius": 0.01}, 2), ({}, 1)])
def test_the_bearing_force_is_computed_only_where_friction_grows_with_it(
    strengths: dict[str, float], passes: int
) -> None:
    chain = compiled_chain(1)
    made = leg({"load_friction": {"radius": 0.0, "share": 0.0} | strengths})
    without, whole = chain.acting.active(chain.parameters(made)[:, None])
    assert whole.any() == bool(strengths)
    assert 1 + bool(np.any(without != whole)) == passes
