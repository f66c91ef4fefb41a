"""One recording: a CSV of time and a leg's measured angles, converted to SI and checked for common mistakes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import degrees, pi, radians
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.drives.servo import ServoSignals
from synth.errors import Problem, UserError, did_you_mean
from synth.files import drive_columns
from synth.files.csv_table import CsvTable, in_si, read_table
from synth.files.recordings_together import ANOTHER_UNIT, IN_CODE, IN_HEADER, clock_fault, fitting_unit
from synth.files.turns import WIDEST, far_command, unusual_travel, unwrapped, usual_angle, widest
from synth.swing.leg_model import Leg
from synth.units import factor

SHORTEST = 8  # samples; ``smooth`` needs seven
HOLE = 4.5  # times the usual sample step, above which a known torque has a gap; as in ``motion.smoothing``
SUFFIXES = {" velocity": "rad/s", " torque": "N*m"}
EXAMPLES = {"rad": "deg", "rad/s": "deg/s", "N*m": "N*m", "s": "s"}


@dataclass(frozen=True, eq=False)
class Recorded:
    """The columns of a recording, as in ``Trial``.

    ``jumps`` : of each joint by whole turns, which were removed. ``unusual`` : rad that the angles of each joint cover
    where they were given in radians and this is more than the joint is known to do, else 0. ``time_unit`` : of a file's
    clock, as its header has it; empty in code.
    """

    time: Array
    angles: Array
    velocities: Array | None
    torques: Array | None
    sha256: str
    signals: ServoSignals | None = None
    jumps: tuple[int, ...] = ()
    unusual: tuple[float, ...] = ()
    by_current: tuple[str, ...] = ()
    time_unit: str = ""


@dataclass(frozen=True)
class Wording:
    """Words of messages that depend on where a recording comes from.

    ``leg`` : where the leg's ranges are; ``degrees`` : what to do with degrees that were taken for radians, of a
    ``{joint}``; ``missing`` : how to mark wrong samples; ``command`` : how to continue angle and command; ``clock``.
    """

    leg: str
    degrees: str
    missing: str
    command: str
    clock: str


# What an angle beyond any travel may be, see ``column_units``.
COUNTS = "; if these are raw counts of an encoder, synth import turns them into angles: counts: 4096 (a turn)"
FILE = Wording(
    "the leg file",
    "write {joint} [deg] in the header",
    "leave wrong cells empty",
    "synth import removes both",
    IN_HEADER,
)
CODE = Wording("the leg", "write numpy.radians(...)", "set wrong samples to nan",
               "continue both: numpy.unwrap(...)", IN_CODE)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Columns:
    """The columns of a recording, of a file or made in code.

    ``values`` : name -> (n,) in SI; ``units`` : name of every column -> its unit as given; ``problem`` : a mistake from
    its text, the column or an empty name, and the row or None. ``stamps`` : (n,) times as a file gives them, with all
    digits; its clock may begin elsewhere. None: those of ``values``.
    """

    values: dict[str, Array]
    units: Mapping[str, str]
    problem: Callable[[str, str, int | None], Problem]
    wording: Wording
    stamps: Array | None = None


def read_recording(path: Path, leg: Leg, *, name: str | None = None, off: Sequence[str] = ()) -> Recorded:
    """Read one recording of ``leg``.

    Parameters
    ----------
    path
        the CSV: ``time [s]``, then ``NAME [deg]`` for each joint, in any order; ``NAME velocity [deg/s]`` and
        ``NAME torque [N*m]`` are optional; for a driven joint the inputs of its drive, see ``drive_columns``.
    leg
        whose joints the columns belong to; its ranges and zeros reveal a wrong angle unit.
    name
        the file in messages.
    off
        joints whose drive is off, with an open winding: they need no column of it.

    Raises
    ------
    UserError
        With every mistake of the file: columns, units, time that does not increase, implausible angles.
    """
    table = read_table(path, name)
    titles = {column.name: column.title for column in table.columns}

    def problem(text: str, column: str, row: int | None) -> Problem:
        line = (1 if column else None) if row is None else table.line(row)
        return Problem(text, table.name, line, titles.get(column, column) or None)

    units = {column.name: column.unit for column in table.columns}
    values = _scaled(table, leg, off)
    stamps = table.values[:, [column.name for column in table.columns].index("time")]
    columns = Columns(values, units, problem, FILE, stamps)
    found = checked_columns(columns, leg)
    for array in (found.time, found.angles, found.velocities, found.torques):
        if array is not None:
            array.flags.writeable = False
    signals = drive_columns.signals(leg, drive_columns.switched_off(leg, columns.values, off), found.time)
    return replace(found, sha256=table.sha256, signals=signals, time_unit=units["time"])


def checked_columns(columns: Columns, leg: Leg) -> Recorded:
    """The columns of a recording of ``leg``, checked, with angles continued over jumps by whole turns.

    Raises
    ------
    UserError
        As ``read_recording``, for what is not the form of a file.
    """
    values = columns.values
    time = values["time"]
    problems = _time_problems(columns)
    problems += _empty_columns(columns, leg)
    angles = np.column_stack([values[joint] for joint in leg.joint_names])
    jumps: tuple[int, ...] = ()
    if not problems:
        given = angles
        angles, jumps, problems = _without_jumps(columns, leg, given)
        # A doubtful jump of angles in a wrong unit is none.
        problems = _angle_problems(columns, leg, given if problems else angles) or problems
    velocities = _optional(values, leg, " velocity", np.nan)
    for joint, torque in drive_columns.torques(leg, values).items():
        if joint + " torque" in values:
            text = "is given beside the current of the same drive; leave one of them out"
            problems.append(columns.problem(text, joint + " torque", None))
        values[joint + " torque"] = torque
    torques = _optional(values, leg, " torque", 0.0)
    if torques is not None and not problems:
        torques, problems = _between_samples(columns, leg, angles, torques)
    if problems:
        raise UserError(problems)
    unusual = tuple(
        0.0 if _is_degrees(columns.units[joint.name]) else unusual_travel(joint, angles[:, j])
        for j, joint in enumerate(leg.joints)
    )
    by_current = tuple(drive_columns.torques(leg, values))
    return Recorded(time, angles, velocities, torques, "", None, jumps, unusual, by_current)


def _scaled(table: CsvTable, leg: Leg, off: Sequence[str] = ()) -> dict[str, Array]:
    """Columns by name, in SI; raises where one is missing, unknown, or in a unit of another dimension."""
    wanted = {"time": "s", **dict.fromkeys(leg.joint_names, "rad")}
    for suffix, unit in SUFFIXES.items():
        wanted |= {joint + suffix: unit for joint in leg.joint_names}
    wanted |= drive_columns.column_units(leg)
    values, problems = in_si(table, wanted, "is not of this leg")
    present = [column.name for column in table.columns]
    for required in ("time", *leg.joint_names):
        if required not in present:
            unknown = [column for column in present if column not in wanted]
            hint = did_you_mean(required, unknown)
            text = f'column "{required} [{EXAMPLES[wanted[required]]}]" is missing'
            problems.append(Problem(text + hint.replace("did you mean", "is it"), table.name, 1))
    problems += drive_columns.problems(table, leg, off)
    if problems:
        raise UserError(problems)
    return values


def _time_problems(columns: Columns) -> list[Problem]:
    time = columns.values["time"]
    if len(time) < SHORTEST:
        return [columns.problem(f"has {len(time)} samples; a trial needs at least {SHORTEST}", "", None)]
    missing = np.isnan(time)
    if missing.any():
        return [columns.problem("has no time; every sample needs one", "time", int(missing.argmax()))]
    back = np.flatnonzero(np.diff(time) <= 0)
    if not len(back):
        others = [np.isfinite(values) for name, values in columns.values.items() if name != "time"]
        fault = clock_fault(time, np.column_stack(others) if others else None)
        if not fault:
            return []
        remedy = fitting_unit(time, columns.units["time"]) if columns.wording is FILE else ""
        return [columns.problem(f"{fault}. {ANOTHER_UNIT} {columns.wording.clock}{remedy}", "time", None)]
    row = int(back[0]) + 1
    if columns.stamps is None:
        before, after = (f"{value:g}" for value in time[row - 1 : row + 1] / factor(columns.units["time"], "s"))
    else:
        before, after = (repr(float(value)).removesuffix(".0") for value in columns.stamps[row - 1 : row + 1])
    what = "repeats" if time[row] == time[row - 1] else "runs backwards"
    more = f" (and in {len(back) - 1} more lines)" if len(back) > 1 else ""
    return [columns.problem(f"time {what}: {before}, then {after}{more}", "time", row)]


def _empty_columns(columns: Columns, leg: Leg) -> list[Problem]:
    needed = (
        "; each trial needs the angle of every joint, of a locked one that at which it is held. Leave the trial out"
    )
    return [
        columns.problem(
            "is empty from top to bottom" + (needed if name in leg.joint_names else "; leave it out or record it"),
            name,
            None,
        )
        for name, values in columns.values.items()
        if name != "time" and len(values) and np.isnan(values).all()
    ]


def _without_jumps(columns: Columns, leg: Leg, angles: Array) -> tuple[Array, tuple[int, ...], list[Problem]]:
    """Angles (n, n_joint) continued over jumps by whole turns, the number of these by joint, and doubtful ones."""
    found = [unwrapped(column) for column in angles.T]
    problems = []
    for name, angle, each in zip(leg.joint_names, angles.T, found, strict=True):
        if each.doubtful is not None:
            row = each.doubtful
            before = angle[:row][np.isfinite(angle[:row])][-1]
            text = f"goes from {degrees(before):.4g} to {degrees(angle[row]):.4g} deg between two samples, which may "
            text += (
                f"be a whole turn or not; write angles that go on beyond 180 or 360 deg, or {columns.wording.missing}"
            )
            problems.append(columns.problem(text, name, row))
        elif each.jumps and f"{name} command" in columns.units:
            text = f"jumps by whole turns ({each.jumps} times), and so its command may; {columns.wording.command}"
            problems.append(columns.problem(text, name, None))
    return np.column_stack([each.angle for each in found]), tuple(each.jumps for each in found), problems


def _angle_problems(columns: Columns, leg: Leg, angles: Array) -> list[Problem]:
    """Implausible angles, a sign of degrees labelled radians or of radians labelled degrees."""
    problems: list[Problem] = []
    for index, joint in enumerate(leg.joints):
        size = np.abs(angles[:, index])
        limit = widest(joint)
        if np.nanmax(size) > limit:
            row = int(np.nanargmax(size > limit))
            stated = joint.range if limit > WIDEST else None
            problems.append(_too_wide(columns, joint.name, angles[row, index], row, stated))
    if problems := problems + _command_problems(columns, leg):
        return problems
    in_degrees = all(_is_degrees(columns.units[joint.name]) for joint in leg.joints)
    return _radians_as_degrees(columns, leg, angles) if in_degrees else []


def _command_problems(columns: Columns, leg: Leg) -> list[Problem]:
    """Commands to where no joint is: counts taken for degrees, or degrees for radians, made another servo of it."""
    problems = []
    for joint in leg.joints:
        name = f"{joint.name} command"
        command = columns.values.get(name)
        row = None if command is None else far_command(joint, command)
        if command is not None and row is not None:
            stated = joint.range if widest(joint) > WIDEST else None
            problems.append(_too_wide(columns, name, float(command[row]), row, stated))
    return problems


def _between_samples(columns: Columns, leg: Leg, angles: Array, torques: Array) -> tuple[Array, list[Problem]]:
    """Known torques (n, n_joint) N m in every row, linear between the samples of their own columns; and mistakes.

    A torque may be sampled more densely than the angles, or at other times, with empty cells in the other columns. A
    gap in its samples, or a recording that extends beyond them, is a mistake, because an empty cell does not
    mean 0.
    """
    time, filled, problems = columns.values["time"], torques.copy(), []
    recorded = np.flatnonzero(np.isfinite(angles).any(axis=1))
    for j in np.flatnonzero(np.isnan(torques).any(axis=0)):
        known = np.flatnonzero(np.isfinite(torques[:, j]))
        filled[:, j] = np.interp(time, time[known], torques[known, j])
        rows = np.concatenate([recorded[:1], known[(known > recorded[0]) & (known < recorded[-1])], recorded[-1:]])
        longest = HOLE * float(np.median(np.diff(time[known]))) if len(known) > 1 else 0.0
        holes = np.flatnonzero(np.diff(time[rows]) > longest)
        if len(holes):
            first, last = time[rows[holes[0]]], time[rows[holes[0] + 1]]
            text = f"no torque is given between {first:g} s and {last:g} s; write 0 where none acts"
            empty = int(rows[holes[0]] + np.isnan(torques[rows[holes[0]] :, j]).argmax())
            problems.append(columns.problem(text, f"{leg.joint_names[j]} torque", empty))
    return filled, problems


def _is_degrees(unit: str) -> bool:
    return abs(factor(unit, "rad") / radians(1.0) - 1.0) < 1e-9


def _too_wide(columns: Columns, joint: str, angle: float, row: int, stated: tuple[float, float] | None) -> Problem:
    """An angle beyond the joint's ``stated`` range in rad, or without one beyond any joint's travel."""
    unit, leg = columns.units[joint], columns.wording.leg
    shown = f"{angle / factor(unit, 'rad'):g} {unit}"
    shown += " is" if _is_degrees(unit) else f" is {degrees(angle):.0f} deg,"
    if stated is not None:
        low, high = map(degrees, stated)
        text = f"{shown} outside the joint's range in {leg}, {low:g} to {high:g} deg"
        text += "; if it turns so far, widen that range"
        text += COUNTS if abs(angle) > WIDEST else ""
    else:
        text = f"{shown} beyond any joint's travel; if the joint does turn so far, give it a range in {leg}"
        if not _is_degrees(unit):
            text += f"; if these are degrees, {columns.wording.degrees.format(joint=joint)}"
        text += COUNTS
    return columns.problem(text, joint, row)


def _radians_as_degrees(columns: Columns, leg: Leg, angles: Array) -> list[Problem]:
    """Refuse angles below 2 pi that are plausible for this leg only as radians.

    The reference is the position of each joint in the leg file: the middle of its range, else its spring's free angle,
    else its straight position. As degrees the angles must be far from there (60 degrees or more in the root mean square
    over the joints, and outside a given range), and as radians less than half as far.
    """
    numbers = angles / radians(1.0)
    if np.nanmax(np.abs(numbers)) > 2 * pi:
        return []
    if any(joint.range and _inside(angles[:, j], joint.range) for j, joint in enumerate(leg.joints)):
        return []
    expected = np.array([usual_angle(joint) for joint in leg.joints])
    as_degrees = _distance(np.nanmedian(angles, axis=0), expected)
    as_radians = _distance(np.nanmedian(numbers, axis=0), expected)
    if as_degrees < radians(60) or as_radians > as_degrees / 2:
        return []
    low, high = float(np.nanmin(numbers)), float(np.nanmax(numbers))
    text = (
        f"the angles are labelled degrees and lie between {low:.3g} and {high:.3g}: the leg file puts its joints "
        f"{degrees(as_degrees):.0f} deg from there, while radians would fit. If they are radians, write "
        f"{leg.joints[0].name} [rad] in the header; if they are degrees, give the joints a range in the leg file"
    )
    return [columns.problem(text, leg.joints[0].name, None)]


def _inside(angle: Array, span: tuple[float, float]) -> bool:
    margin = radians(15)
    return bool(span[0] - margin <= np.nanmin(angle) and np.nanmax(angle) <= span[1] + margin)


def _distance(angle: NDArray[np.float64], expected: NDArray[np.float64]) -> float:
    """Root mean square over the joints, rad."""
    return float(np.sqrt(np.mean((angle - expected) ** 2)))


def _optional(values: dict[str, Array], leg: Leg, suffix: str, absent: float) -> Array | None:
    """Columns ``NAME velocity`` or ``NAME torque`` of all joints, ``absent`` where a joint has none."""
    if not any(joint + suffix in values for joint in leg.joint_names):
        return None
    time = values["time"]
    return np.column_stack([values.get(joint + suffix, np.full(len(time), absent)) for joint in leg.joint_names])
