"""Effects that a leg file states and that act in no trial: their drive's torque is in none."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synth.drives.servo import TorqueDrive
from synth.fit.recordings import Recording
from synth.swing.drive_needs import drive_needs, lacking, needs_by_file
from synth.swing.effects import effect_named
from synth.swing.leg_model import Leg
from synth.swing.stated_effects import Place


def torque_is_known(made: Sequence[Recording], joint: int) -> bool:
    """Whether a known torque acts on a joint in some trial in which it is free."""
    known = [recording.known_torque for recording in made if joint in recording.free]
    return any(torque is not None and bool(np.any(torque[1][:, joint] != 0.0)) for torque in known)


def idle_effects(leg: Leg, made: Sequence[Recording]) -> dict[Place, str]:
    """The stated effects of joints that act in none of the leg's trials ``made``, and what they lack, in words.

    An effect without a servo or motor in the file is refused when that is read, so it is a torque that they lack.
    """
    drives = [joint.drive for joint in leg.joints]
    found = dict[Place, str]()
    for j, joint in enumerate(leg.joints if made else ()):
        by_current = isinstance(joint.drive, TorqueDrive) and joint.drive.motor is not None
        there = needs_by_file(drives, j)
        if torque_is_known(made, j):
            there |= {"torque", "recorded current"} if by_current else {"torque"}
        column = f"{joint.name} current [A]" if by_current else f"{joint.name} torque [N*m]"
        for name, given in joint.effects.items():
            if missing := lacking(drive_needs(effect_named(name), given), there):
                found[name, j] = f'it needs {missing}; no trial has a column "{column}" beyond 0 with the joint free'
    return found
