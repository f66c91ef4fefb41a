"""A few of the random legs on which the costs are compared: the comparison and its result."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from robustness.random_legs import slowest_time
from robustness.universal import (
    CONTESTANTS,
    FOLLOWED,
    OURS,
    ByJoint,
    Share,
    _errors,
    _fresh,
    case_of,
    groups,
    judge,
    legs_followed,
)
from robustness.universal_page import write_page
from synth.fit.recordings import recordings

SEEDS = (2, 3, 5)  # one and two links: over- and underdamped joints, a second each


@pytest.fixture(scope="module")
def results() -> list[dict]:  # type: ignore[type-arg]
    return [judge(seed) for seed in SEEDS]


def test_ours_follows_where_the_characteristics_do_not(results: list[dict]) -> None:  # type: ignore[type-arg]
    followed = legs_followed(results)
    assert followed[OURS] == len(SEEDS)
    assert followed["trajectory"] == len(SEEDS)  # with everything else known, squares over all samples find the rates
    assert followed["characteristics"] < len(SEEDS)
    assert followed["by joint"] < len(SEEDS)


def test_the_true_leg_is_followed_to_the_last_digit_and_another_is_not() -> None:
    case = case_of(2)
    fresh = _fresh(case)
    assert max(_errors(case, case.leg, fresh)) < 1e-4
    assert max(_errors(case, case_of(5).leg, fresh)) > FOLLOWED
    assert 0.6 <= case.trials[0].time[-1] < 3.01
    assert slowest_time(case.leg) > 0
    assert len(case.starts) == len(case.trials)
    first = case.leg.to_rotation(case.trials[0].angles[0])
    assert np.nanmax(np.abs(first - case.starts[0][0])) < 6 * case.recorder.scatter


def test_the_choice_by_joint_takes_each_joints_own_part() -> None:
    case = case_of(0)
    given = recordings(case.bare, case.trials, ())
    wanted = [recording.rotation[:, :, None] for recording in given]
    cost = ByJoint.of(given)
    (features, _), (squares, _) = cost.parts
    assert (features, squares) == ((0, 1), (2,))
    # the smoothed curve's own features against the samples': near, but squares of the samples are nothing at all
    assert cost.of_motions(wanted)[0, 2] == pytest.approx(0.0, abs=1e-18)


def test_shares_are_counted_by_group(results: list[dict]) -> None:  # type: ignore[type-arg]
    shares = groups(results)
    joints = sum(result["joints"] for result in results)
    assert shares["all joints"][OURS].joints == joints
    by_damping = ("underdamped, ratio under 0.4", "between", "overdamped, ratio over 1")
    by_place = ("first joint", "second joint", "joints beyond")
    for labels in (by_damping, by_place):
        assert sum(shares[label][OURS].joints for label in labels) == joints
        assert sum(shares[label][OURS].followed for label in labels) == shares["all joints"][OURS].followed
    assert Share.of([0.01, 0.04, 0.2]).followed == 2


def test_the_page_lists_how_many_legs_each_method_follows(results: list[dict], tmp_path: Path) -> None:  # type: ignore[type-arg]
    page = write_page(results, tmp_path).read_text()
    assert all(name in page for name in CONTESTANTS)
    assert f"Ours follows every joint of 3 of {len(SEEDS)} legs" in page
    assert (tmp_path / "universal.json").is_file()
