"""A leg's motion from the start of a recording: from the state there with which it follows the recording best."""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares

from synth.arrays import Array
from synth.comparison.side import ComparedMotion
from synth.swing.chain import simulate
from synth.swing.leg_model import Leg
from synth.swing.readings import as_stated, stated_readings

MOST_STEPS = 12  # of the search for the state; it ends after five to nine on simulated releases
RESOLVED = 1e-3  # rad, a usual sensor's noise: in which the deviations from a recording are counted
STEP, RATE_STEP = 1e-4, 1e-3  # rad and rad/s, of the derivatives by the initial state
WITHIN = 2.0  # standard deviations of the first samples' start, in which a leg's own start may lie; a choice


def moved_motion(leg: Leg, start: ComparedMotion, slower: float, *, read: bool) -> Array:
    """(m, n) rad, the leg's motion from a start under its conditions, driven as it was, ``slower`` times as long.

    The first samples of a recording tell its start within some degrees a second, by which a leg that is exactly the
    recorded one would miss it by several times the noise. Each leg starts where it follows the recording best, within
    ``WITHIN`` deviations of what the first samples show, so nearly from the same start.

    ``read`` : as the leg's encoders read it. The start is then a reading as well, whose first samples tell little of
    the true rate (a late channel shows what was before the release): it is not bounded by them. Of a start without
    samples the true state is the one that is read there.

    Raises
    ------
    ArithmeticError : the motion diverged.
    """
    n, time = len(start.start), start.time * slower
    state = np.concatenate([start.start, start.rate / slower])
    erring = read and bool(stated_readings(leg))

    def reading(state: Array) -> Array:
        motion = simulate(
            leg, state[:n], state[n:], time, start.conditions, rates=True, known_torque=start.known_torque,
            signals=start.signals,
        )  # fmt: skip
        return as_stated(leg, time, motion[:, :n], motion[:, n:]) if erring else motion[:, :n]

    if erring:
        state[:n] += start.start - reading(state)[0]
    counts = np.isfinite(start.rotation)
    counts[:, list(start.conditions.locked)] = False
    free = [j for j in start.free if counts[:, j].any()]
    rows = [*free, *(n + j for j in free)]
    if not rows or not (erring or start.deviation is not None):
        return reading(state)
    steps = np.array([STEP] * len(free) + [RATE_STEP] * len(free))
    reach = np.full(len(rows), np.inf)
    if not erring and start.deviation is not None:
        reach = WITHIN * np.concatenate([start.deviation[0], start.deviation[1] / slower])[rows] + steps

    def at(own: Array) -> Array:
        made = state.copy()
        made[rows] = own
        return reading(made)

    def residuals(own: Array) -> Array:
        return np.asarray((at(own) - start.rotation)[counts] / RESOLVED)

    def slopes(own: Array) -> Array:
        here = at(own)
        moved = [(at(own + move) - here)[counts] for move in np.diag(steps)]
        return np.stack(moved, axis=1) / (RESOLVED * steps)

    middle = state[rows]
    bounds = (middle - reach, middle + reach)
    return at(least_squares(residuals, middle, slopes, bounds, x_scale="jac", max_nfev=MOST_STEPS).x)
