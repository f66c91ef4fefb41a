"""The weak form: the equation of motion times test functions, integrated by parts, linear in k, k*rest and b.

For the momentum S outboard of joint j, ``dS/dt = R - k (q - rest) - b dq/dt`` (see ``mechanics.momentum_and_force``).
Times a bump phi that is zero with its slope at both ends of a window, and integrated by parts, only angles and first
rates appear: one linear least squares a joint, no simulation, no local minimum. The idea is Shinbrot's (1957, "method
of moment functions"); bumps as in Messenger & Bortz, J. Comp. Phys. 443 (2021) 110525.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synth.fit.recordings import Recording
from synth.model.curves import torque_at
from synth.model.leg import Array, DamperCurve, Leg
from synth.model.mechanics import coefficients, momentum_and_force


@dataclass(frozen=True)
class LinearEstimate:
    """Spring rates (n,), damper rates (n,), rests (n,) and rest by trial (n_trial, n); nan where no trial tells.

    A rate may come out negative: noise, or a model that does not hold. The caller decides.
    """

    spring_rate: Array
    damper_rate: Array
    rest: Array
    rest_by_trial: Array


def weak_form(
    leg: Leg,
    recordings: Sequence[Recording],
    curves: Sequence[DamperCurve | None] | None = None,
    *,
    window: float = 0.1,
    per_trial_rest: bool = False,
) -> LinearEstimate:
    """Solve for spring rate, damper rate and rest of every joint.

    Parameters
    ----------
    curves : a known torque-speed curve a joint, or None where the damper's rate is sought.
    window : s, the bumps' support; at least eight samples, at most half a recording.
    per_trial_rest : a rest angle for each trial instead of one for all.
    """
    n = len(leg.joints)
    rate, damping = np.full(n, np.nan), np.full(n, np.nan)
    rest, by_trial = np.full(n, np.nan), np.full((len(recordings), n), np.nan)
    for j in range(n):
        curve = curves[j] if curves else None
        rows, sides, owner = [], [], []
        for t, recording in enumerate(recordings):
            if j in recording.free:
                row, side = _equations(leg, recording, j, curve, window)
                rows.append(row)
                sides.append(side)
                owner.append(np.full(len(side), t))
        if not rows or not sum(len(side) for side in sides):
            continue
        row, side, trial = np.concatenate(rows), np.concatenate(sides), np.concatenate(owner)
        trials = np.unique(trial)
        intercept = (trial[:, None] == trials) * row[:, 1:2] if per_trial_rest else row[:, 1:2]
        columns = [row[:, 0:1], intercept] + ([] if curve else [row[:, 2:3]])
        design = np.concatenate(columns, axis=1)
        solution = np.linalg.lstsq(design, side, rcond=None)[0]
        rate[j] = solution[0]
        damping[j] = 0.0 if curve else solution[-1]
        found = solution[1 : 1 + intercept.shape[1]] / solution[0]
        rest[j] = np.median(found)
        by_trial[:, j] = rest[j]
        if per_trial_rest:
            by_trial[trials, j] = found
    return LinearEstimate(rate, damping, rest, by_trial)


def _equations(
    leg: Leg, recording: Recording, joint: int, curve: DamperCurve | None, window: float
) -> tuple[Array, Array]:
    """Rows (n_window, 3) for (k, k*rest, b) and right sides (n_window,) of one recording and joint."""
    smoothed = recording.smoothed
    step = float(smoothed.time[1] - smoothed.time[0])
    support = max(8, min(round(window / step), (len(smoothed.time) - 1) // 2))
    u = np.linspace(-1.0, 1.0, support + 1)
    bump = (1.0 - u * u) ** 3
    slope = -6.0 * u * (1.0 - u * u) ** 2 * 2.0 / (support * step)
    tilt = leg.tilt + recording.conditions.tilt
    found = coefficients(leg, recording.conditions.tip_mass)
    momentum, force = momentum_and_force(found, smoothed.angle, smoothed.rate, tilt)
    known = force[:, joint]
    if recording.known_torque is not None:
        times, torques = recording.known_torque
        known = known + np.interp(smoothed.time, times, torques[:, joint])
    if curve is not None:
        known = known - torque_at(curve, smoothed.rate[:, joint])
    starts = np.arange(0, len(smoothed.time) - support, max(1, support // 8))
    view = np.lib.stride_tricks.sliding_window_view
    starts = starts[~view(smoothed.gap, support + 1)[starts].any(axis=1)]
    angle = view(smoothed.angle[:, joint], support + 1)[starts]
    rows = np.stack([-(angle @ bump), np.full(len(starts), bump.sum()), angle @ slope], axis=1) * step
    side = -(view(momentum[:, joint], support + 1)[starts] @ slope) * step
    side -= (view(known, support + 1)[starts] @ bump) * step
    return rows, side
