"""Changes of a project's columns, or of what its leg file says of them, that a slip of the user may have made wrong.

Known torques, currents, voltages and commands are in the measured angle's sense, as the angle: a joint's ``sign`` turns
all of them. If only one of the columns is inverted, another ``sign`` is the same leg seen in a mirror.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TYPE_CHECKING, Protocol

import numpy as np

from synth.diagnosis.plants.swinging_chain.gear_changes import gear_changes
from synth.diagnosis.plants.swinging_chain.input_changes import input_changes
from synth.diagnosis.plants.swinging_chain.leg_changes import leg_changes
from synth.drives.servo import Servo
from synth.swing.leg_model import Leg
from synth.units import significant

if TYPE_CHECKING:
    from synth.files.trial_list import Trial

DEGREE = float(np.radians(1.0))  # rad in a degree
# Joints up to which any of them may be in the other unit at once; of more only one or all: 2^n would be too many.
FEW_JOINTS = 3
MIRRORED = 2  # joints of a leg of which one inverted looks as the other one


class Change(Protocol):
    """What may be wrong: its meaning ``text``, its ``remedy``, and ``either``, both where another fits alike."""

    @property
    def text(self) -> str: ...

    @property
    def remedy(self) -> str: ...

    @property
    def either(self) -> tuple[str, str] | None: ...

    @property
    def scale(self) -> float:
        """Factor by which the angles, and so the errors, are larger than as recorded."""
        ...

    @property
    def must_follow(self) -> bool:
        """Whether errors must be small against the motion too: a leg that hangs still is near any small motion."""
        ...

    def of(self, leg: Leg, trial: Trial) -> Trial:
        """The trial as it would be recorded without the slip."""
        ...

    def of_leg(self, leg: Leg) -> Leg:
        """The leg as its file would state it without the slip; the same object if it is not in the leg file."""
        ...


@dataclass(frozen=True)
class ColumnChange:
    """A change of a trial's columns, and its meaning.

    ``joints`` : two, whose angles are exchanged, or one, of which ``angle`` and ``inputs`` (known torque, command or
    voltage) are inverted. ``either`` : what is meant where this change and that of the other column fit alike.
    ``factor`` : other than 1, the angles of all ``joints``, or their ``inputs``, the commands, are that many times as
    large: their unit is another.
    """

    joints: tuple[int, ...]
    text: str
    remedy: str
    angle: bool = True
    inputs: bool = False
    either: tuple[str, str] | None = None
    factor: float = 1.0

    @property
    def scale(self) -> float:
        """Factor by which the angles are larger than as recorded."""
        return self.factor if self.angle else 1.0

    @property
    def must_follow(self) -> bool:
        """Of another unit of the angles: divided by 57, any recording is near a leg at rest."""
        return self.angle and self.factor != 1.0

    def of_leg(self, leg: Leg) -> Leg:
        """The leg file is not concerned, or all it tells is the same in a mirror."""
        return leg

    def of(self, leg: Leg, trial: Trial) -> Trial:
        """With the columns changed."""
        angles, made = trial.angles.copy(), trial
        j = self.joints[0]
        if self.factor != 1.0 and self.inputs:
            return _with_commands_scaled(trial, self.joints, self.factor)
        if self.factor != 1.0:
            angles[:, list(self.joints)] *= self.factor
        elif len(self.joints) == 2:
            angles[:, list(self.joints)] = angles[:, list(self.joints[::-1])]
        elif self.angle:
            angles[:, j] = 2.0 * leg.joints[j].zero - angles[:, j]
        if self.inputs:
            made = _with_inputs_inverted(leg, trial, j)
        return replace(made, angles=angles, velocities=None) if self.angle else made


@dataclass(frozen=True)
class AbsoluteAngles:
    """Columns that hold the link's own rotation, from where the leg hangs, and not that against the link before it.

    ``joints`` : one or more, not the first.
    """

    joints: tuple[int, ...]
    text: str
    remedy: str
    either: tuple[str, str] | None = None
    scale: float = 1.0
    must_follow: bool = False

    def of_leg(self, leg: Leg) -> Leg:
        """The leg file is not concerned."""
        return leg

    def of(self, leg: Leg, trial: Trial) -> Trial:
        """With the rotation of the link before subtracted, proximal to distal: that is relative or already absolute."""
        recorded = leg.to_rotation(trial.angles)
        made = recorded.copy()
        for j in self.joints:
            made[:, j] -= recorded[:, j - 1] if j - 1 in self.joints else made[:, :j].sum(axis=1)
        return replace(trial, angles=leg.to_measured(made), velocities=None)


def _with_inputs_inverted(leg: Leg, trial: Trial, j: int) -> Trial:
    """With a joint's known torque and voltage negated, and its command mirrored about the joint's zero."""
    torques, signals = trial.torques, trial.signals
    if torques is not None:
        torques = torques.copy()
        torques[:, j] *= -1.0
    drive = leg.joints[j].drive
    if signals is not None and isinstance(drive, Servo):
        command, supply = signals.command.copy(), signals.supply.copy()
        if drive.open_duty:
            supply[:, j] *= -1.0
        else:
            command[:, j] = 2.0 * leg.joints[j].zero - command[:, j]
        signals = replace(signals, command=command, supply=supply)
    return replace(trial, torques=torques, signals=signals)


def _with_commands_scaled(trial: Trial, joints: Sequence[int], factor: float) -> Trial:
    """With the commands of these joints that many times as large."""
    if trial.signals is None:
        return trial
    command = trial.signals.command.copy()
    command[:, list(joints)] *= factor
    return replace(trial, signals=replace(trial.signals, command=command))


def column_changes(leg: Leg, trials: Sequence[Trial]) -> list[Change]:
    """All that may be wrong; of those that fit alike the first is meant."""
    names = leg.joint_names
    made: list[Change] = [
        ColumnChange(
            (i, j), f"the columns of {names[i]} and {names[j]} look exchanged", "exchange the two names in its header"
        )
        for i, j in combinations(range(len(names)), 2)
    ]
    for j in range(len(names)):
        column = input_column(leg, trials, j)
        if column:
            made += _changes_of_driven_joint(names, j, column)
        else:
            made.append(_inverted(names, j, "looks inverted"))
    commanded = [j for j, name in enumerate(names) if input_column(leg, trials, j) == f"{name} command"]
    made += [*_absolute_angles(leg), *_changes_of_unit(names, commanded), *input_changes(leg, trials)]
    made += gear_changes(leg, [input_column(leg, trials, j) for j in range(len(names))])
    return [*made, *leg_changes(leg)]


def _inverted(names: Sequence[str], j: int, looks: str, *, inputs: bool = False) -> ColumnChange:
    """A joint whose ``sign`` is the other; of two that turn freely, one inverted is the other one in a mirror."""
    remedy = "turn the joint's `sign` in the leg file" + ("" if inputs else ", or its column")
    either = None
    if len(names) == MIRRORED:
        both = " or ".join(names)
        either = f"{both} looks inverted", remedy.replace("the joint's `sign`", "the `sign` of one of the two")
    return ColumnChange((j,), f"{names[j]} {looks}", remedy, inputs=inputs, either=either)


def _absolute_angles(leg: Leg) -> list[AbsoluteAngles]:
    """Of all joints beyond the first, or of one alone."""
    names, distal = leg.joint_names, range(1, len(leg.joints))
    sets = [tuple(distal), *(((j,) for j in distal) if len(distal) > 1 else ())] if distal else []
    made = []
    for joints in sets:
        chosen = " and ".join(names[j] for j in joints)
        text = f"{chosen} {'looks' if len(joints) == 1 else 'look'} measured from a fixed direction, as absolute angles"
        taken = "; ".join(f"{names[j]} = {_less(leg, j, joints)}" for j in joints)
        made.append(AbsoluteAngles(joints, text, f"take the angle from the link before it: {taken}"))
    return made


def _less(leg: Leg, j: int, absolute: Sequence[int]) -> str:
    """``knee - (hip - 90 deg)``, the measured angle of an absolute one, from the recorded columns."""
    before = [j - 1] if j - 1 in absolute or j == 1 else list(range(j))
    words = leg.joint_names[j]
    for i in before:
        joint = leg.joints[i]
        minus = joint.sign == leg.joints[j].sign
        zero = significant(abs(np.degrees(joint.zero)), 4)
        shifted = f"({joint.name} {'-' if joint.zero > 0.0 else '+'} {zero} deg)" if joint.zero else joint.name
        words += f" {'-' if minus else '+'} {shifted}"
    return words


def _changes_of_unit(names: Sequence[str], commanded: Sequence[int]) -> list[ColumnChange]:
    """Angles or commands of some joints in radians labelled degrees, or in degrees labelled radians.

    ``commanded`` : the joints that have a command. Of a joint at small angles the ratio of the two shows, no more, so
    that angles in the one unit are alike to commands in the other.
    """
    every = range(len(names))
    sizes = range(1, len(names) + 1) if len(names) <= FEW_JOINTS else (1, len(names))
    units = (("rad", "radians labelled degrees", 1.0 / DEGREE), ("deg", "degrees labelled radians", DEGREE))
    made = []
    for joints in (some for size in sizes for some in combinations(every, size)):
        chosen = [names[j] for j in joints]
        look = f"the angles of {' and '.join(chosen)} look like"
        driven = set(joints) <= set(commanded)
        for (unit, what, factor), (other, reverse, inverse) in (units, units[::-1]):
            header = ", ".join(f"{name} [{unit}]" for name in chosen)
            remedy = f"correct the unit in the header: {header}"
            if not driven:
                made.append(ColumnChange(joints, f"{look} {what}", remedy, factor=factor))
                continue
            commands = ", ".join(f"{name} command [{other}]" for name in chosen)
            seen = f"the commands of {' and '.join(chosen)} look like"
            either = f"{look} {what}, or their commands like {reverse}", f"{remedy}, or else {commands}"
            made += [
                ColumnChange(joints, f"{look} {what}", remedy, either=either, factor=factor),
                ColumnChange(joints, f"{seen} {reverse}", f"correct the unit in the header: {commands}", angle=False,
                              inputs=True, either=either, factor=inverse),
            ]  # fmt: skip
    return made


def _changes_of_driven_joint(names: Sequence[str], j: int, column: str) -> list[ColumnChange]:
    """Its angle, its input, or both: with both in the measured sense, the joint's ``sign`` turns both or none."""
    name = names[j]
    angle, both = f"the column {name}", "the joint's `sign` turns both and would change nothing"
    turned = f"the column {column}"
    about = " about the joint's zero" if column.endswith("command") else ""
    either = (
        f"{angle} or {turned} looks inverted",
        f"turn one of the two, {name} about the joint's zero or {column}{about}; {both}",
    )
    return [
        ColumnChange((j,), f"{angle} looks inverted", f"turn it about the joint's zero; {both}", either=either),
        ColumnChange(
            (j,), f"{turned} looks inverted", f"turn it{about}; {both}", angle=False, inputs=True, either=either
        ),
        _inverted(names, j, f"looks inverted, with {column}", inputs=True),
    ]


def input_column(leg: Leg, trials: Sequence[Trial], j: int) -> str:
    """The column that drives a joint in some trial; empty if it is free in all."""
    name, drive = leg.joint_names[j], leg.joints[j].drive
    for trial in trials:
        if trial.torques is not None and np.any(trial.torques[:, j] != 0.0):
            return f"{name} {'current' if name in trial.by_current else 'torque'}"
        if isinstance(drive, Servo) and trial.signals is not None and trial.signals.enabled[:, j].any():
            return f"{name} {'voltage' if drive.open_duty else 'command'}"
    return ""
