"""A joint's rotation as its encoder reads it: late, shifted or scaled, as a leg file states or a diagnosis supposes."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.swing.effects.definition import Effect
from synth.swing.leg_model import Joint, Leg
from synth.swing.stated_effects import COUNTS, StatedEffect, stated_effects


class ReadingError(Protocol):
    """An error of the encoder at a joint."""

    @property
    def effect(self) -> Effect:
        """Of the way "reading"."""

    @property
    def joint(self) -> int:
        """Index of its joint."""


def joint_as_read(
    errors: Sequence[tuple[ReadingError, Array, NDArray[np.intp]]],
    joint: int,
    hinge: Joint,
    time: Array,
    rotation: Array,
    rate: Array,
) -> Array:
    """One joint's rotation (m, n_lane) at ``time`` (m,) s as read by its encoder.

    ``errors`` : of all joints in their order of action, each with its values (n_parameter, n) in these n lanes.
    """
    reading = rotation.copy()
    for erring, values, lanes in errors:
        if erring.joint == joint:
            read = erring.effect.function()
            reading[:, lanes] = read(time, reading[:, lanes], rate[:, lanes], hinge.sign, hinge.zero, *values)
    return reading


def control_readings(
    controlled: Array,
    leg: Leg,
    errors: Sequence[tuple[ReadingError, Sequence[Array] | Array, NDArray[np.intp] | slice]],
) -> None:
    """Let servos control what their encoders read, where an error says that they do.

    ``controlled`` (3, n, n_lane), see ``LegLanes``; it is changed in place. ``errors`` : in their order of action, each
    with its values (n_parameter, n) in these n lanes.
    """
    for erring, values, lanes in errors:
        if erring.effect.controls:
            wide = np.zeros((len(values), controlled.shape[2]))
            wide[:, lanes] = values
            hinge = leg.joints[erring.joint]
            erring.effect.function(erring.effect.controls)(controlled, erring.joint, hinge.sign, hinge.zero, *wide)


def stated_readings(leg: Leg) -> list[StatedEffect]:
    """The errors of encoders that a leg states and that a predicted motion is read with: all but coarse counts."""
    return [each for each in stated_effects(leg, "reading") if each.effect.name != COUNTS]


def as_stated(leg: Leg, time: Array, rotation: Array, rate: Array) -> Array:
    """Rotations (m, n) rad of a motion as the leg's encoders read it; ``rate`` (m, n) rad/s."""
    lane = np.zeros(1, dtype=np.intp)
    errors = [(each, np.array(each.values)[:, None], lane) for each in stated_readings(leg)]
    columns = [
        joint_as_read(errors, j, hinge, time, rotation[:, j : j + 1], rate[:, j : j + 1])
        for j, hinge in enumerate(leg.joints)
    ]
    return np.concatenate(columns, axis=1)
