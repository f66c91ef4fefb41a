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

from synth.arrays import Array
from synth.fit.recordings import Recording
from synth.swing.damper_curves import torque_at
from synth.swing.leg_model import DamperCurve, Leg
from synth.swing.mechanics import coefficients, momentum_and_force


@dataclass(frozen=True)
class LinearEstimate:
    """Spring rates (n,), damper rates (n,), rest angles (n,) and by trial (n_trial, n); nan if undetermined.

    ``per_trial`` : whether each trial has its own rest angle.

    A rate may be negative because of noise or a wrong model; the caller decides.
    """

    spring_rate: Array
    damper_rate: Array
    rest: Array
    rest_by_trial: Array
    per_trial: bool = False


def weak_form(
    leg: Leg,
    recordings: Sequence[Recording],
    curves: Sequence[DamperCurve | None] | None = None,
    *,
    window: float = 0.1,
    per_trial_rest: bool = False,
) -> LinearEstimate:
    """Solve for spring rate, damper rate and rest angle of every joint; see ``WeakForm``."""
    return WeakForm(leg, recordings, curves).solve(window)[int(per_trial_rest)]


class WeakForm:
    """The data of the weak form from recordings, prepared once for all windows.

    ``curves`` : a known torque-speed curve per joint, or None if the damper's rate is unknown.
    """

    def __init__(
        self, leg: Leg, recordings: Sequence[Recording], curves: Sequence[DamperCurve | None] | None = None
    ) -> None:
        n = len(leg.joints)
        self.recordings, self.curves = recordings, list(curves) if curves else [None] * n
        self._signals = []  # (m, 3 n) angle, momentum, and known force
        for recording in recordings:
            smoothed = recording.smoothed
            tilt = leg.tilt + recording.conditions.tilt
            found = coefficients(leg, recording.conditions.tip)
            momentum, force = momentum_and_force(found, smoothed.angle, smoothed.rate, tilt)
            driven = recording.known_force(recording.leg or leg)
            if driven is not None:
                force = force + driven
            for j, curve in enumerate(self.curves):
                if curve is not None:
                    force[:, j] -= torque_at(curve, smoothed.rate[:, j])
            self._signals.append(np.concatenate([smoothed.angle, momentum, force], axis=1))

    def solve(self, window: float = 0.1) -> tuple[LinearEstimate, LinearEstimate]:
        """Estimates with one rest angle for all trials, and with one for each.

        ``window`` : s, the support of the bumps; at least eight samples, at most half a recording.
        """
        equations = [self._equations(t, window) for t in range(len(self.recordings))]
        return self._estimate(equations, per_trial=False), self._estimate(equations, per_trial=True)

    def _equations(self, t: int, window: float) -> _Equations:
        """One recording's, all joints at once."""
        smoothed, n = self.recordings[t].smoothed, len(self.curves)
        step, count = float(smoothed.time[1] - smoothed.time[0]), len(smoothed.time)
        support = max(8, min(round(window / step), (count - 1) // 2))
        u = np.linspace(-1.0, 1.0, support + 1)
        bump, slope = (1.0 - u * u) ** 3, -6.0 * u * (1.0 - u * u) ** 2 * 2.0 / (support * step)
        every = max(1, support // 8)
        view = np.lib.stride_tricks.sliding_window_view
        windows = view(self._signals[t], support + 1, axis=0)[: count - support : every]
        if smoothed.gap.any():
            windows = windows[~view(smoothed.gap, support + 1)[: count - support : every].any(axis=1)]
        found = np.ascontiguousarray(windows) @ (np.stack([bump, slope], axis=1) * step)
        angle, momentum, force = found[:, :n], found[:, n : 2 * n], found[:, 2 * n :]
        columns = np.stack([-angle[:, :, 0], angle[:, :, 1]])
        return _Equations(columns, -momentum[:, :, 1] - force[:, :, 0], float(bump.sum()) * step)

    def _estimate(self, equations: Sequence[_Equations], *, per_trial: bool) -> LinearEstimate:
        n, count = len(self.curves), len(equations)
        rate, damping = np.full(n, np.nan), np.full(n, np.nan)
        rest, by_trial = np.full(n, np.nan), np.full((count, n), np.nan)
        for j, curve in enumerate(self.curves):
            own = [t for t in range(count) if j in self.recordings[t].free and len(equations[t].side)]
            if own:
                groups = [[t] for t in own] if per_trial else [own]
                found, rests = _joint(
                    [_pooled([equations[t] for t in group], j) for group in groups], curve is not None
                )
                rate[j], damping[j] = found[0], 0.0 if curve else found[1]
                rest[j] = by_trial[:, j] = np.median(rests)
                if per_trial:
                    by_trial[own, j] = rests
        return LinearEstimate(rate, damping, rest, by_trial, per_trial)


@dataclass(frozen=True)
class _Equations:
    """Columns of k and b (2, n_window, n), right side (n_window, n), and the column of k * rest."""

    columns: Array
    side: Array
    constant: float


def _pooled(equations: Sequence[_Equations], j: int) -> tuple[Array, Array, Array]:
    """Columns (2, N), side (N,) and the rest angle's column (N,) of one joint in trials that share it."""
    columns = np.concatenate([e.columns[:, :, j] for e in equations], axis=1)
    side = np.concatenate([e.side[:, j] for e in equations])
    return columns, side, np.concatenate([np.full(len(e.side), e.constant) for e in equations])


def _joint(groups: Sequence[tuple[Array, Array, Array]], damper_known: bool) -> tuple[Array, Array]:
    """Spring and damper rate, and the rest angle of each group.

    The rests' columns, each zero but in its group, are projected out first (Frisch & Waugh, Econometrica 1, 1933).
    """
    used = 1 if damper_known else 2
    designs, sides = [], []
    for columns, side, constant in groups:
        unit = constant / np.sqrt(constant @ constant)
        designs.append(columns[:used] - np.outer(columns[:used] @ unit, unit))
        sides.append(side - (side @ unit) * unit)
    design, right = np.concatenate(designs, axis=1), np.concatenate(sides)
    scale = np.sqrt(np.sum(design**2, axis=1)) + 1e-300
    design /= scale[:, None]
    found = np.linalg.lstsq(design @ design.T, design @ right, rcond=None)[0] / scale
    rests = [
        constant @ (side - found @ columns[:used]) / (constant @ constant) / found[0]
        for columns, side, constant in groups
    ]
    return found, np.array(rests)
