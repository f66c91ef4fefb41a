"""A fit refuses trials in which a servo with an integral acts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import synth
from synth.drives.servo import Servo, ServoSignals
from synth.errors import UserError
from synth.files.trial_list import Trial
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

TIME = np.arange(0.0, 2.0, 0.01)


def arm(integral_gain: float) -> Leg:
    drive = Servo(4.0, 0.12, integral_gain=integral_gain, torque_limit=3.0)
    link = Link(0.12, 0.49, 0.1, 1e-4)
    return Leg("arm", (Joint("arm", link, spring=Spring(0.8, 0.1), damper=Damper(0.05), drive=drive),))


def driven(leg: Leg) -> Trial:
    command, one = 0.5 * np.sin(6.0 * TIME)[:, None], np.ones((len(TIME), 1))
    signals = ServoSignals(TIME, command, one, one, (0,))
    return Trial("a.csv", TIME, simulate(leg, command[0], [0.0], TIME, signals=signals), signals=signals)


def test_a_servo_with_an_integral_is_refused() -> None:
    leg = arm(12.0)
    with pytest.raises(UserError, match=r"servo of arm has an integral_gain and a command in a\.csv"):
        synth.fit(leg, [driven(leg)])


def test_without_the_drive_or_its_integral_the_spring_is_found() -> None:
    proportional = arm(0.0)
    passive = replace(proportional, joints=(replace(proportional.joints[0], drive=None),))
    swing = Trial("b.csv", TIME, simulate(passive, [0.5], [0.0], TIME))
    for actual, trial in ((passive, swing), (proportional, driven(proportional))):
        (joint,) = actual.joints
        start = replace(actual, joints=(replace(joint, spring=Spring(0.6, 0.1), damper=Damper(0.03)),))
        found = synth.fit(start, [trial]).joints["arm"].spring_rate
        assert found.value == pytest.approx(0.8, rel=0.01)
