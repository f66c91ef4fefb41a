"""The least rate of a spring that a drawn joint can wind up from its free angle.

A weak spring holds the leg's weight only if it is wound far: its free angle lies far from the joint's travel, by the
torque over the rate. It is put into the joint unloaded. Its upper arm is then turned with the seat plate to the travel,
through the notch in the pocket's wall and beside the lower link's stem, which stand in its way.
"""

from __future__ import annotations

from math import degrees, radians

import numpy as np

from synth.design.response import WantedResponse
from synth.design.stop_places import ASKED_STOP, STOP, moved_range
from synth.swing.leg_model import Leg
from synth.swing.mechanics import coefficients, static_torque

# deg, from the free angle to the farther stop. Of 79 random joints 75 leave the seat 141 to 210 between both sides of
# the stem (``cad.checked_layout``), less the seat's own travel; the notch leaves 205 and more.
WAY = 140.0


def least_rates(leg: Leg, wanted: WantedResponse) -> list[float]:
    """Each joint's least rate (N m/rad), with the springs that hold ``leg`` in the wanted rest pose.

    Between stops that are farther apart than ``WAY`` the free angle may lie anywhere.
    """
    pose = wanted.rest_pose
    torques = static_torque(coefficients(leg), pose, leg.tilt)
    angles = np.degrees(leg.to_measured(np.concatenate([*wanted.motions, pose[np.newaxis]])))
    found = []
    for joint, each, torque in zip(leg.joints, angles.T, torques, strict=True):
        beyond, travel = STOP, moved_range(each.min(), each.max())
        if joint.range is not None:
            beyond, travel = ASKED_STOP, (degrees(joint.range[0]), degrees(joint.range[1]))
        low, high = travel[0] - beyond, travel[1] + beyond
        rest, room = min(max(each[-1], travel[0]), travel[1]), max(WAY, high - low)
        # The free angle lies beyond the rest angle, to the side to which the spring pulls.
        way = low + room - rest if joint.sign * torque > 0.0 else rest - (high - room)
        found.append(float(abs(torque) / radians(way)))
    return found
