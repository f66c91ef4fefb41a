"""Recordings that begin before the release, with known truth: a hold, a sudden or a gradual release."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from fit.simulated_legs import robot
from synth.swing.leg_model import Leg
from synth.swing.mechanics import coefficients, mass_matrix, momentum_and_force, outboard_inertia, rest_pose

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Driven:
    """``released`` and ``free_from``: s, the hand's torque begins to fade and is gone."""

    leg: Leg
    time: Array
    angles: Array
    released: float
    free_from: float


def random_leg(generator: np.random.Generator) -> Leg:
    """The robot's links with springs of 0.7-4 Hz and damping ratios of 0.05-2, each joint as if alone."""
    frequency = generator.uniform(0.7, 4.0, 3)
    ratio = np.exp(generator.uniform(np.log(0.05), np.log(2.0), 3))
    inertia = outboard_inertia(robot())
    rate = inertia * (2 * np.pi * frequency) ** 2
    return robot(rate, 2 * ratio * np.sqrt(rate * inertia))


def driven_release(generator: np.random.Generator, fade: float, noise: float, rate: float = 250.0) -> Driven:
    """A leg held 10-35 deg off its rest for 0.3-0.8 s; the holding torque then fades linearly over ``fade`` s.

    ``noise``: deg SD; angles are read by an encoder of 8192 counts a turn.
    """
    leg = random_leg(generator)
    rest = rest_pose(leg)
    start = rest + np.radians(generator.choice([-1, 1], 3) * generator.uniform(10, 35, 3))
    released = generator.uniform(0.3, 0.8)
    time = np.arange(0.0, released + fade + generator.uniform(1.0, 2.0), 1 / rate)
    rotation = np.tile(start, (len(time), 1))
    after = time > released
    rotation[after] = free_motion(leg, start, time[after] - released, fade)
    count = 2 * np.pi / 8192
    read = leg.to_measured(rotation) + np.radians(generator.normal(0, noise, rotation.shape))
    return Driven(leg, time, count * np.round(read / count), released, released + fade)


def free_motion(leg: Leg, start: Array, times: Array, fade: float) -> Array:
    """Rotations (m, n) at ``times`` after the holding torque began to fade."""
    n = len(start)
    found = coefficients(leg)
    spring = np.array([joint.spring.rate for joint in leg.joints if joint.spring])
    damper = np.array([joint.damper.rate for joint in leg.joints if joint.damper])
    unloaded = np.array([j.sign * (j.spring.free_angle - j.zero) for j in leg.joints if j.spring])
    lower = np.tril(np.ones((n, n)))

    def own_torque(rotation: Array, rate: Array) -> Array:
        return np.asarray(-spring * (rotation - unloaded) - damper * rate)

    def force(rotation: Array, rate: Array) -> Array:
        return momentum_and_force(found, rotation[None], rate[None], leg.tilt)[1][0]

    holding = -own_torque(start, np.zeros(n)) - force(start, np.zeros(n))

    def slope(t: float, state: Array) -> Array:
        rotation, rate = state[:n], state[n:]
        hand = holding * (1 - min(t / fade, 1.0)) if fade else 0.0
        phi, omega = leg.tilt + lower @ rotation, lower @ rate
        # d(momentum)/dt with the rates held still: centrifugal terms belong to the force in absolute rotations
        turning = np.sin(phi[:, None] - phi[None, :]) * found.inertia
        spin = -(turning @ omega**2) - found.gravity * np.sin(phi)
        torque = lower.T @ spin + own_torque(rotation, rate) + hand
        return np.r_[rate, np.linalg.solve(mass_matrix(found, rotation, leg.tilt), torque)]

    state = np.r_[start, np.zeros(n)]
    done = solve_ivp(slope, (0.0, times[-1]), state, "LSODA", times, rtol=1e-7, atol=1e-9)
    return np.asarray(done.y[:n].T)
