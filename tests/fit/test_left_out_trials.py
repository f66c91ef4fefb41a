"""Rates that one trial moves beyond their intervals are named where the model does not explain the trials."""

from __future__ import annotations

from dataclasses import replace

import pytest

from fit.simulated_legs import bare, releases, robot
from synth.fit.estimate import fit_leg
from synth.fit.fit_options import LegFitOptions
from synth.fit.recordings import recordings
from synth.swing.leg_model import Spring

PLAIN = LegFitOptions(free_angle="common", release="recorded", laws="linear")


def test_trials_of_one_leg_give_no_sentence() -> None:
    leg = bare(robot())
    found = fit_leg(leg, recordings(leg, releases(robot(), 3)), PLAIN)
    assert not any("leaving out one trial" in text for text in found.warnings)


@pytest.mark.parametrize(("factor", "second_order"), [(1.5, 0.05), (1.1, 0.02)])
def test_a_trial_of_a_stiffer_knee_is_told_at_the_knee(factor: float, second_order: float) -> None:
    """The intervals of the knee's rate from subsets of a rat's recordings exclude each other, and no note named it."""
    true = robot()
    spring = true.joints[1].spring
    assert spring is not None
    stiff = true.with_joints(knee={"spring": Spring(factor * spring.rate, spring.free_angle)})
    trials = [*releases(true, 3)[:2], replace(releases(stiff, 3)[2], name="stiffer")]
    leg = bare(true)
    found = fit_leg(leg, recordings(leg, trials), PLAIN)
    (text,) = (text for text in found.warnings if text.startswith("knee: leaving out one trial moves the spring rate"))
    assert text.endswith("beyond its interval: intervals hold only if the model does")
    low, high = (float(word) for word in text.split(" within ")[1].split(" N*m/rad")[0].split(" to "))
    told = found.joints["knee"].spring_rate
    assert told.low is not None
    assert low < told.low
    others = fit_leg(leg, recordings(leg, trials[:2]), PLAIN).joints["knee"].spring_rate.value
    assert others == pytest.approx(spring.rate, rel=0.01)
    assert low == pytest.approx(others, rel=second_order)
    assert high >= 0.99 * told.value
