"""A segment's angle from straight down, out of the quaternion of an inertial sensor on it.

The quaternion w, x, y, z turns the sensor's axes into the Earth's, whose z is up. Up in the sensor's axes, u, is the
third row of its rotation matrix (Kuipers, Quaternions and Rotation Sequences, 1999, section 5.14). Of a link that
turns about the axis n and points along d from its joint outward, both in the sensor's axes, the angle from straight
down, counter-clockwise about n, is atan2(u . (n x d), -u . d). The heading, which drifts or begins anywhere, is not in
it.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from math import degrees, radians

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.import_mapping import JointColumn, Mapping
from synth.motion.importers.foreign_data import Channels
from synth.remarks import decisive
from synth.swing.leg_model import Leg

LENGTH_SCATTER = 0.05  # of the usual length; digits leave less, and four columns of something else more
TURNS = radians(5.0)  # the least turn, either way, that shows its axis: some ten times what a sensor's scatter does
OFF = radians(10.0)  # from the axis stated: beyond, the angle's changes are off by 1.5 % and more
LEVEL = radians(60.0)  # of the axis from level: beyond, less than half of gravity is left to tell the angle
_PART = re.compile(r"(?<![a-z])q?([wxyz0-3])(?![a-z0-9])")  # of a column's name: which part of a quaternion it is


def with_quaternions(source: Channels, leg: Leg, mapping: Mapping) -> tuple[Channels, list[str]]:
    """The file with a column of angles in the place of each quaternion that the project names, and notes on them.

    Raises
    ------
    UserError : columns that do not exist or are no quaternion, or an axis that is not stated or near the vertical.
    """
    problems: list[Problem] = []
    made: dict[str, Array] = {}
    notes: list[str] = []
    used: set[int] = set()
    for joint in leg.joint_names:
        column = mapping.joints.get(joint)
        if column is None or not column.quaternion:
            continue
        if column.column in made:
            text = f"{joint}: its {column.column} is another joint's already; each link has a sensor of its own"
            problems.append(Problem(text, source.name))
            continue
        try:
            indices, found = _rotations(source, joint, column, notes)
            made[column.column] = _angle(found, joint, column, source.name, notes)
            used.update(indices)
        except UserError as error:
            problems += error.problems
    if problems:
        raise UserError(problems)
    if not made:
        return source, []
    kept = [index for index in range(len(source.names)) if index not in used]
    numbers = source.numbers
    changed = replace(
        source,
        names=(*(source.names[index] for index in kept), *made),
        units=(*(source.units[index] for index in kept), *("rad" for _ in made)),
        values=np.column_stack([source.values[:, kept], *made.values()]),
        numbers=None if numbers is None else lambda column: numbers(kept[column]),  # of clocks, which are kept
    )
    return changed, notes


def _rotations(source: Channels, joint: str, column: JointColumn, notes: list[str]) -> tuple[list[int], Array]:
    """Indices of the columns, and unit quaternions (n, 4), nan where missing."""
    signs = np.array([-1.0 if name.startswith("-") else 1.0 for name in column.quaternion])
    indices = [source.find(name.removeprefix("-"), joint) for name in column.quaternion]
    names = [source.names[index] for index in indices]
    parts = [found[0] if len(found := _PART.findall(name.casefold().replace("_", " "))) == 1 else "" for name in names]
    for order in ("wxyz", "0123"):
        if sorted(parts) == sorted(order) and "".join(parts) != order:
            right = ", ".join(names[parts.index(part)] for part in order)
            text = f"{joint}: a quaternion's columns are stated in the order w, x, y, z: quaternion: [{right}]"
            raise UserError(Problem(text, source.name))
    values = source.values[:, indices] * signs
    lengths = np.linalg.norm(values, axis=1)
    empty = lengths == 0.0
    if empty.any():
        notes.append(f"{joint}: {int(empty.sum())} quaternions are 0 and count as missing")
    lengths[empty] = np.nan
    if not np.isfinite(lengths).any():
        raise UserError(Problem(f"{joint}: its quaternion ({', '.join(names)}) has no sample", source.name))
    usual = float(np.nanmedian(lengths))
    wrong = np.abs(lengths - usual) > LENGTH_SCATTER * usual
    if wrong.any():
        row = int(np.argmax(wrong))
        text = f"{joint}: {', '.join(names)} are no quaternion: its length is {lengths[row]:.4g} in sample {row + 1} "
        raise UserError(Problem(f"{text}and {usual:.4g} usually, and of a rotation it is one", source.name))
    return indices, values / lengths[:, None]


def _angle(rotations: Array, joint: str, column: JointColumn, name: str, notes: list[str]) -> Array:
    """(n,) rad from straight down, nan where missing; ``rotations`` (n, 4)."""
    known = np.isfinite(rotations).all(axis=1)
    found = _Turning.of(rotations[known])
    if column.axis is None:
        turns, own = found.angle >= TURNS, _triple(found.axis)
        shown = f"the file shows {own} or its negative: axis: {own}" if turns else f"{_STILL}: {EXAMPLE}"
        text = f"{joint}: write the axis about which this link turns, in the sensor's own axes, towards the one who "
        raise UserError(Problem(f"{text}sees the leg as the leg file has it; {shown}", name))
    axis, down = np.array(column.axis), np.array(column.down)
    axis = axis / np.linalg.norm(axis)
    down = down - (down @ axis) * axis
    down /= np.linalg.norm(down)
    w, x, y, z = rotations.T
    up = np.column_stack([2.0 * (x * z - w * y), 2.0 * (y * z + w * x), w**2 - x**2 - y**2 + z**2])
    lean = float(np.arcsin(np.clip(np.median(np.abs(up[known] @ axis)), 0.0, 1.0)))
    if lean > LEVEL:
        text = f"{joint}: its axis is {degrees(lean):.0f} deg from level: about a vertical one gravity tells no angle; "
        raise UserError(Problem(f"{text}check the axis, which is in the sensor's own axes, and the columns", name))
    angle = np.arctan2(up @ np.cross(axis, down), -(up @ down))
    first, last = (degrees(float(angle[known][k])) for k in (0, -1))
    text = f"{joint}: from {column.column}: {first:.1f} deg from straight down at first, {last:.1f} deg at the end, "
    notes += [f"{text}counter-clockwise about {_triple(axis)}", _on_axis(joint, found, axis, column)]
    return np.asarray(angle)


def _on_axis(joint: str, found: _Turning, axis: Array, column: JointColumn) -> str:
    """A sentence on how the file's own axis agrees with the unit vector (3,) stated."""
    if found.angle < TURNS:
        return f"{joint}: {_STILL}, so the axis stated was not checked"
    off = _between(found.axis, axis)
    text = f"{joint}: the sensor turns about {_triple(found.axis)} of its own axes, {degrees(off):.1f} deg from the "
    text += f"axis stated, and by {degrees(found.beside):.1f} deg (RMS) about others"
    if off <= OFF:
        return text
    advice = "State that axis or its negative, whichever points to the one who sees the leg as the leg file has it"
    if _between(found.of_earth, axis) <= OFF:
        w, *others = column.quaternion
        turned = [each.removeprefix("-") if each.startswith("-") else f"-{each}" for each in others]
        advice += ", or, if the quaternions turn the Earth's axes into the sensor's, "
        advice += f"quaternion: [{', '.join([w, *turned])}]"
    return decisive(f"{text}: its angle is wrong", f"{advice}.")


