"""Play of a drive's gear against scipy: the same flanks, and rigid ones from blow to blow."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from synth.arrays import Array
from synth.drives.motor import GearedMotor
from synth.drives.servo import Servo, ServoSignals
from synth.swing.chain import simulate
from synth.swing.effects.gear_play import LEAST_ROTOR
from synth.swing.leg_model import Joint, Leg, Link

LINK = Link(0.12, 0.49, 0.1, 1e-4)
MOTOR = GearedMotor(3.5, 0.37 / 200.0, 200.0, 0.9, 4e-8)
SERVO = Servo(2.3, 0.01, 0.0, 0.01, current_limit=1.0, supply=7.4, duty_limit=0.8, motor=MOTOR)
TIMES = np.linspace(0.0, 2.0, 401)  # s, of the angles
TOLD = np.arange(0.0, 2.0, 0.02)  # s, of the commands
COMMAND = np.where(TOLD < 1.2, 0.8 * np.sin(4.4 * TOLD) + 0.2 * np.sin(9.0 * TOLD), np.sign(np.sin(12.0 * TOLD)))
PLAY, CONTACT, DAMPING = math.radians(2.0), 0.01, 1.5
ROTOR, ABOUT_JOINT = MOTOR.reflected_inertia, LINK.inertia + LINK.mass * LINK.com**2
STIFFNESS = (math.pi / CONTACT) ** 2 / (1.0 / ROTOR + 1.0 / ABOUT_JOINT)
PLACES = [(1.0, 1.0), (1.0, 0.0), (0.0, 0.0)]  # where the recorded angle and the controller's are read


def leg(read: float, controlled: float, **changed: float) -> Leg:
    play = {"play": PLAY, "contact": CONTACT, "damping": DAMPING} | changed
    play |= {"read_beyond": read, "controlled_beyond": controlled}
    return Leg("arm", (Joint("arm", LINK, drive=SERVO, effects={"gear_play": play}),))


def signals() -> ServoSignals:
    ones = np.ones((len(TOLD), 1))
    return ServoSignals(TOLD, COMMAND[:, None], 7.4 * ones, ones, (0,))


def acting(t: float, x: Array, controlled: float, told: float) -> tuple[float, float]:
    """Torques on rotor and link, of state (rotor, link, their rates), without that between them."""
    seen, rate = (x[1], x[3]) if controlled else (x[0], x[2])
    beyond = told - seen
    beyond -= min(max(beyond, -SERVO.dead_band), SERVO.dead_band)
    duty = min(max(SERVO.gain * beyond - SERVO.damping_gain * rate, -0.8), 0.8)
    strength, back_emf, limit = SERVO.numbers[5:8]  # its back-EMF is by the rotor's rate
    driven = min(max(strength * duty * 7.4 - back_emf * x[2], -limit), limit)
    return driven, -LINK.mass * 9.81 * LINK.com * math.sin(x[1])


def elastic(read: float, controlled: float) -> Array:
    """(m,) rad: rotor and link with the effect's flanks, restarted at each command."""
    start = simulate(leg(read, controlled), [0.3], [0.0], np.array([0.0, 1e-9]), signals=signals())
    assert start[0, 0] == pytest.approx(0.3, abs=1e-12)  # what the encoder reads
    weight = -LINK.mass * 9.81 * LINK.com * math.sin(0.3)
    within = -PLAY / 2 + weight / STIFFNESS
    x = np.array([0.3 - within, 0.3, 0.0, 0.0] if read else [0.3, 0.3 + within, 0.0, 0.0])
    found = np.full(len(TIMES), np.nan)
    for (begin, told), (end, _) in pairwise([*zip(TOLD, COMMAND, strict=True), (2.0, 0.0)]):

        def slope(t: float, x: Array, told: float = float(told)) -> list[float]:
            driven, weight = acting(t, x, controlled, told)
            within, closing = x[1] - x[0], x[3] - x[2]
            deep, side = abs(within) - PLAY / 2, math.copysign(1.0, within)
            push = STIFFNESS * deep * max(1.0 + DAMPING * side * closing, 0.0) if deep > 0.0 else 0.0
            return [x[2], x[3], (driven + side * push) / ROTOR, (weight - side * push) / ABOUT_JOINT]

        part = solve_ivp(slope, (begin, end), x, "DOP853", rtol=1e-10, atol=1e-12, max_step=2e-4, dense_output=True)
        first, last = np.searchsorted(TIMES, [begin - 1e-12, end + 1e-12])
        found[first:last] = part.sol(TIMES[first:last])[1 if read else 0]
        x = part.y[:, -1]
    return found


@pytest.mark.parametrize(("read", "controlled"), PLACES)
def test_play_of_a_servo_against_scipy(read: float, controlled: float) -> None:
    assert ROTOR > LEAST_ROTOR * ABOUT_JOINT  # so it is not made heavier
    ours = simulate(leg(read, controlled), [0.3], [0.0], TIMES, signals=signals())[:, 0]
    theirs = elastic(read, controlled)
    assert np.abs(ours - theirs).max() < 2e-5
