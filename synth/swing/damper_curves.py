"""Torque-speed curves in the form of the compiled chain: a sum of clamped speeds.

An odd curve, linear between points, is ``sum_m c_m * clamp(speed, -s_m, s_m)``: branch-free, and exact.

Beyond its last point a curve that rises there goes on along its last slope, and one that falls there keeps its last
torque: on along a falling slope it would drive the joint. Of a law ``w^0.47`` with points at half of and at the last
speed, the slope is 12 % above the law at twice the last speed; the last torque kept would be 28 % below it.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from synth.arrays import Array
from synth.swing.lane_layout import CURVE_POINTS
from synth.swing.leg_model import DamperCurve

UNBOUNDED = 1e9  # rad/s, beyond any joint's speed
REMEMBERED = 1024  # curves, each two rows of a dozen numbers; choosing parts uses the same few hundred repeatedly


def torque_at(curve: DamperCurve, speed: Array) -> Array:
    """Resisting torque (N m) at ``speed`` (rad/s, any shape): odd, linear between points, never below zero."""
    clamp_speed, clamp_slope = clamps(curve)
    return np.asarray(np.sum(clamp_slope * np.clip(speed[..., None], -clamp_speed, clamp_speed), axis=-1))


def clamps(curve: DamperCurve) -> tuple[Array, Array]:
    """Clamp speeds (rad/s) and slopes (N m s/rad), each (n_point,), whose clamped sum is the curve."""
    speed, torque = np.array(curve.speed), np.array(curve.torque)
    slope = np.diff(torque, prepend=0.0) / np.diff(speed, prepend=0.0)
    end = speed[-1] if slope[-1] < 0.0 else UNBOUNDED
    return np.append(speed[:-1], end), slope - np.append(slope[1:], 0.0)


def with_rate(curve: DamperCurve, rate: float) -> DamperCurve:
    """The curve of this damper in parallel with a linear damper of ``rate`` N m s/rad."""
    if curve.falls_at_end:  # held beyond the last point: a further one carries the rate on
        curve = DamperCurve((*curve.speed, 2.0 * curve.speed[-1]), (*curve.torque, curve.torque[-1]))
    return DamperCurve(curve.speed, tuple(t + rate * s for s, t in zip(curve.speed, curve.torque, strict=True)))


@lru_cache(maxsize=REMEMBERED)
def compiled_rows(curve: DamperCurve) -> tuple[Array, Array]:
    """Clamp speeds and slopes padded to the compiled chain's ``CURVE_POINTS``; a longer curve is thinned first.

    The arrays are cached, so callers must not modify them.
    """
    speed, slope = clamps(thin(curve))
    pad = CURVE_POINTS - len(speed)
    rows = np.pad(speed, (0, pad), constant_values=UNBOUNDED), np.pad(slope, (0, pad))
    for row in rows:
        row.setflags(write=False)
    return rows


def thin(curve: DamperCurve, points: int = CURVE_POINTS) -> DamperCurve:
    """The curve with at most ``points`` of its points; points closest to the chord of their neighbours go first.

    Line simplification after Visvalingam & Whyatt (Cartographic Journal 30, 1993), with the torque's distance from the
    chord instead of the area, because the torque matters. ``thinning_error`` gives the error.
    """
    speed, torque = [0.0, *curve.speed], [0.0, *curve.torque]
    while len(speed) - 1 > points:
        distance = [
            abs(torque[i] - np.interp(speed[i], [speed[i - 1], speed[i + 1]], [torque[i - 1], torque[i + 1]]))
            for i in range(1, len(speed) - 1)
        ]
        drop = int(np.argmin(distance)) + 1
        del speed[drop], torque[drop]
    return DamperCurve(tuple(speed[1:]), tuple(torque[1:]))


def thinning_error(curve: DamperCurve) -> float:
    """Largest torque error of the thinned curve at the points of the full one, as a share of its largest torque."""
    full = np.array(curve.torque)
    return float(np.abs(torque_at(thin(curve), np.array(curve.speed)) - full).max() / np.abs(full).max())
