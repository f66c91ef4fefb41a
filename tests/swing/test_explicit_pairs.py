"""The two Runge-Kutta pairs: order conditions, stability, sums of accelerations, and steps of damped legs."""

from __future__ import annotations

from collections import Counter
from itertools import combinations_with_replacement
from math import factorial

import numpy as np
import pytest

from synth.arrays import Array
from synth.swing.explicit_pairs import DAMPED, DORMAND_PRINCE, RungeKuttaPair

PAIRS = pytest.mark.parametrize("pair", [DORMAND_PRINCE, DAMPED], ids=["dormand_prince", "damped"])
Tree = tuple["Tree", ...]  # a rooted tree by the trees at its root


def order(tree: Tree) -> int:
    """Number of nodes."""
    return 1 + sum(map(order, tree))


def density(tree: Tree) -> int:
    """Hairer, Norsett & Wanner, Solving ODEs I, section II.2: gamma."""
    return order(tree) * int(np.prod([density(each) for each in tree]))


def trees(n: int) -> list[Tree]:
    """All rooted trees with ``n`` nodes."""
    smaller = [tree for k in range(1, n) for tree in trees(k)]
    found = [t for count in range(n) for t in combinations_with_replacement(smaller, count) if order(t) == n]
    assert len(found) == (1, 1, 2, 4, 9, 20)[n - 1]
    return found


def tableau(pair: RungeKuttaPair) -> Array:
    """(7, 7) weights of the stages, the step's end as the last one."""
    return np.array([[*row, *(0.0,) * (7 - len(row))] for row in pair.stages])


def weight(tree: Tree, stages: Array) -> Array:
    """(7,) products of the tree's sums over the stages."""
    return np.prod([stages @ weight(each, stages) for each in tree], axis=0) * np.ones(7)


@PAIRS
def test_the_step_is_of_order_5_and_the_other_of_order_4(pair: RungeKuttaPair) -> None:
    stages, end, missed = tableau(pair), tableau(pair)[-1], np.array(pair.error)
    assert np.allclose(stages.sum(axis=1), pair.nodes, atol=1e-14)
    for tree in (tree for n in range(1, 6) for tree in trees(n)):
        assert end @ weight(tree, stages) == pytest.approx(1.0 / density(tree), abs=1e-14)
        if order(tree) < 5:
            assert missed @ weight(tree, stages) == pytest.approx(0.0, abs=1e-14)
    assert max(abs(missed @ weight(tree, stages)) for tree in trees(5)) > 1e-4


@PAIRS
def test_the_dense_output_is_of_order_4(pair: RungeKuttaPair) -> None:
    stages = tableau(pair)
    for p in (0.1, 0.5, 0.8):
        u = 1.0 - p
        weights = stages[-1] * (p + p * u * (p - u)) + p * p * u * u * np.array(pair.dense)
        weights[0] += p * u * u
        weights[6] -= p * p * u
        for tree in (tree for n in range(1, 5) for tree in trees(n)):
            assert weights @ weight(tree, stages) == pytest.approx(p ** order(tree) / density(tree), abs=1e-13)


@PAIRS
def test_sums_of_accelerations_are_the_tableaus(pair: RungeKuttaPair) -> None:
    stages = tableau(pair)
    for row, expected in zip(pair.turned_stages, stages @ stages, strict=True):
        assert np.allclose(row, expected[: len(row)], atol=1e-13)
        assert not expected[len(row) :].any()
    assert np.allclose(pair.turned_error, (np.array(pair.error) @ stages)[:6], atol=1e-14)
    # left out of the sums of the end of the step and of the error
    assert max(abs(pair.turned_stages[6][1]), abs(pair.turned_error[1])) < 1e-14


def test_decays_are_stable_up_to_longer_steps() -> None:
    def limit(pair: RungeKuttaPair) -> float:
        stages, x = tableau(pair)[:6, :6], np.linspace(0.0, 8.0, 8001)
        growth = [1.0 - h * tableau(pair)[6, :6] @ np.linalg.solve(np.eye(6) + h * stages, np.ones(6)) for h in x]
        return float(x[np.flatnonzero(np.abs(growth) > 1.0 + 1e-12)[0]])

    assert limit(DORMAND_PRINCE) == pytest.approx(3.31, abs=0.01)
    assert limit(DAMPED) == pytest.approx(4.41, abs=0.02)


def test_errors_of_a_step_are_four_times_those_of_dormand_and_prince() -> None:
    """Norm of the principal error; Hairer, Norsett & Wanner, section II.3."""

    def symmetry(tree: Tree) -> int:
        return int(np.prod([factorial(m) * symmetry(each) ** m for each, m in Counter(tree).items()]))

    def norm(pair: RungeKuttaPair) -> float:
        missed = [(tableau(pair)[-1] @ weight(t, tableau(pair)) - 1 / density(t)) / symmetry(t) for t in trees(6)]
        return float(np.linalg.norm(missed))

    assert norm(DORMAND_PRINCE) == pytest.approx(3.99e-4, rel=0.01)
    assert norm(DAMPED) / norm(DORMAND_PRINCE) == pytest.approx(4.0, abs=0.2)


def test_no_six_evaluations_are_stable_beyond_6_3() -> None:
    x = np.linspace(0.0, 8.0, 8001)
    taylor = sum((-x) ** k / factorial(k) for k in range(6))

    def limit(inverse: float) -> float:
        return float(x[np.flatnonzero(np.abs(taylor + x**6 / inverse) > 1.0 + 1e-9)[0]])

    limits = {inverse: limit(inverse) for inverse in range(400, 3000, 2)}
    assert max(limits.values()) == pytest.approx(6.26, abs=0.01)
    assert max(limits, key=lambda inverse: limits[inverse]) == pytest.approx(1378, abs=6)
