"""Angles of joints from readings of joints and of segments: a segment's angle is that of a link itself in space.

Inertial sensors, inclinometers and angles to the horizontal in a video give segments' angles. Written as s (a - z) of
a reading a with its sign s and zero z, a joint's is its rotation q_i; a segment's is tilt + q_1 + ... + q_i.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synth.arrays import Array
from synth.files.import_mapping import JointColumn
from synth.swing.leg_model import Leg


def measured_angles(leg: Leg, columns: Sequence[JointColumn], readings: Array) -> Array:
    """(n, n_joint) rad, in the leg file's convention.

    Parameters
    ----------
    columns : one per joint.
    readings : (n, n_joint) rad as in the file, nan where missing. Whole turns of a segment's are arbitrary, and so are
        those of its joint. A segment below a missing reading has no angle either.
    """
    rotation = np.empty_like(readings)
    above = np.full(len(readings), leg.tilt)
    for j, (joint, column) in enumerate(zip(leg.joints, columns, strict=True)):
        zero, sign = column.convention(joint)
        turned = sign * (readings[:, j] - zero)
        rotation[:, j] = np.angle(np.exp(1j * (turned - above))) if column.segment else turned
        above = turned if column.segment else above + turned
    return leg.to_measured(rotation)
