"""Priors weighed beside links that are not known exactly: against the closed form of two sources of one number."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from fit.simulated_legs import bare
from synth.estimation.intervals import NORMAL90
from synth.files.static_points_file import StaticPoint
from synth.files.tolerance import Tolerance
from synth.files.trial_list import Trial
from synth.fit.estimate import fit_leg
from synth.fit.fit_options import LegFitOptions, RatePrior
from synth.fit.fit_result import FitResult
from synth.fit.recordings import recordings
from synth.fit.uncertainty import MASS_SCALE
from synth.remarks import kind_of
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

RATE, DAMPING, INERTIA = 1.2, 0.01, 2e-3
TIMES = np.arange(0.0, 2.0, 0.01)


def wheel(inertia: float, rate: float = RATE) -> Leg:
    """A wheel on a spring: the trials tell the rates over its inertia, and nothing else."""
    link = Link(0.2, 0.3, 0.0, inertia)
    return Leg("wheel", (Joint("axle", link, spring=Spring(rate, 0.2), damper=Damper(DAMPING)),), gravity=0.0)


def fitted(
    inertia: float, stated: float, prior: float | None, tolerance: float = 0.02, static: Sequence[StaticPoint] = ()
) -> FitResult:
    """Of the wheel with ``inertia`` times the stated one, and with a rate stated as ``stated`` times its own."""
    rng, built = np.random.default_rng(3), wheel(inertia * INERTIA)
    trials = []
    for k, start in enumerate((1.2, -0.8, 0.9)):
        moved = simulate(built, [start], [0.0], TIMES)
        read = moved + np.radians(0.02) * rng.standard_normal(moved.shape)
        trials.append(Trial(f"{k}.csv", TIMES, built.to_measured(read)))
    given = wheel(INERTIA, stated * RATE)
    options = LegFitOptions(
        tolerance=Tolerance(length=0.0, mass=0.0, com=0.0, inertia=tolerance),
        prior=None if prior is None else RatePrior(spring=prior, damper=None, free_angle=None),
        static=tuple(static),
    )
    return fit_leg(given if prior is not None else bare(given), recordings(given, trials), options)


@pytest.mark.parametrize("prior", [0.05, 0.02, 0.005, 0.001])
def test_a_prior_and_the_inertia_are_weighed_by_what_is_known_of_each(prior: float) -> None:
    """Stated to 0.5 % beside an inertia known to 2 %, a rate stayed four deviations off, in too wide an interval."""
    found = fitted(0.97, 1.01, prior)
    rate, damper = found.joints["axle"].spring_rate, found.joints["axle"].damper_rate
    assert rate.low is not None
    assert rate.high is not None
    assert damper is not None
    weight = prior**-2 / (prior**-2 + 0.02**-2)
    expected = (1.0 - weight) * np.log(1.0 / 0.97) + weight * np.log(1.01)
    assert np.log(rate.value / RATE) == pytest.approx(expected, abs=4e-4)
    # The trials tell b/k: the damper follows the rate.
    assert np.log(damper.value / DAMPING) == pytest.approx(expected, abs=5e-3)
    half = 0.5 * np.log(rate.high / rate.low)
    noise = 4e-4  # of the trials' own, as an exact inertia shows
    assert half == pytest.approx(NORMAL90 / np.hypot(1.0 / prior, 1.0 / 0.02), abs=noise)
    inertia = found.leg.joints[0].link.inertia
    assert rate.value / inertia == pytest.approx(RATE / (0.97 * INERTIA), rel=1e-3)
    open_ = [text for text in found.not_separable if kind_of(text) == MASS_SCALE]
    assert bool(open_) == (prior > 0.01)


@pytest.mark.parametrize("error", [0.02, 0.005])
def test_a_static_point_is_weighed_as_a_prior_is(error: float) -> None:
    """A torque known to a share beside an inertia known to 2 %: the same two sources of one number."""
    turned, torque = 1.0, 1.01 * RATE
    point = StaticPoint(
        "held", np.array([0.2 + turned]), np.array([torque * turned]), (0,),
        torque_error=error * torque * turned, angle_error=1e-6,
    )  # fmt: skip
    found = fitted(0.97, 1.0, None, static=[point])
    rate = found.joints["axle"].spring_rate
    assert rate.low is not None
    assert rate.high is not None
    weight = error**-2 / (error**-2 + 0.02**-2)
    expected = (1.0 - weight) * np.log(1.0 / 0.97) + weight * np.log(1.01)
    assert np.log(rate.value / RATE) == pytest.approx(expected, abs=6e-4)
    half = 0.5 * np.log(rate.high / rate.low)
    assert half == pytest.approx(NORMAL90 / np.hypot(1.0 / error, 1.0 / 0.02), abs=6e-4)


def test_exact_links_and_no_prior_change_nothing() -> None:
    exact = fitted(1.0, 1.01, 0.005, tolerance=0.0)
    assert exact.leg.joints[0].link.inertia == INERTIA
    assert exact.joints["axle"].spring_rate.value == pytest.approx(RATE, rel=5e-4)
    none = fitted(0.97, 1.0, None)
    assert none.leg.joints[0].link.inertia == INERTIA
    assert none.joints["axle"].spring_rate.value == pytest.approx(RATE / 0.97, rel=5e-4)


def test_a_prior_that_the_trials_contradict_is_told() -> None:
    found = fitted(0.9, 1.0, 0.002, tolerance=0.01)
    (told,) = [text for text in found.warnings if "the stated one" in text]
    assert told.startswith("axle: the trials find a spring rate 11 % above the stated one, 10 deviations")
    assert not [text for text in fitted(0.99, 1.0, 0.002, tolerance=0.01).warnings if "the stated one" in text]
