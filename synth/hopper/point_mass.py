"""Model ``point_mass``: the study's first, a point mass that one motor pushes up over one link, then flies.

Equations 1 and 2 of Knaup & Aukes as they are printed: T = T_max (1 - omega/omega_max) and F = T cos(theta)/l - m g,
here with both motors on, theta the upper link's angle from level and m the whole mass. The link turns without slip
of its end, y = l sin theta, so omega = y' / (l cos theta). The push ends when the force is gone or the link is at its
stop; after that energy carries: height = y'^2 / (2 g). The equation for F is not the virtual-work one (T / (l cos
theta)): it is the study's, and one reason why its scale is another.
"""

from __future__ import annotations

from math import asin, cos, pi, sin

from synth.hopper.jump import Outcome
from synth.hopper.leg import HopperLeg, Motor

STEP = 2e-5  # s, of Runge and Kutta's fourth order
LONGEST = 2.0  # s


def point_mass_jump(leg: HopperLeg, motor: Motor) -> Outcome:
    """One jump of the point mass; clearance is the ballistic height above the pose at takeoff."""
    mass, length = leg.total_mass(motor), leg.length
    top = length * sin(pi / 2 - leg.extended)
    y, v, t = length * sin(pi / 2 - leg.crouch), 0.0, 0.0
    energy = 0.0
    drop = (motor.stall_current - motor.no_load_current) / motor.no_load_speed

    def acceleration(y: float, v: float) -> float:
        theta = asin(max(-1.0, min(1.0, y / length)))
        omega = v / (length * max(cos(theta), 1e-6))
        torque = 2 * motor.stall_torque * (1.0 - omega / motor.no_load_speed)
        return torque * cos(theta) / (length * mass) - leg.gravity

    first = acceleration(y, v)
    if first <= 0.0:
        return Outcome(0.0, 0.0, 0.0, 0.0, motor.stall_torque, 2 * motor.stall_current, 0.0, 0.0, "too weak to lift")
    start = y
    while t < LONGEST and y < top:
        k1 = acceleration(y, v)
        if k1 <= -leg.gravity:
            break
        k2 = acceleration(y + 0.5 * STEP * v, v + 0.5 * STEP * k1)
        k3 = acceleration(y + 0.5 * STEP * v, v + 0.5 * STEP * k2)
        k4 = acceleration(y + STEP * v, v + STEP * k3)
        omega = v / (length * max(cos(asin(min(1.0, y / length))), 1e-6))
        energy += 2 * motor.voltage * (motor.stall_current - drop * omega) * STEP
        y += STEP * (v + STEP * (k1 + k2 + k3) / 6.0)
        v += STEP * (k1 + 2 * k2 + 2 * k3 + k4) / 6.0
        t += STEP
    height = v * v / (2.0 * leg.gravity)
    return Outcome(height, y - start + height, t, v, motor.stall_torque, 2 * motor.stall_current, energy, 0.0, "")
