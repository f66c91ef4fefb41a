"""Recordings compared with the designed leg: exchanged, inverted or mislabelled columns show as a much better fit.

Known torques, currents, voltages and commands are in the measured angle's sense, as the angle: a joint's ``sign`` turns
all of them. If only one of the columns is inverted, another ``sign`` is the same leg seen in a mirror.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial, angle_trial
from synth.diagnosis.check.finding import Finding
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.score import score
from synth.diagnosis.workbench import Workbench
from synth.drives.servo import Servo
from synth.errors import UserError
from synth.files.turns import far_command, widest
from synth.fit.recordings import recordings
from synth.swing.leg_model import Leg
from synth.units import significant

if TYPE_CHECKING:
    from synth.files.trial_list import Trial

SAMPLES_A_TRIAL = 120  # samples per trial: enough to see errors of degrees
MOST_TRIALS = 6  # trials compared, those with the largest motion
# Least factor by which a change of columns must reduce the error; as in ``recordings_together``.
LEAST_IMPROVEMENT = 3.0
NEAR_DESIGN = np.radians(15.0)  # rad RMS: a recording farther from the design has other problems than its columns
LEAST_ERROR = np.radians(2.0)  # rad RMS from the design below which columns are accepted
# Either of two changes may be right whose errors are nearer than this factor (a choice, well below LEAST_IMPROVEMENT),
# or differ by less than this share of the error as recorded: what the check takes to stay unexplained anyway.
ALIKE, ALIKE_SHARE = 1.5, 0.01
DEGREE = float(np.radians(1.0))  # rad
# Joints up to which any of them may be in the other unit at once; of more only one or all: 2^n would be too many.
FEW_JOINTS = 3


@dataclass(frozen=True)
class _ColumnChange:
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

    def of(self, leg: Leg, trial: Trial) -> Trial:
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

    def as_recorded(self, error: Array) -> Array:
        """Errors (n_trial,) rad with this change, as large as they are in the recorded unit of the angles.

        In a smaller unit every error is small, so only these can be compared with those of other changes.
        """
        return error / self.factor if self.angle else error

    def counterpart(self, other: _ColumnChange) -> bool:
        """Whether one changes the angle and the other the inputs of the same joints."""
        return (
            self.either is not None
            and self.either == other.either
            and (self.angle, self.inputs) == (other.inputs, other.angle)
        )


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


def column_findings(leg: Leg, trials: Sequence[Trial], bench: Workbench) -> list[Finding]:
    """Columns that look exchanged, inverted, or labelled with the other unit of angles.

    The designed leg predicts each recording from the best-fitting initial state: unchanged, with two columns
    exchanged, with one inverted about its joint's zero, with a joint's inputs inverted, or with angles or commands in
    the other unit. Of angles the error counts against the motion: divided by 57, any recording is near a leg at rest.
    """
    chosen = sorted(trials, key=lambda t: -float(np.nanmax(np.nanstd(t.angles, axis=0))))[:MOST_TRIALS]
    errors = _errors_of_design(leg, chosen, bench)
    chosen = [trial for trial, error in zip(chosen, errors, strict=True) if error > LEAST_ERROR]
    own = errors[errors > LEAST_ERROR]
    if not chosen:
        return []
    changes = _column_changes(leg, chosen)
    missed = [_errors_of_change(leg, chosen, change, bench) for change in changes]
    alike = [change.as_recorded(error) for change, error in zip(changes, missed, strict=True)]
    best: dict[tuple[str, str], list[tuple[int, float]]] = {}
    for k, error in enumerate(own):
        compared = [float(each[k]) for each in alike]
        least = int(np.argmin(compared))
        after = float(missed[least][k])
        if after < min(error / LEAST_IMPROVEMENT, NEAR_DESIGN):
            best.setdefault(_meaning(changes, compared, least, float(error)), []).append((k, after))
    found = []
    for (what, remedy), places in best.items():
        worst, after = places[0]
        names = ", ".join(chosen[k].name for k, _ in places[:3]) + (
            f" and {len(places) - 3} more" if len(places) > 3 else ""
        )
        text = f"{what}: the designed leg's error is {significant(np.degrees(own[worst]), 2)} deg RMS as recorded"
        text += f" and {significant(np.degrees(after), 2)} deg with this change"
        found.append(Finding("fault", text, remedy, names))
    return found


def _meaning(changes: Sequence[_ColumnChange], missed: Sequence[float], best: int, own: float) -> tuple[str, str]:
    """What and remedy of a trial's best change; of both columns if changing the other one does as well.

    ``missed`` (n_change,) rad, its error with each, see ``as_recorded``; ``own`` without a change.
    """
    chosen = changes[best]
    near = max(ALIKE * missed[best], missed[best] + ALIKE_SHARE * own)
    if any(chosen.counterpart(other) and error < near for other, error in zip(changes, missed, strict=True)):
        return chosen.either or (chosen.text, chosen.remedy)
    return chosen.text, chosen.remedy


def _column_changes(leg: Leg, trials: Sequence[Trial]) -> list[_ColumnChange]:
    names = leg.joint_names
    made = [
        _ColumnChange(
            (i, j), f"the columns of {names[i]} and {names[j]} look exchanged", "exchange the two names in its header"
        )
        for i, j in combinations(range(len(names)), 2)
    ]
    for j, name in enumerate(names):
        column = _input_column(leg, trials, j)
        if column:
            made += _changes_of_driven_joint(j, name, column)
        else:
            made.append(
                _ColumnChange((j,), f"{name} looks inverted", "turn the joint's `sign` in the leg file, or its column")
            )
    commanded = [j for j, name in enumerate(names) if _input_column(leg, trials, j) == f"{name} command"]
    return made + _changes_of_unit(names, commanded)


def _changes_of_unit(names: Sequence[str], commanded: Sequence[int]) -> list[_ColumnChange]:
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
                made.append(_ColumnChange(joints, f"{look} {what}", remedy, factor=factor))
                continue
            commands = ", ".join(f"{name} command [{other}]" for name in chosen)
            seen = f"the commands of {' and '.join(chosen)} look like"
            either = f"{look} {what}, or their commands like {reverse}", f"{remedy}, or else {commands}"
            made += [
                _ColumnChange(joints, f"{look} {what}", remedy, either=either, factor=factor),
                _ColumnChange(joints, f"{seen} {reverse}", f"correct the unit in the header: {commands}", angle=False,
                              inputs=True, either=either, factor=inverse),
            ]  # fmt: skip
    return made


def _errors_of_change(leg: Leg, trials: Sequence[Trial], change: _ColumnChange, bench: Workbench) -> Array:
    """(n_trial,) rad RMS error with this change; infinite where one of the unit does not follow the changed motion."""
    changed = [change.of(leg, trial) for trial in trials]
    if change.factor == 1.0:
        return _errors_of_design(leg, changed, bench)
    if change.inputs:
        return np.where(_commands_are_far(leg, changed), np.inf, _errors_of_design(leg, changed, bench))
    moved = [trial.angles[:, list(change.joints)] for trial in changed]
    most = np.array([widest(leg.joints[j]) for j in change.joints])  # beyond it no recording is read
    within = [k for k, angles in enumerate(moved) if np.all(np.nanmax(np.abs(angles), axis=0) < most)]
    found = np.full(len(trials), np.inf)
    found[within] = _errors_of_design(leg, [changed[k] for k in within], bench)
    motion = np.array([float(np.nanmin(np.nanstd(angles, axis=0))) for angles in moved])
    return np.where(found * LEAST_IMPROVEMENT < motion, found, np.inf)


def _commands_are_far(leg: Leg, trials: Sequence[Trial]) -> list[bool]:
    """Of each trial, whether it holds a command that no recording may hold."""
    signals = [trial.signals for trial in trials]
    return [
        each is not None
        and any(far_command(joint, each.command[:, j]) is not None for j, joint in enumerate(leg.joints))
        for each in signals
    ]


def _changes_of_driven_joint(j: int, name: str, column: str) -> list[_ColumnChange]:
    """Its angle, its input, or both: with both in the measured sense, the joint's ``sign`` turns both or none."""
    angle, both = f"the column {name}", "the joint's `sign` turns both and would change nothing"
    turned = f"the column {column}"
    about = " about the joint's zero" if column.endswith("command") else ""
    either = (
        f"{angle} or {turned} looks inverted",
        f"turn one of the two, {name} about the joint's zero or {column}{about}; {both}",
    )
    return [
        _ColumnChange((j,), f"{angle} looks inverted", f"turn it about the joint's zero; {both}", either=either),
        _ColumnChange(
            (j,), f"{turned} looks inverted", f"turn it{about}; {both}", angle=False, inputs=True, either=either
        ),
        _ColumnChange(
            (j,), f"{name} looks inverted, with {column}", "turn the joint's `sign` in the leg file", inputs=True
        ),
    ]


