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

from synth.arrays import Array, finite_median
from synth.fit.recordings import Recording
from synth.swing.damper_curves import torque_at
from synth.swing.leg_model import DamperCurve, Leg, Tip
from synth.swing.mechanics import coefficients, momentum_and_force

# Of a joint's range of speeds, least mean speed of a window in which its law is sought: a joint that sticks is held by
# any torque up to its friction.
SLOW = 0.02


@dataclass(frozen=True)
class LinearEstimate:
    """Spring rates (n,), damper rates (n,), rest angles (n,) and by trial (n_trial, n); nan if undetermined.

    ``per_trial`` : whether each trial has its own rest angle. ``law`` : coefficients (n,) of another law, if asked for.

    A rate may be negative because of noise or a wrong model; the caller decides.
    """

    spring_rate: Array
    damper_rate: Array
    rest: Array
    rest_by_trial: Array
    per_trial: bool = False
    law: Array | None = None


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

    ``curves`` : a known torque-speed curve per joint, or None if the damper's rate is unknown. ``power`` : of the
    speed, of a torque beside spring and damper that opposes motion, 0 for dry friction; None for none.
    """

    def __init__(
        self,
        leg: Leg,
        recordings: Sequence[Recording],
        curves: Sequence[DamperCurve | None] | None = None,
        power: int | None = None,
    ) -> None:
        n = len(leg.joints)
        self.recordings, self.curves, self.power = recordings, list(curves) if curves else [None] * n, power
        self._signals = []  # (m, 3 n) angle, momentum, and known force; beside a law (m, 5 n), and its torque and speed
        for recording, (momentum, force) in zip(recordings, _momenta(leg, recordings), strict=True):
            smoothed = recording.smoothed
            driven = recording.known_force(recording.leg or leg)
            if driven is not None:
                force = force + driven
            for j, curve in enumerate(self.curves):
                if curve is not None:
                    force[:, j] -= torque_at(curve, smoothed.rate[:, j])
            signals = [smoothed.angle, momentum, force]
            if power is not None:
                size = np.abs(smoothed.rate)
                signals += [np.sign(smoothed.rate) * size**power, size]
            self._signals.append(np.concatenate(signals, axis=1))

    def solve(self, window: float = 0.1) -> tuple[LinearEstimate, LinearEstimate]:
        """Estimates with one rest angle for all trials, and with one for each.

        ``window`` : s, the support of the bumps; at least eight samples, at most half a recording.
        """
        products = np.array([self._products(t, window) for t in range(len(self.recordings))])
        return self._estimate(products, per_trial=False), self._estimate(products, per_trial=True)

    def _products(self, t: int, window: float) -> Array:
        """(n, c, c) each joint's scalar products of the columns of k, b, any law, the right side, and that of k * rest.

        They are zero for a joint that is locked in this recording.
        """
        recording, n = self.recordings[t], len(self.curves)
        smoothed = recording.smoothed
        step, count = float(smoothed.time[1] - smoothed.time[0]), len(smoothed.time)
        support = max(8, min(round(window / step), (count - 1) // 2))
        u = np.linspace(-1.0, 1.0, support + 1)
        bump, slope = (1.0 - u * u) ** 3, -6.0 * u * (1.0 - u * u) ** 2 * 2.0 / (support * step)
        every = max(1, support // 8)
        view = np.lib.stride_tricks.sliding_window_view
        windows = view(self._signals[t], support + 1, axis=0)[: count - support : every]
        if smoothed.gap.any():
            windows = windows[~view(smoothed.gap, support + 1)[: count - support : every].any(axis=1)]
        by_bump, by_slope = (np.stack([bump, slope]) * step @ windows.transpose(0, 2, 1)).transpose(1, 2, 0)
        columns = np.empty((n, 4 if self.power is None else 5, len(windows)))
        columns[:, 0], columns[:, 1] = -by_bump[:n], by_slope[:n]
        columns[:, -2] = -by_slope[n : 2 * n] - by_bump[2 * n : 3 * n]
        columns[:, -1] = float(bump.sum()) * step
        if self.power is not None:
            columns[:, 2] = -by_bump[3 * n : 4 * n]
            mean = by_bump[4 * n :] / (float(bump.sum()) * step)
            columns.transpose(0, 2, 1)[mean < SLOW * np.ptp(smoothed.rate, axis=0)[:, None]] = 0.0
        columns[list(recording.conditions.locked)] = 0.0
        return columns @ columns.transpose(0, 2, 1)

    def _estimate(self, products: Array, *, per_trial: bool) -> LinearEstimate:
        """From the products (n_trial, n, c, c)."""
        groups = products if per_trial else products.sum(axis=0, keepdims=True)
        known = np.array([curve is not None for curve in self.curves])
        # The columns of the rests, each zero but in its group, are projected out first (Frisch & Waugh, Econometrica 1,
        # 1933).
        constant = np.where(groups[:, :, -1, -1] > 0.0, groups[:, :, -1, -1], np.inf)
        share = groups[:, :, -1] / constant[:, :, None]
        reduced = (groups - groups[:, :, :, -1, None] * share[:, :, None, :]).sum(axis=0)
        matrix, side = reduced[:, :-2, :-2], reduced[:, :-2, -2]
        matrix[known, 1], matrix[known, :, 1], side[known, 1] = 0.0, 0.0, 0.0
        # A joint that hardly moves leaves nothing but rounding, which may be negative.
        scale = np.sqrt(np.maximum(np.diagonal(matrix, axis1=1, axis2=2), 0.0))
        scale = np.where(scale > 0.0, scale, np.inf)
        inverse = np.linalg.pinv(matrix / (scale[:, :, None] * scale[:, None, :]), rcond=1e-15, hermitian=True)
        found = (inverse @ (side / scale)[:, :, None])[:, :, 0] / scale
        found[(products[:, :, -1, -1] == 0.0).all(axis=0)] = np.nan
        with np.errstate(divide="ignore", invalid="ignore"):
            rests = (share[:, :, -2] - np.einsum("ja,tja->tj", found, share[:, :, :-2])) / found[:, 0]
        rests[np.isinf(constant)] = np.nan
        rest = np.array([finite_median(own) for own in rests.T])
        by_trial = np.broadcast_to(rest, products.shape[:2]).copy()
        if per_trial:
            by_trial = np.where(np.isfinite(rests), rests, by_trial)
        law = None if self.power is None else found[:, 2]
        return LinearEstimate(found[:, 0], found[:, 1], rest, by_trial, per_trial, law)


def _momenta(leg: Leg, recordings: Sequence[Recording]) -> list[tuple[Array, Array]]:
    """Momentum and force (m, n) of each recording, of those under the same conditions in one call."""
    alike: dict[tuple[Tip, float], list[int]] = {}
    for t, recording in enumerate(recordings):
        alike.setdefault((recording.conditions.tip, leg.tilt + recording.conditions.tilt), []).append(t)
    found: dict[int, tuple[Array, Array]] = {}
    for (tip, tilt), members in alike.items():
        motions = [recordings[t].smoothed for t in members]
        angle, rate = (np.concatenate([getattr(m, name) for m in motions]) for name in ("angle", "rate"))
        both = momentum_and_force(coefficients(leg, tip), angle, rate, tilt)
        ends = np.cumsum([len(m.time) for m in motions])[:-1]
        parts = (np.split(values, ends) for values in both)
        found |= dict(zip(members, zip(*parts, strict=True), strict=True))
    return [found[t] for t in range(len(recordings))]
