"""A hand at first in recordings of few samples: told by a test that knows how few, or said to be untold."""

from __future__ import annotations

import numpy as np
import pytest

from fit.simulated_legs import RELEASES, bare, robot
from motion.driven_releases import free_motion
from synth.files.trial_list import Trial
from synth.fit.estimate import fit_leg
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_result import FitResult
from synth.fit.later_samples import LEAST_COMPARED, ResidualFreedom, comparison_begin, recordings_from
from synth.fit.recordings import recordings
from synth.swing.mechanics import rest_pose

LEG = robot()
UNTOLD = "cannot tell a torque of a hand"


def video(samples: int, rate: float, fade: float, seed: int = 1) -> list[Trial]:
    """Three releases at ``rate`` Hz with 0.1 deg of noise, of a hand that fades within ``fade`` s."""
    generator, time = np.random.default_rng(seed), np.arange(samples) / rate
    made = []
    for k, away in enumerate(RELEASES[:3]):
        rotation = free_motion(LEG, rest_pose(LEG) + np.radians(away), time, fade)
        noise = generator.normal(0.0, np.radians(0.1), rotation.shape)
        made.append(Trial(f"{k}.csv", time, LEG.to_measured(rotation) + noise))
    return made


def fitted(trials: list[Trial]) -> FitResult:
    return fit_leg(bare(LEG), recordings(bare(LEG), trials), LegFitOptions(release="free"))


def test_a_hand_is_cut_from_recordings_of_26_samples() -> None:
    """No test was made of fewer than thirty, and nothing said: the springs were 7, 23 and 34 % off."""
    found = fitted(video(26, 50.0, 0.12))
    assert found.cut > 0.0
    assert not any(UNTOLD in text for text in found.warnings)
    for joint in LEG.joints:
        assert joint.spring is not None
        estimate = found.joints[joint.name].spring_rate
        assert estimate.low is not None
        assert estimate.high is not None
        assert estimate.low <= joint.spring.rate <= estimate.high


@pytest.mark.parametrize("seed", range(6))
def test_free_recordings_of_few_samples_are_kept_whole(seed: int) -> None:
    """By a noise that is taken as known, 9 of 60 such videos of 18 samples were cut or took a drift."""
    found = fitted(video(18, 50.0, 0.0, seed))
    assert found.cut == 0.0
    assert not any("do not fit one leg" in text for text in found.warnings)


def test_recordings_of_too_few_later_samples_say_so() -> None:
    found = fitted(video(14, 50.0, 0.12))
    assert found.cut == 0.0
    (said,) = [text for text in found.warnings if UNTOLD in text]
    assert "of the shortest, 6 samples are left after 156 ms" in said
    asked_for_all = fit_leg(bare(LEG), recordings(bare(LEG), video(14, 50.0, 0.12)))
    assert not any(UNTOLD in text for text in asked_for_all.warnings)


def test_a_joint_that_is_lost_at_the_end_leaves_no_later_samples() -> None:
    """Forty rows remained, of which the ankle had four samples: its smoothing stopped with a traceback."""
    (one, *_) = recordings(bare(LEG), video(60, 50.0, 0.0))
    one.counts[24:, 2] = False
    assert recordings_from([one], 0.4) is None
    assert recordings_from([one], 0.2) is not None


def test_degrees_of_freedom_of_later_samples() -> None:
    made = recordings(bare(LEG), video(26, 50.0, 0.0))
    begin = comparison_begin(made)
    later = recordings_from(made, begin, LEAST_COMPARED)
    assert later is not None
    common, apart = (ResidualFreedom.of(later, np.full(3, spread)) for spread in (0.0, 0.1))
    assert begin == pytest.approx(0.3)
    assert common.samples.tolist() == [33.0] * 3
    assert common.unknowns.tolist() == [9.0] * 3  # three angles and rates; spring, damper, free angle
    assert apart.unknowns.tolist() == [11.0] * 3
    assert common.fewest == 24.0
    assert common.enlarged == pytest.approx(33 / 24)