def _between(one: Array, other: Array) -> float:
    """The angle between the lines of two unit vectors (3,), rad."""
    return float(np.arccos(np.clip(abs(one @ other), 0.0, 1.0)))


EXAMPLE = "axis: [0, 0, 1]"
_STILL = f"the sensor turns by less than {degrees(TURNS):.0f} deg in the file"


@dataclass(frozen=True, eq=False)
class _Turning:
    """The main axis of a sensor's turns, a unit vector (3,) in its own axes and ``of_earth`` in the Earth's.

    ``angle`` : rad, the farthest turn about it from the mean; ``beside`` : RMS of the turns about others.
    """

    axis: Array
    of_earth: Array
    angle: float
    beside: float

    @classmethod
    def of(cls, rotations: Array) -> _Turning:
        """Of unit quaternions (n, 4); the mean is the main direction of their squares (Markley and others, 2007)."""
        from scipy.spatial.transform import Rotation

        mean = Rotation.from_quat(np.roll(np.linalg.eigh(rotations.T @ rotations)[1][:, -1], -1))
        every = Rotation.from_quat(np.roll(rotations, -1, axis=1))
        turns = (mean.inv() * every).as_rotvec()
        axis, of_earth = (_main(each) for each in (turns, (every * mean.inv()).as_rotvec()))
        along = turns @ axis
        beside = float(np.sqrt(np.mean(((turns - along[:, None] * axis) ** 2).sum(axis=1))))
        return cls(axis, of_earth, float(np.abs(along).max()), beside)


def _main(turns: Array) -> Array:
    """The main direction (3,) of vectors (n, 3), its largest component positive."""
    axis = np.linalg.eigh(turns.T @ turns)[1][:, -1]
    return np.asarray(axis * np.sign(axis[int(np.argmax(np.abs(axis)))]))


def _triple(axis: Array) -> str:
    return f"[{', '.join(f'{value:.2f}' for value in np.round(axis, 2) + 0.0)}]"
