"""The integral of a servo's error when a motion begins: that of a servo which has held its joint there until now."""

from __future__ import annotations

import numpy as np

from synth.arrays import Array
from synth.drives.servo import INTEGRAL_LIMIT, Servo, holding_duty
from synth.swing.known_torque import Linear
from synth.swing.lane_layout import INTEGRAL, SERVO, Layout
from synth.swing.leg_model import Leg, Tip
from synth.swing.mechanics import coefficients, static_torque

STRENGTH, SAG = SERVO.index("servo_strength"), SERVO.index("servo_sag")


def started_integrals(layout: Layout, workspace: Array, known: Linear, start: float) -> None:
    """Write the integrals of all servos at the state in the ``workspace`` (n_row, n_lane) to its rows.

    At rest an integral has taken over the whole load, so it begins with the duty whose torque holds its joint against
    gravity and spring at the first angle, plus what the rows hold so far, within its limit. ``known`` : signals in
    columns of n, of which the third is the supply, at ``start`` s. Effects do not count: what friction, or a source
    that several servos share, adds to the load is not known to the controller's log either.
    """
    rows = {
        name: workspace[layout.rows(name)]
        for name in (
            "rotation",
            "spring_rate",
            "rest",
            "gravity",
            "gravity_across",
            "servo_strength",
            "servo_sag",
            "servo_integral_gain",
        )
    }
    direction = workspace[layout.row("tilt")] + np.cumsum(rows["rotation"], axis=0)
    moment = rows["gravity"] * np.sin(direction) + rows["gravity_across"] * np.cos(direction)
    load = np.cumsum(moment[::-1], axis=0)[::-1] + rows["spring_rate"] * (rows["rotation"] - rows["rest"])
    times, values, _ = known
    n = layout.n
    supply = np.array([np.interp(start, times, values[:, 2 * n + j]) for j in range(n)])[:, None]
    limit = workspace[layout.rows("servo_integral_limit")]
    acts = rows["servo_integral_gain"] != 0.0
    found = holding_duty(np.where(acts, load, 0.0), rows["servo_strength"] * supply, rows["servo_sag"])
    integral = workspace[layout.rows(f"{INTEGRAL} memory")]
    np.clip(found + integral, -limit, limit, out=integral)


def usual_departures(leg: Leg) -> dict[int, float]:
    """Joint -> duty, or N m without a motor, by which its servo's integral may differ from that of ``held_integrals``.

    In a log that begins while the leg moves, or with friction that carries some of the load. The gains bound it
    loosely: what an error of a radian, held for a second, would give, and no more than the integral's limit.
    """
    servos = {j: joint.drive for j, joint in enumerate(leg.joints) if isinstance(joint.drive, Servo)}
    return {
        j: min(servo.numbers[INTEGRAL_LIMIT], servo.gain + servo.integral_gain)
        for j, servo in servos.items()
        if servo.integral_gain
    }


def held_integrals(leg: Leg, tip: Tip, tilt: float, angle: Array, supply: Array) -> Array:
    """(n,) the same of a leg's servos that hold it at ``angle`` (n,) rad on q; 0 without an integral.

    ``tilt`` rad of the trial's base beside the leg's own; ``supply`` (n,) V, 1 of a servo without a motor.
    """
    found = np.zeros(len(leg.joints))
    acting = [j for j, each in enumerate(leg.joints) if isinstance(each.drive, Servo) and each.drive.integral_gain]
    if not acting:
        return found
    load = static_torque(coefficients(leg, tip), angle, leg.tilt + tilt) + leg.spring_rate * (angle - leg.rest)
    for j in acting:
        drive = leg.joints[j].drive
        assert isinstance(drive, Servo)
        numbers = np.array(drive.without_lag)
        duty = holding_duty(load[[j]], numbers[STRENGTH] * supply[[j]], numbers[SAG])
        found[j] = np.clip(duty[0], -numbers[INTEGRAL_LIMIT], numbers[INTEGRAL_LIMIT])
    return found
