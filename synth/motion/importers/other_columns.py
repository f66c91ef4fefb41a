"""Columns of a foreign file beside angles and inputs: velocities, and what an import leaves out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synth.arrays import Array
from synth.errors import UserError
from synth.files.import_mapping import JointColumn, Mapping
from synth.motion.importers.channel_clock import CLOCKS, FRAMES
from synth.motion.importers.drive_inputs import DriveInput, channel_by_name
from synth.motion.importers.foreign_data import Channels, other_side, same_name
from synth.motion.importers.raw_counts import speed_scale
from synth.motion.smoothing import lost_samples, smooth
from synth.motion.velocity import unlike
from synth.swing.leg_model import Joint, Leg

SHOWN = 12  # names of unused columns in a note; a motion file has some forty coordinates


def velocities(
    source: Channels, leg: Leg, mapping: Mapping, time: Array, angles: Array, notes: list[str]
) -> tuple[DriveInput, ...]:
    """The joints' velocities that are the slopes of their angles; a note states each, and why one is left out.

    Parameters
    ----------
    time : (n,) s; angles : (n, n_joint) rad, measured, cleaned.
    """
    found = []
    for index, joint in enumerate(leg.joints):
        column = mapping.joints.get(joint.name) or JointColumn(joint.name)
        place = channel_by_name(source, joint, column, ("velocity",))
        if place is None or place[0] is not source:
            continue
        k, what = place[1], f"{joint.name} velocity"
        if column.segment:
            notes.append(f"{what}: {source.names[k]} is left out: {column.column} is a segment's angle")
            continue
        try:
            value = _velocity(source, k, joint, column)
        except UserError as error:
            notes.append(f"{what}: {source.names[k]} is left out: {error.problems[0].text}")
            continue
        fault = _fault(leg, time, angles, value, index)
        if fault:
            notes.append(f"{what}: {source.names[k]} is left out: it {fault}")
            continue
        notes.append(f"{what}: from {source.names[k]}")
        found.append(DriveInput(f"{what} [deg/s]", time, np.degrees(value), source.names[k]))
    return tuple(found)


def _velocity(source: Channels, k: int, joint: Joint, column: JointColumn) -> Array:
    """(n,) rad/s, in the measured angle's sense."""
    scale = speed_scale(source, k, column)
    if scale is None:
        raise UserError("the file does not state its unit")
    sense = joint.sign * column.of_joint(joint)[1]
    return np.asarray(sense * source.values[:, k] * scale)


def _fault(leg: Leg, time: Array, angles: Array, velocity: Array, index: int) -> str:
    """Why a velocity is not the slope of its joint's angle; empty if it is, or there is too little to tell."""
    try:
        smoothed = smooth(time, angles, lost_samples(time, leg.to_rotation(angles)))
    except ValueError:
        return ""
    return unlike(smoothed, time, velocity, index)


def unused_columns(
    source: Channels, leg: Leg, mapping: Mapping, inputs: Sequence[DriveInput], notes: Sequence[str]
) -> list[str]:
    """A note that names the columns of numbers of which nothing is taken and no other note tells; none: no note."""
    used = {each.column for each in inputs} | {mapping.time}
    for joint in leg.joints:
        index = source.find((mapping.joints.get(joint.name) or JointColumn(joint.name)).column, joint.name)
        other = other_side(source.names[index], source.names)
        used |= {source.names[index], None if other is None else source.names[other]}
    left = [
        name
        for k, name in enumerate(source.names)
        if name not in used
        and not any(same_name(name, clock) for clock in (*CLOCKS, *FRAMES))
        and np.isfinite(source.values[:, k]).any()
        and not any(f"{name} is left out" in note for note in notes)
    ]
    if not left:
        return []
    more = f" ... ({len(left)} in all)" if len(left) > SHOWN else ""
    return [f"not used: {', '.join(left[:SHOWN])}{more}"]
