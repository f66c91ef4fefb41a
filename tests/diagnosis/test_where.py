"""Where the torque is missing: joints are compared by what holds them, however a missing spring is written."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.simulated_releases import NOISE, TWO, with_effects
from synth.diagnosis.angle_trials import angle_trial
from synth.diagnosis.plants.swinging_chain.chain_where import locate_gap, missing_torque
from synth.files.trial_list import Trial
from synth.fit.recordings import recordings
from synth.swing.chain import simulate
from synth.swing.leg_model import Leg, Spring

TIME = np.arange(301) * 0.01
STARTS = ([0.5, 0.6], [-0.4, 0.7], [0.35, -0.6])


def shares(leg: Leg, torque: float, noise: float, seed: int = 2) -> dict[str, float]:
    """Joint -> share of the missing torque, of a leg with dry friction at the knee alone, N m."""
    built, rng = with_effects(leg, {"knee": {"coulomb_friction": {"torque": torque}}}), np.random.default_rng(seed)
    trials = []
    for k, start in enumerate(STARTS):
        moved = leg.to_measured(simulate(built, start, [0.0, 0.0], TIME))
        trials.append(Trial(f"{k}.csv", TIME, moved + noise * rng.standard_normal(moved.shape)))
    given = [angle_trial(recording, held_out=False) for recording in recordings(leg, trials, ())]
    missing = [missing_torque(leg, trial) for trial in given]
    return dict(locate_gap(leg, given, [t.measured for t in given], np.full(2, noise), missing, {}).joint)


def heavier(leg: Leg, factor: float) -> Leg:
    """The leg with all masses, springs and dampers multiplied: it moves as before."""
    joints = tuple(
        replace(
            joint,
            link=replace(joint.link, mass=factor * joint.link.mass, inertia=factor * joint.link.inertia),
            spring=None if joint.spring is None else replace(joint.spring, rate=factor * joint.spring.rate),
            damper=None if joint.damper is None else replace(joint.damper, rate=factor * joint.damper.rate),
        )
        for joint in leg.joints
    )
    return replace(leg, joints=joints)


@pytest.mark.parametrize("gravity", [9.81, 0.0])
def test_no_spring_and_a_spring_of_rate_zero_give_the_same_place(gravity: float) -> None:
    leg = replace(TWO, gravity=gravity)
    absent, slack = (
        shares(leg.with_joints(hip={"spring": spring}), 0.05, NOISE) for spring in (None, Spring(0.0, 0.5))
    )
    assert absent == pytest.approx(slack)
    assert 0.0 < absent["hip"] < 1.0


def test_a_heavier_leg_has_its_missing_torque_at_the_same_place() -> None:
    leg = TWO.with_joints(hip={"spring": None})
    light, heavy = shares(leg, 0.05, NOISE), shares(heavier(leg, 100.0), 5.0, NOISE)
    assert light == pytest.approx(heavy, abs=1e-3)
    assert 0.0 < light["hip"] < 1.0


@pytest.mark.parametrize("spring", [None, Spring(0.0, 0.5), Spring(6.0, 0.5)])
def test_friction_at_the_knee_is_found_there(spring: Spring | None) -> None:
    """At a hundredth of the usual noise, which an unsprung hip's acceleration is sensitive to."""
    assert shares(TWO.with_joints(hip={"spring": spring}), 0.05, 0.01 * NOISE)["knee"] > 0.99
