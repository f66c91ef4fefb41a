"""All channels of a trial on one clock, thinned or not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from synth.arrays import Array
from synth.drives.servo import Servo, ServoSignals
from synth.errors import UserError
from synth.files.trial_list import Trial
from synth.fit.recordings import Recording, recordings
from synth.fit.weak_form import weak_form
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

LINK = Link(0.2, 0.5, 0.1, 0.002)
INERTIA = LINK.inertia + LINK.mass * LINK.com**2
LEG = Leg("one", (Joint("knee", LINK, 0.0, 1, None, Spring(1.7, 0.0), Damper(0.02)),), gravity=0.0)
BEGIN = 5.0  # s, of the trial's clock
OMEGA, DECAY = 2.0 * np.pi, 0.1  # rad/s and 1/s


def swing(time: Array) -> Array:
    """0.5 rad exp(-d t) cos(w t), of which k = I (w^2 + d^2) and b = 2 I d."""
    return 0.5 * np.exp(-DECAY * time) * np.cos(OMEGA * time)


def rate(time: Array) -> Array:
    """Its derivative."""
    return -0.5 * np.exp(-DECAY * time) * (DECAY * np.cos(OMEGA * time) + OMEGA * np.sin(OMEGA * time))


def noisy(values: Array, size: float) -> Array:
    return (values + size * np.random.default_rng(0).standard_normal(len(values)))[:, None]


def trial(hertz: int, seconds: float) -> Trial:
    """The swing with its velocity, of so little noise that it is preferred to the angle's slope."""
    time = np.arange(0.0, seconds, 1.0 / hertz)
    return Trial("a.csv", BEGIN + time, noisy(swing(time), 0.0017), velocities=noisy(rate(time), 0.001))


def origin(made: Recording, given: Trial) -> float:
    """Time of the recording's first sample from the trial's, s: half of the first group."""
    return float(np.mean(given.time[: made.averaged[0]])) - BEGIN


@pytest.mark.parametrize(("hertz", "seconds", "group"), [(200, 20.0, 1), (500, 20.0, 3), (1000, 20.0, 7)])
def test_a_recorded_velocity_is_the_slope_of_the_angle(hertz: int, seconds: float, group: int) -> None:
    """Half a group early it missed by 1.3 and 1.9 % of the largest rate, and b was 39 and 59 % too low."""
    given = trial(hertz, seconds)
    (made,) = recordings(LEG, [given])
    assert made.averaged == (group,)
    time = made.smoothed.time + origin(made, given)
    assert float(np.std(made.smoothed.rate[:, 0] - rate(time))) < 0.0005 * 0.5 * OMEGA
    (slope,) = recordings(LEG, [replace(given, velocities=None)])
    assert float(np.std(slope.smoothed.rate[:, 0] - rate(time))) > 0.001 * 0.5 * OMEGA  # the column was used
    found = weak_form(LEG, [made])
    assert found.spring_rate[0] == pytest.approx(INERTIA * (OMEGA**2 + DECAY**2), rel=0.005)
    assert found.damper_rate[0] == pytest.approx(2.0 * INERTIA * DECAY, rel=0.05)


def test_a_velocity_of_a_shaking_motor_is_the_slope_of_the_angle() -> None:
    """A quasi-direct drive's own speed, of half the true one's size in noise at 300 Hz, was refused as another joint's.

    Of 110 Hz, as the drive chattered (torque_limited_simple_pendulum, ``sysid``), the angle has 0.05 of 1.4 rad.
    """
    time = np.arange(0.0, 5.0, 1.0 / 300.0)
    shaken = rate(time) + 1.8 * np.sin(2.0 * np.pi * 110.0 * time)
    given = Trial("a.csv", time, noisy(swing(time), 0.0017), velocities=noisy(shaken, 0.001))
    (made,) = recordings(LEG, [given])
    assert float(np.std(made.smoothed.rate[:, 0] - rate(time))) < 0.03 * 0.5 * OMEGA
    late = replace(given, velocities=noisy(rate(time - 0.1), 0.001))
    with pytest.raises(UserError, match=r"is not the angle's slope .*late\? Correct the column"):
        recordings(LEG, [late])


@pytest.mark.parametrize("hertz", [200, 1000])
def test_torque_and_command_are_on_the_angles_clock(hertz: int) -> None:
    """All channels contain the same function of time, so that each must have the value of the angle."""
    servo = Servo(gain=1.0, torque_limit=1.0)
    driven = replace(LEG, joints=(replace(LEG.joints[0], drive=servo),))
    plain = trial(hertz, 20.0)
    time, ones = plain.time, np.ones((len(plain.time), 1))
    known = swing(time - BEGIN)[:, None]
    given = replace(plain, velocities=None, torques=known, signals=ServoSignals(time, known, ones, ones))
    (made,) = recordings(driven, [given])
    begin = origin(made, given)
    assert made.known_torque is not None
    assert made.signals is not None
    moments, torque = made.known_torque
    inside = (moments >= 0.0) & (moments <= made.time[-1])
    assert inside.sum() > 1000
    np.testing.assert_allclose(torque[inside, 0], swing(moments + begin)[inside], atol=1e-6)
    np.testing.assert_allclose(made.signals.command[:, 0], swing(made.signals.time + begin), atol=1e-12)
    np.testing.assert_allclose(made.rotation[:, 0], swing(made.time + begin), atol=0.01)
