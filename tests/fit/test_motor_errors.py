"""Intervals include the tolerances of motors where their torque tells the scale of the rates."""

from __future__ import annotations

import numpy as np
import pytest

from fit.simulated_legs import bare
from synth.files.tolerance import Tolerance
from synth.files.trial_list import Trial
from synth.fit.estimate import fit_leg
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_result import FitResult
from synth.fit.recordings import recordings
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

LEG = Leg("arm", (Joint("knee", Link(0.2, 0.3, 0.12, 2e-3), spring=Spring(1.2, 0.2), damper=Damper(0.02)),))
TIMES = np.arange(0.0, 3.0, 0.01)
EXACT = {"length": 0.0, "mass": 0.0, "com": 0.0, "inertia": 0.0}  # of links


def fitted(factor: float, tolerance: Tolerance, *, by_current: bool = True) -> FitResult:
    """Of a leg whose recorded current was taken times a constant that was off by ``factor``."""
    rng, trials = np.random.default_rng(3), []
    for k in range(2):
        torque = 0.6 * np.sin((5.0 + 3.0 * k) * TIMES + 0.4)[:, None]
        moved = simulate(LEG, [0.4], [0.0], TIMES, known_torque=(TIMES, factor * torque))
        read = moved + np.radians(0.05) * rng.standard_normal(moved.shape)
        names = ("knee",) if by_current else ()
        trials.append(Trial(f"{k}.csv", TIMES, LEG.to_measured(read), torques=torque, by_current=names))
    leg = bare(LEG)
    return fit_leg(leg, recordings(leg, trials), LegFitOptions(tolerance=tolerance))


def half_width(result: FitResult) -> float:
    """Half of the rate's 90 % interval, of its logarithm."""
    rate = result.joints["knee"].spring_rate
    assert rate.low is not None
    assert rate.high is not None
    return 0.5 * float(np.log(rate.high / rate.low))


def test_a_rate_is_known_no_better_than_the_motor_that_tells_it() -> None:
    """Links of no weight but the torque's: the rate follows the constant, 8 % off of 10 %."""
    found = fitted(1.08, Tolerance(**EXACT, torque_constant=0.1))
    rate = found.joints["knee"].spring_rate
    assert rate.low is not None
    assert rate.high is not None
    assert rate.low < 1.2 < rate.high
    exact = fitted(1.08, Tolerance(**EXACT, torque_constant=0.0)).joints["knee"].spring_rate
    assert exact.high is not None
    assert exact.high < 1.2
    shares = next(source.shares for source in found.sources if source.quantity == "spring_rate")
    assert shares["torque constant of the knee's motor"] > 0.9


def test_a_torque_that_was_measured_has_no_motor_s_tolerance() -> None:
    by_current, measured = (
        half_width(fitted(1.0, Tolerance(**EXACT, torque_constant=0.1), by_current=each)) for each in (True, False)
    )
    assert by_current > 5.0 * measured
    assert measured == pytest.approx(half_width(fitted(1.0, Tolerance(**EXACT, torque_constant=0.0))), rel=0.05)


@pytest.mark.parametrize("torque", [0.0, 0.1])
def test_only_a_drive_that_acts_tells_the_scale_of_masses(torque: float) -> None:
    known = TIMES, torque * np.sin(6.0 * TIMES)[:, None]
    moved = simulate(LEG, [1.1], [0.0], TIMES, known_torque=known)
    trial = Trial("a.csv", TIMES, LEG.to_measured(moved), torques=known[1])
    found = fit_leg(bare(LEG), recordings(LEG, [trial]), LegFitOptions(tolerance=None))
    told = any("mass scale" in str(remark) for remark in found.not_separable)
    assert told == (torque == 0.0)
