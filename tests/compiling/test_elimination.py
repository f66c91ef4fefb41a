"""The unrolled solution of small symmetric systems, run as plain Python, beside numpy's."""

from __future__ import annotations

import numpy as np
import pytest

from synth.compiling.elimination import MOST_BY_MINORS, solve


@pytest.mark.parametrize("n", [1, 2, 3, 4, 7])
def test_two_systems_are_solved_as_numpy_does(n: int) -> None:
    generator = np.random.default_rng(n)
    base = generator.standard_normal((n, n))
    matrix, right = base @ base.T + 0.1 * np.eye(n), generator.standard_normal(n)
    unit = ["1.0" if i == n - 1 else "0.0" for i in range(n)]
    names = {f"J{i}{j}": matrix[i, j] for i in range(n) for j in range(i, n)} | {f"r{i}": right[i] for i in range(n)}
    exec("\n".join(solve(n, ("x", [f"r{i}" for i in range(n)]), ("u", unit))), {}, names)
    assert np.allclose([names[f"x{i}"] for i in range(n)], np.linalg.solve(matrix, right), rtol=1e-9)
    assert np.allclose([names[f"u{i}"] for i in range(n)], np.linalg.inv(matrix)[:, -1], rtol=1e-9)


def test_a_light_last_link_costs_no_digits_by_minors() -> None:
    # joint coordinates of three links of which the last has a millionth of the others' mass
    n = MOST_BY_MINORS
    absolute = np.array([[1.0, 0.5, 1e-6], [0.5, 0.7, 1e-6], [1e-6, 1e-6, 2e-6]])
    outboard = np.tril(np.ones((n, n)))
    matrix, right = outboard.T @ absolute @ outboard, np.array([0.3, -0.2, 1e-6])
    names = {f"J{i}{j}": matrix[i, j] for i in range(n) for j in range(i, n)} | {f"r{i}": right[i] for i in range(n)}
    exec("\n".join(solve(n, ("x", [f"r{i}" for i in range(n)]))), {}, names)
    exact = np.linalg.solve(outboard, np.linalg.solve(absolute, np.linalg.solve(outboard.T, right)))
    assert np.allclose([names[f"x{i}"] for i in range(n)], exact, rtol=1e-9)
