"""The motion of a leg whose encoders err, as they read it, from a start that is itself a reading."""

from __future__ import annotations

import numpy as np

from synth.arrays import Array
from synth.comparison.side import ComparedMotion
from synth.estimation.gauss_newton import LocalProblem, gauss_newton
from synth.swing.chain import simulate
from synth.swing.leg_model import Leg
from synth.swing.readings import as_stated, stated_readings

ROUNDS, LEAST_GAIN = 8, 0.05  # as of a diagnosis, which finds the initial states of its trials likewise (``score``)
RESOLVED = 1e-3  # rad, a usual sensor's noise: in which the deviations from a recording are counted
STEP, RATE_STEP = 1e-4, 1e-3  # rad and rad/s, of the derivatives by the initial state


def moved_motion(leg: Leg, start: ComparedMotion, slower: float, *, read: bool) -> Array:
    """(m, n) rad, the leg's motion from a start under its conditions, driven as it was, ``slower`` times as long.

    ``read`` : as the leg's encoders read it. The start is then a reading as well, whose first samples tell little of
    the true rate (a late channel shows what was before the release). The true state is that with which the leg's
    reading follows the recording best, as in a diagnosis; of a start without samples the one that is read there.

    Raises
    ------
    ArithmeticError : the motion diverged.
    """
    n, time = len(start.start), start.time * slower
    state = np.concatenate([start.start, start.rate / slower])

    def moved(state: Array) -> Array:
        return simulate(
            leg, state[:n], state[n:], time, start.conditions, rates=True, known_torque=start.known_torque,
            signals=start.signals,
        )  # fmt: skip

    if not (read and stated_readings(leg)):
        return moved(state)[:, :n]

    def reading(state: Array) -> Array:
        motion = moved(state)
        return as_stated(leg, time, motion[:, :n], motion[:, n:])

    state[:n] += start.start - reading(state)[0]
    counts = np.isfinite(start.rotation)
    counts[:, list(start.conditions.locked)] = False
    free = [j for j in start.free if counts[:, j].any()]
    rows = [*free, *(n + j for j in free)]
    steps = [STEP] * len(free) + [RATE_STEP] * len(free)

    def state_at(own: Array) -> Array:
        made = state.copy()
        made[rows] = own
        return made

    def assess(own: Array) -> LocalProblem[Array]:
        here = reading(state_at(own))
        residual = (here - start.rotation)[counts] / RESOLVED
        moves = np.diag(steps)
        slopes = np.stack([(reading(state_at(own + move)) - here)[counts] for move in moves], axis=1)
        slopes /= RESOLVED * np.array(steps)
        return LocalProblem(here, 0.5 * float(residual @ residual), slopes.T @ slopes, slopes.T @ residual)

    if not rows:
        return reading(state)
    return gauss_newton(assess, state[rows], rounds=ROUNDS, least_gain=LEAST_GAIN)[0]
