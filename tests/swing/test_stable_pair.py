"""The explicit pair: order conditions by rooted trees, stability, dense output, and its cost beside the old pair's."""

from __future__ import annotations

import itertools
import math
from functools import cache

import numpy as np

from synth.arrays import Array
from synth.swing import stable_pair
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

Tree = tuple["Tree", ...]


@cache
def trees(order: int) -> list[Tree]:
    """All rooted trees with so many nodes, each as its sorted branches (Butcher's)."""
    if order == 1:
        return [()]
    found = set()
    for sizes in parts(order - 1, order - 1):
        for branches in itertools.product(*map(trees, sizes)):
            found.add(tuple(sorted(branches)))
    return sorted(found)


def parts(total: int, most: int) -> list[list[int]]:
    """The partitions of a number."""
    if total == 0:
        return [[]]
    return [[k, *rest] for k in range(min(total, most), 0, -1) for rest in parts(total - k, k)]


def order_of(tree: Tree) -> int:
    return 1 + sum(map(order_of, tree))


def density(tree: Tree) -> int:
    return order_of(tree) * math.prod(map(density, tree))


TABLEAU = np.array([[*row, *(0.0,) * (7 - len(row))] for row in stable_pair.STAGES])


def of_stages(tree: Tree) -> Array:
    """(7,) elementary weight of a tree in each stage."""
    found = np.ones(7)
    for branch in tree:
        found = found * (TABLEAU @ of_stages(branch))
    return found


def all_trees(last: int) -> list[Tree]:
    return [tree for order in range(1, last + 1) for tree in trees(order)]


def test_the_step_has_order_five_and_the_estimate_order_four() -> None:
    for tree in all_trees(5):
        assert abs(TABLEAU[-1] @ of_stages(tree) - 1 / density(tree)) < 1e-14
    error = np.array(stable_pair.ERROR)
    for tree in all_trees(4):
        assert abs(error @ of_stages(tree)) < 1e-15
    assert max(abs(error @ of_stages(tree)) for tree in trees(5)) > 1e-4 * stable_pair.SCALE


def test_nodes_and_sums_of_accelerations_follow_from_the_tableau() -> None:
    assert np.allclose(TABLEAU.sum(axis=1), stable_pair.NODES, atol=1e-15)
    squared = TABLEAU @ TABLEAU
    for row, expected in zip(stable_pair.TURNED_STAGES, squared, strict=True):
        assert np.allclose(row, expected[: len(row)], atol=1e-15)
        assert not expected[len(row) :].any()
    assert np.allclose(stable_pair.TURNED_ERROR, (np.array(stable_pair.ERROR) @ TABLEAU)[:6], atol=1e-16)


def test_the_dense_output_has_order_four_everywhere() -> None:
    # y(p) of the test equations of a tree is p^order / density; Hermite's cubic and the term between the ends add up
    # to it
    for tree, p in itertools.product(all_trees(4), (0.2, 0.5, 0.9)):
        weights = of_stages(tree)
        rise, first, last = TABLEAU[-1] @ weights, weights[0], weights[6]
        bow = first - rise
        middle = np.array(stable_pair.DENSE) @ weights
        value = p * (rise + (1 - p) * (bow + p * (rise - last - bow + (1 - p) * middle)))
        assert abs(value - p ** order_of(tree) / density(tree)) < 1e-13


def test_it_is_stable_to_4_86_on_the_real_axis() -> None:
    powers, vector = [1.0], np.ones(7)
    for _ in range(6):
        powers.append(float(TABLEAU[-1] @ vector))
        vector = TABLEAU @ vector
    at = np.linspace(0.0, 4.86, 2000)
    assert np.abs(np.polyval(powers[::-1], -at)).max() <= 1.0 + 1e-12
    assert abs(np.polyval(powers[::-1], -4.9)) > 1.0


def test_a_heavily_damped_joint_is_followed_through_its_fast_and_its_slow_mode() -> None:
    # (s + 2000) (s + 5) in closed form: the step is limited by stability almost from the start
    fast, slow, inertia = 2000.0, 5.0, 1e-3
    joint = Joint(
        "j",
        Link(0.1, 0.0, 0.0, inertia),
        spring=Spring(inertia * fast * slow, 0.0),
        damper=Damper(inertia * (fast + slow)),
    )
    times = np.linspace(0.0, 1.0, 101)
    expected = 0.4 * (fast * np.exp(-slow * times) - slow * np.exp(-fast * times)) / (fast - slow)
    got = simulate(Leg("damped", (joint,), gravity=0.0), [0.4], [0.0], times, tolerance=1e-6)[:, 0]
    assert np.abs(got - expected).max() < 1e-7