def _input_column(leg: Leg, trials: Sequence[Trial], j: int) -> str:
    """The column that drives a joint in some trial; empty if it is free in all."""
    name, drive = leg.joint_names[j], leg.joints[j].drive
    for trial in trials:
        if trial.torques is not None and np.any(trial.torques[:, j] != 0.0):
            return f"{name} {'current' if name in trial.by_current else 'torque'}"
        if isinstance(drive, Servo) and trial.signals is not None and trial.signals.enabled[:, j].any():
            return f"{name} {'voltage' if drive.open_duty else 'command'}"
    return ""


def _errors_of_design(leg: Leg, trials: Sequence[Trial], bench: Workbench) -> Array:
    """(n_trial,) rad RMS error of the designed leg for each trial; infinite if the simulation fails."""
    found = np.full(len(trials), np.inf)
    made: dict[int, AngleTrial] = {}
    for k, trial in enumerate(trials):
        try:
            (recording,) = recordings(leg, [trial], ())
        except UserError:
            continue
        made[k] = angle_trial(recording, held_out=False).thinner(SAMPLES_A_TRIAL)
    fit = EvaluatedHypothesis((), np.zeros(bench.n_tolerance), ())
    for k, (prediction, _) in zip(made, score(bench, fit, list(made.values())), strict=True):
        trial_made = made[k]
        away = (prediction - trial_made.measured)[trial_made.counts]
        if len(away) and np.all(np.isfinite(away)):
            found[k] = float(np.sqrt(np.mean(away**2)))
    return found
