"""The search over sets of parts: lanes against single simulations, screening against simulating every set."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from synth.design.part_lanes import ActingElements, PartLanes
from synth.design.part_search import Mistake, _Screen, best_sets
from synth.design.response import WantedRelease, WantedResponse
from synth.swing.chain import Conditions
from synth.swing.leg_model import Damper, Spring
from three_links import LEG, TIME, grid, wanted


@pytest.fixture(scope="module")
def small() -> PartLanes:
    """1000 sets: ten pairs a joint."""
    return PartLanes(wanted(), LEG, grid(5, 2))


def test_lanes_equal_single_simulations(small: PartLanes) -> None:
    index = np.array([[0, 0, 0], [3, 7, 1], [9, 2, 5]])
    legs = []
    for row in index:
        chosen = [options[k] for options, k in zip(small.acting, row, strict=True)]
        joints = tuple(
            replace(joint, spring=Spring(part.rate, 0.0), damper=part.damper)
            for joint, part in zip(LEG.joints, chosen, strict=True)
        )
        legs.append(small.wanted.at_rest_like_wanted(replace(LEG, joints=joints)))
    assert small.errors(index) == pytest.approx(small.wanted.overall(legs), rel=2e-4)


def test_the_wanted_parts_have_no_error() -> None:
    acting = [[ActingElements(j.spring.rate, j.damper)] for j in LEG.joints if j.spring and j.damper]
    lanes = PartLanes(wanted(), LEG, acting)
    assert lanes.errors(np.zeros((1, 3), dtype=np.int64))[0] < 1e-5


def test_a_diverging_leg_gets_the_largest_error() -> None:
    acting = [[ActingElements(j.spring.rate, j.damper)] for j in LEG.joints if j.spring and j.damper]
    acting[2].append(ActingElements(0.5, Damper(1e7)))
    lanes = PartLanes(wanted(), LEG, acting)
    assert lanes.errors(np.array([[0, 0, 1]]))[0] == pytest.approx(np.pi)


def test_squared_residuals_sum_to_the_error(small: PartLanes) -> None:
    index = np.array([[1, 2, 3], [4, 5, 6]])
    squared = np.sum(small.residuals(index) ** 2, axis=0)
    assert np.sqrt(squared) == pytest.approx(small.errors(index), rel=1e-4)


def test_screening_is_exact_where_one_joint_differs_from_the_base(small: PartLanes) -> None:
    base = np.array([2, 2, 2])
    screen = _Screen(small, base, 1)
    index = np.array([[2, 2, 2], [7, 2, 2], [2, 0, 2], [2, 2, 9]])
    assert screen.errors(index) == pytest.approx(small.errors(index), rel=1e-3)


def test_screening_returns_the_best_of_all_sets(small: PartLanes) -> None:
    screen = _Screen(small, np.array([0, 0, 0]), 1)
    numbers, guess = screen.best(50)
    index = np.stack(np.unravel_index(np.arange(small.n_set), small.counts), axis=1)
    every = screen.errors(index)
    assert guess == pytest.approx(np.sort(every)[:50])
    assert every[numbers] == pytest.approx(guess)


@pytest.mark.parametrize(("seed", "spread"), [(0, 2.5), (1, 4.0), (2, 1.5)])
def test_screening_gives_the_same_best_sets_as_full_simulation(seed: int, spread: float) -> None:
    """The best twelve of 1000 sets, in order, from a start anywhere, for parts near each other and far apart."""
    small = PartLanes(wanted(), LEG, grid(5, 2, spread, seed))
    whole = best_sets(small, [0, 0, 0], 12)
    screened = best_sets(small, [0, 0, 0], 12, exhaustive=0)
    assert whole.exhaustive
    assert whole.n_simulated == 1000
    assert screened.n_set == 1000
    assert screened.complete
    assert screened.mistake is not None
    assert screened.index.tolist() == whole.index.tolist()
    assert screened.error == pytest.approx(whole.error, rel=1e-4)


def test_the_screening_error_bound_grows_away_from_the_best() -> None:
    mistake = Mistake(best=1.0, slope=0.3, ratio=0.6)
    guess = np.array([1.0, 1.2, 2.0, 3.0])
    least = mistake.least(guess)
    assert least == pytest.approx([0.985, 1.2 * (1 - 0.3 * 0.25), 2.0 * (1 - 0.3 * 1.05), 3.0 * 0.6])


def test_screening_works_with_one_joint() -> None:
    """With nothing to act on each other the screen is exact."""
    options = grid(30, 10)[2]
    leg = replace(LEG, joints=LEG.joints[2:])
    release = WantedRelease("a", TIME, np.array([0.5]), np.zeros(1), Conditions())
    lanes = PartLanes(WantedResponse.of(leg, [release]), leg, [options])
    whole, screened = best_sets(lanes, [0], 5), best_sets(lanes, [0], 5, exhaustive=0)
    assert screened.index.tolist() == whole.index.tolist()
    assert screened.complete
