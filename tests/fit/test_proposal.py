"""The proposed measurement helps as much as is promised."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
import pytest

from fit.simulated_legs import DAMPER, SPRING, Rig, errors, fitted, recorded, releases, robot
from fit.test_static_points import OVERDAMPED, held
from synth.commands.answers import fit_text
from synth.estimation.intervals import NORMAL90
from synth.files.project_options import RatePrior
from synth.fit.estimate import fit_leg
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_result import FitResult
from synth.fit.interval_sources import IntervalSource
from synth.fit.proposal import Proposal
from synth.swing.leg_model import Leg

TRIALS = releases(OVERDAMPED, 1, Rig(noise=0.5), 3)
ALONE = fitted(OVERDAMPED, TRIALS)
TABLED = re.compile(r"\S+ to \S+")


def only(result: FitResult) -> Proposal:
    (proposal,) = result.proposals
    return proposal


def test_the_proposal_holds_the_overdamped_hip_far_from_rest() -> None:
    proposal = only(ALONE)
    assert proposal.joint == "hip"
    hip = ALONE.joints["hip"]
    # some 14 deg from the free angle, the farthest that the trials went
    assert abs(np.degrees(proposal.angles[0] - hip.free_angle.value)) > 10.0
    expected = hip.spring_rate.value * (proposal.angles[0] - hip.free_angle.value)
    assert proposal.torque == pytest.approx(expected, rel=0.2)  # the rest is the leg's weight
    assert "hold it still at" in proposal.sentence
    assert "N*m about the hip" in proposal.sentence
    assert proposal.before > 0.2
    assert proposal.after < 0.1
    written = proposal.as_json()
    assert written["torque"]["unit"] == "N*m"
    assert written["spring_rate_within"]["then"]["value"] == pytest.approx(proposal.after)


def test_one_interval_in_table_note_proposal_and_source() -> None:
    """The note told the trials' alone, the proposal half the logarithm's: +-27 and +-250 % for -69 to +277 %."""
    row = next(line for line in fit_text(ALONE.as_json()).splitlines() if line.startswith("hip "))
    rate, damping = (
        f"{ends} {unit}" for ends, unit in zip(TABLED.findall(row), ("N*m/rad", "N*m*s/rad"), strict=False)
    )
    note = next(text for text in ALONE.not_separable if "not separable: spring rate" in text)
    assert f"but k only as {rate} and b as {damping} (90 %)" in note
    proposal = only(ALONE)
    assert f"now it is {rate}. Enter" in proposal.sentence
    assert f"its spring rate is {rate} (90 %)" in proposal.brief
    assert "+-" not in note
    shares = {"trials": 0.1, "mass of the hip's link": 0.9}
    told = IntervalSource("hip", "spring_rate", proposal.before, ALONE.joints["hip"].spring_rate, shares).sentence
    assert told is not None
    assert f"the spring rate's 90 % interval, {rate}, comes from" in told


def test_a_rate_that_is_stated_is_not_left_open() -> None:
    """With a prior of 0.1 % the notes still told it to +-67 %, beside an interval of +-0.2 %."""
    prior = RatePrior(spring=0.001, damper=None, free_angle=None)
    stated = fit_leg(OVERDAMPED, recorded(OVERDAMPED, TRIALS), LegFitOptions(prior=prior))
    hip = stated.joints["hip"].spring_rate
    assert hip.value == pytest.approx(OVERDAMPED.joints[0].spring.rate, rel=0.002)  # type: ignore[union-attr]
    assert not any(text.startswith("hip:") and "spring" in text for text in stated.not_separable)
    assert not stated.families
    assert not stated.proposals


def test_the_proposed_measurement_gives_the_promised_interval() -> None:
    """Measured as proposed, on the true leg: the interval is the promised one, and holds the truth."""
    proposal = only(ALONE)
    point = held(
        OVERDAMPED,
        np.degrees(proposal.angles),
        0,
        torque_error=proposal.torque_error,
        angle_error=proposal.angle_error,
    )
    after = fitted(OVERDAMPED, TRIALS, static=(point,))
    missed = errors(after, OVERDAMPED)
    assert np.expm1(NORMAL90 * missed.spring_sd[0]) == pytest.approx(proposal.after, rel=0.25)
    assert abs(missed.spring[0]) < 3 * missed.spring_sd[0]
    assert not after.proposals


def test_a_leg_whose_rates_are_fixed_gets_no_proposal() -> None:
    leg = robot()
    assert not fitted(leg, releases(leg, 3, Rig(noise=0.1), 3)).proposals


def test_the_proposal_stays_within_the_joints_travel() -> None:
    travel = tuple(np.radians([100.0, 112.0]))
    joints = (dataclasses.replace(OVERDAMPED.joints[0], range=travel), *OVERDAMPED.joints[1:])
    leg: Leg = dataclasses.replace(OVERDAMPED, joints=joints)
    proposal = only(fitted(leg, TRIALS))
    assert travel[0] - 1e-9 <= proposal.angles[0] <= travel[1] + 1e-9


def test_a_tip_mass_is_proposed_where_the_joint_sags_under_it() -> None:
    """The foot hangs under the hip, whose spring a mass there hardly turns; the knee folds, and that tells its rate."""
    leg = robot(SPRING, DAMPER * np.array([10.0, 10.0, 1.0]))
    found = {p.joint: p for p in fitted(leg, releases(leg, 5, Rig(noise=0.5), 2)).proposals}
    knee = found["knee"]
    assert knee.tip_mass is not None
    assert knee.tip_after is not None
    assert 0.0 < knee.tip_mass < 1.1  # kg, twice the leg
    assert knee.tip_after < knee.before
    assert f"{1e3 * knee.tip_mass:.0f} g at the tip" in knee.sentence
    assert knee.as_json()["or_tip_mass"]["rest_angle"]["unit"] == "deg"
    assert found["hip"].tip_mass is None


def test_the_tip_mass_proposed_for_the_mass_scale_doubles_the_last_inertia() -> None:
    """(4.17e-4 + 0.09 x 0.03^2) kg m^2 over (0.16 m)^2: 19 g."""
    leg = robot()
    (said,) = (t for t in fitted(leg, releases(leg, 3, Rig(noise=0.1), 2)).not_separable if "mass scale" in t)
    assert "`tip_mass: 19 g`" in said
    assert "about the ankle doubles" in said
