"""Model ``point_mass``: the study's first, a point mass pushed up by one motor over one link, then in free flight.

Equations 1 and 2 of Knaup & Aukes as printed: T = T_max (1 - omega/omega_max) and F = T cos(theta)/l - m g,
here with both motors on, theta the angle of the upper link from level and m the total mass. The end of the link does
not slip, y = l sin theta, so omega = y' / (l cos theta). The push ends when the force is zero or the link is at its
stop; then energy is conserved: height = y'^2 / (2 g). The study's equation for F differs from that of virtual work,
T / (l cos theta), which is one reason for the different scale of its heights.
"""

from __future__ import annotations

import numpy as np

from synth.arrays import Array
from synth.jump.hopper_leg import HopperLeg, Motor
from synth.jump.outcomes import LANDED_AGAIN, N_OUTCOME, OUTCOMES, TOO_WEAK

STEP = 2e-4  # s, of Runge and Kutta's fourth order
LONGEST = 0.6  # s, longer than any push that lifts off


def point_mass_outcomes(leg: HopperLeg, motor: Motor, length: Array) -> Array:
    """Outcomes (n_outcome, n), rows as ``outcomes.OUTCOMES``, for links of these lengths (n,) m.

    Clearance is the ballistic height above the pose at takeoff.
    """
    links = 2 * leg.laminate.mass_per_length * length * (1.0 + leg.lower_ratio)
    mass = leg.structure_mass + 2 * motor.mass + leg.foot_mass + links
    top = length * np.cos(leg.extended)
    y, v = length * np.cos(leg.crouch_angle(length)), np.zeros_like(length)
    time, energy = np.zeros_like(length), np.zeros_like(length)
    start = y.copy()

    def speed(y: Array, v: Array) -> Array:
        return np.asarray(v / np.sqrt(np.maximum(length**2 - y**2, 1e-12)))

    def acceleration(y: Array, v: Array) -> Array:
        cosine = np.sqrt(np.maximum(0.0, 1.0 - (y / length) ** 2))
        torque = 2 * motor.stall_torque * (1.0 - speed(y, v) / motor.no_load_speed)
        return np.asarray(torque * cosine / (length * mass) - leg.gravity)

    pushing = acceleration(y, v) > 0.0
    lifts = pushing.copy()
    drop = (motor.stall_current - motor.no_load_current) / motor.no_load_speed
    for _ in range(int(LONGEST / STEP)):
        k1 = acceleration(y, v)
        pushing &= (y < top) & (k1 > -leg.gravity)
        if not pushing.any():
            break
        k2 = acceleration(y + 0.5 * STEP * v, v + 0.5 * STEP * k1)
        k3 = acceleration(y + 0.5 * STEP * (v + 0.5 * STEP * k1), v + 0.5 * STEP * k2)
        k4 = acceleration(y + STEP * (v + 0.5 * STEP * k2), v + STEP * k3)
        on = pushing * STEP
        energy += on * 2 * motor.voltage * (motor.stall_current - drop * speed(y, v))
        y = y + on * (v + STEP * (k1 + k2 + k3) / 6.0)
        v = v + on * (k1 + 2 * k2 + 2 * k3 + k4) / 6.0
        time += on
    found = np.zeros((N_OUTCOME, len(length)))
    values = {
        "status": np.where(lifts & (v > 0.0), LANDED_AGAIN, TOO_WEAK),
        "clearance": v**2 / (2.0 * leg.gravity),
        "takeoff_time": time,
        "takeoff_speed": v,
        "apex": y - start + v**2 / (2.0 * leg.gravity),
        "peak_gear_torque": np.full_like(length, motor.stall_torque),
        "peak_current": np.full_like(length, 2 * motor.stall_current),
        "energy": energy,
    }
    for name, value in values.items():
        found[OUTCOMES.index(name)] = value
    return found
