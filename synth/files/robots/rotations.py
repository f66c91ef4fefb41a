"""Rotation matrices (3, 3) as robots' files write them."""

from __future__ import annotations

import numpy as np

from synth.arrays import Array


def by_fixed_axes(angles: Array) -> Array:
    """Roll, pitch and yaw, rad, about the fixed axes x, y and z in turn: Rz(yaw) Ry(pitch) Rx(roll)."""
    (sr, cr), (sp, cp), (sy, cy) = [(np.sin(angle), np.cos(angle)) for angle in angles]
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def by_quaternion(quaternion: Array) -> Array:
    """X, y, z, w of any length but 0."""
    *way, real = quaternion / np.linalg.norm(quaternion)
    across = crossing(np.array(way))
    return np.asarray(np.eye(3) + 2.0 * real * across + 2.0 * across @ across)


def about_axis(axis: Array, angle: float) -> Array:
    """By an angle in rad about a unit vector (Rodrigues)."""
    across = crossing(axis)
    return np.asarray(np.eye(3) + np.sin(angle) * across + (1.0 - np.cos(angle)) * across @ across)


def crossing(vector: Array) -> Array:
    """(3, 3) that makes the cross product of the vector with another."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
