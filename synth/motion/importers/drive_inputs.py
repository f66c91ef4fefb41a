"""Inputs of a leg's drives in a foreign file: commands, voltages, currents, torques, switches and the supply.

A joint without a drive takes a known torque.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.drives.servo import Servo, TorqueDrive
from synth.errors import Problem, UserError
from synth.files.import_mapping import DRIVEN, InputColumn, JointColumn, Mapping
from synth.files.turns import TURN
from synth.motion.importers.command_turns import TurnedAngle, same_turn
from synth.motion.importers.foreign_data import Channels, ColumnProblem, name_list
from synth.motion.importers.raw_counts import angle_scale, of_command, without_overflow
from synth.swing.leg_model import Joint, Leg
from synth.units import factor

TABLE_UNITS = {"command": "deg", "voltage": "V", "current": "A", "torque": "N*m", "enabled": "1"}
# Names of each input in loggers' columns, combined with the joint's: "knee goal position", "knee_cmd", "desired_knee".
WORDS = {
    "command": ("command", "cmd", "goal", "goal position", "desired", "desired position", "reference", "target",
                "target position", "setpoint"),
    "voltage": ("voltage", "motor voltage"),
    "current": ("current", "present current", "motor current"),
    "torque": ("torque", "effort"),
    "enabled": ("enabled", "torque enable", "torque enabled"),
}  # fmt: skip
SUPPLIES = ("supply", "supply voltage", "input voltage", "input volts", "battery voltage")
# s, stamps closer than this share a row: below any controller's period, above rounding of stamps
INPUTS_TOGETHER = 1e-6


@dataclass(frozen=True, eq=False)
class DriveInput:
    """One column of a trial: ``title`` with its unit, ``value`` (m,) in that unit at ``time`` (m,) s.

    ``column`` : its name in the foreign file.
    """

    title: str
    time: Array
    value: Array
    column: str = ""


def accepted_inputs(joint: Joint) -> tuple[set[str], set[str]]:
    """Names in ``DRIVEN`` of the inputs of which a joint's drive needs one, and of its optional inputs.

    A joint without a drive, or with one whose torque is known as such, takes a known torque; a file without that was
    recorded free. A servo's torque column is its own motor's, which the model tells.
    """
    if isinstance(joint.drive, Servo):
        return ({"voltage"} if joint.drive.open_duty else {"command"}), {"enabled"}
    return (set(), {"torque"}) if joint.drive in (None, TorqueDrive()) else ({"current", "torque"}, set())


def drive_inputs(
    source: Channels, leg: Leg, mapping: Mapping, time: Array, angles: Array, cleaned: Array, notes: list[str]
) -> tuple[DriveInput, ...]:
    """The inputs of the leg's drives, and known torques of joints without one.

    Parameters
    ----------
    time : (n,) s of the source's samples.
    angles, cleaned : (n, n_joint) rad, measured angles before and after whole turns were removed.

    Raises
    ------
    UserError : a drive lacks its input, or a column that the project names does not exist or has no drive.
    """
    problems: list[Problem] = []
    found: list[DriveInput] = []
    for index, joint in enumerate(leg.joints):
        column = mapping.joints.get(joint.name) or JointColumn(joint.name)
        turned = _turned_angle(time, angles[:, index], cleaned[:, index])
        try:
            for word, own, k in _of_joint(source, joint, column):
                notes.append(f"{joint.name} {word}: from {own.names[k]}")
                made = _convert_input(source, own, k, word, joint, column, time, notes)
                if word == "command" and turned is not None:
                    value = same_turn(f"{joint.name} {word}", made.time, made.value, turned, notes)
                    made = replace(made, value=value)
                found.append(made)
        except UserError as error:
            problems += error.problems
    try:
        found += _supply(source, leg, mapping, time, notes)
    except UserError as error:
        problems += error.problems
    if problems:
        raise UserError(problems)
    return tuple(found)


def _of_joint(source: Channels, joint: Joint, column: JointColumn) -> Iterator[tuple[str, Channels, int]]:
    """Name of each input, its channels and the index there."""
    one_of, besides = accepted_inputs(joint)
    foreign = [word for word in column.inputs if word not in one_of | besides | {"torque"}]
    # An effort of a joint without a drive is what a robot's driver reports, zeros or noise; a torque is a known one.
    words = WORDS if joint.drive is not None else {"torque": ("torque",)}
    if foreign:
        kind = "none" if joint.drive is None else "one that takes " + " or ".join(sorted(one_of or besides))
        text = (
            f"{joint.name}: its drive in the leg file ({kind}) takes no {foreign[0]}; leave it out, or change the drive"
        )
        raise UserError(Problem(text, source.name))
    given = {word: _input_channel(source, joint, word, each) for word, each in column.inputs.items()}
    missing = not (one_of & set(given))
    for word in DRIVEN:
        wanted = word in besides or (missing and word in one_of)
        place = given.get(word) or (channel_by_name(source, joint, column, words[word]) if wanted else None)
        if place is not None:
            missing = missing and word not in one_of
            yield word, place[0], place[1]
    if missing and one_of:
        word = next(word for word in DRIVEN if word in one_of)
        text = f"there is no {word} of {joint.name}, which its drive needs; name its column in a project: joints: "
        text += f"{{{joint.name}: {{column: {column.column}, {word}: NAME}}}}; the file has {name_list(source.names)}"
        raise UserError(Problem(f"{text}; {source.hint}" if source.hint else text, source.name))


def _input_channel(source: Channels, joint: Joint, word: str, wanted: InputColumn) -> tuple[Channels, int]:
    for own in source.inputs:
        if own.has(wanted.column):
            return own, own.find(wanted.column, joint.name)
    return source, source.find(wanted.column, f"{joint.name} {word}")


def channel_by_name(
    source: Channels, joint: Joint, column: JointColumn, words: Sequence[str]
) -> tuple[Channels, int] | None:
    """The channel whose name combines the joint and one of these words; None if there is none."""
    for own in (source, *source.inputs):
        for base in dict.fromkeys((column.column, joint.name)):
            for each in words:
                for title in (f"{base} {each}", f"{each} {base}"):
                    if own.has(title) and np.isfinite(own.values[:, own.find(title, each)]).any():
                        return own, own.find(title, each)
    return None


def _convert_input(
    source: Channels,
    own: Channels,
    k: int,
    word: str,
    joint: Joint,
    column: JointColumn,
    time: Array,
    notes: list[str],
) -> DriveInput:
    """An input with the sign of the measured angle and in the table's unit; ``own`` : the channels that contain it."""
    what, stated = f"{joint.name} {word}", column.inputs.get(word)
    zero, sign = column.of_joint(joint)
    sense = joint.sign * sign
    if word == "command":
        commanded = of_command(own, k, column, stated)
        scale = angle_scale(own, k, commanded, what)
        value = without_overflow(own.values[:, k], commanded, what, notes) * scale
        value = joint.zero + sense * (value - zero)
    else:
        value = own.values[:, k] * factor(_unit(own, k, stated, what, word), DRIVEN[word])
        value = value if word == "enabled" else sense * value
    table = TABLE_UNITS[word]
    value = value * factor(DRIVEN[word], table)
    title = f"{what} [{table}]"
    if own is source or own.time is None:
        return DriveInput(title, time, value, own.names[k])
    known = np.isfinite(value)
    return DriveInput(title, own.time[known], value[known], own.names[k])


def _unit(own: Channels, k: int, stated: InputColumn | None, what: str, word: str) -> str:
    """The unit of an input: the file's own, or the project's."""
    unit = own.units[k] or (stated.unit if stated is not None else None) or ("1" if word == "enabled" else None)
    if unit is None:
        title, example = own.names[k], TABLE_UNITS[word]
        text = f'{what}: the file does not state the unit of "{title}"; write {{column: {title}, unit: {example}}}'
        raise UserError(ColumnProblem(text, own.name))
    try:
        factor(unit, DRIVEN[word])
    except UserError as error:
        raise UserError(Problem(f"{what}: {error.problems[0].text}", own.name)) from None
    return unit


def _turned_angle(time: Array, angle: Array, cleaned: Array) -> TurnedAngle | None:
    """A joint whose whole turns were changed; None if none were."""
    known = np.isfinite(cleaned)
    if not (np.abs(cleaned - angle)[known] > TURN / 2).any():
        return None
    return TurnedAngle(time[known], np.degrees(angle[known]), np.degrees(cleaned[known]))


def _supply(source: Channels, leg: Leg, mapping: Mapping, time: Array, notes: list[str]) -> list[DriveInput]:
    """The supply voltage, if a servo with a motor needs it."""
    takes = any(isinstance(j.drive, Servo) and j.drive.motor and not j.drive.open_duty for j in leg.joints)
    if not takes:
        if mapping.supply is not None:
            text = "no joint has a servo with a motor, which alone takes a supply; leave it out"
            raise UserError(Problem(text, source.name, key="supply"))
        return []
    if mapping.supply is not None:
        k = source.find(mapping.supply.column, "supply")
    else:
        known = [name for name in SUPPLIES if source.has(name) and source.units[source.find(name, "supply")]]
        if not known:
            return []
        k = source.find(known[0], "supply")
    unit = _unit(source, k, mapping.supply, "supply", "voltage")
    notes.append(f"supply: from {source.names[k]}")
    return [DriveInput("supply [V]", time, source.values[:, k] * factor(unit, "V"), source.names[k])]


def inputs_within(
    inputs: Sequence[DriveInput], clock: Array, first: int, last: int
) -> tuple[tuple[DriveInput, ...], int]:
    """The inputs over the samples ``first`` to before ``last`` of ``clock`` (n,) s.

    An input with a separate clock is a command, which is constant from one sample to the next; it begins with the
    sample that is valid at the first row. The second result is the first sample at which every command is known.
    """
    own = [each for each in inputs if each.time is not clock]
    begin = max([clock[first], *(float(each.time[0]) for each in own)])
    first = max(first, int(np.searchsorted(clock, begin - INPUTS_TOGETHER)))
    kept = []
    for each in inputs:
        if each.time is clock:
            kept.append(replace(each, time=clock[first:last], value=each.value[first:last]))
            continue
        if first >= last:
            break
        held = max(0, int(np.searchsorted(each.time, clock[first] + INPUTS_TOGETHER)) - 1)
        until = int(np.searchsorted(each.time, clock[last - 1] + INPUTS_TOGETHER))
        rows = np.maximum(each.time[held : max(until, held + 1)], clock[first])
        kept.append(replace(each, time=rows, value=each.value[held : max(until, held + 1)]))
    return tuple(kept), first


def merge_inputs(time: Array, inputs: Sequence[DriveInput]) -> tuple[Array, NDArray[np.intp], dict[str, Array]]:
    """One table on the union of all clocks.

    Returns
    -------
    Times (m,) s; rows (n,) of the samples at ``time`` (n,) s; title -> input (m,), nan where it has no sample.
    """
    every = np.sort(np.concatenate([time, *(each.time for each in inputs)]))
    starts = np.concatenate([[True], np.diff(every) > INPUTS_TOGETHER])
    clock = every[starts]
    rows = _row(time, clock)
    clock[rows] = time
    columns = {}
    for each in inputs:
        column = np.full(len(clock), np.nan)
        column[_row(each.time, clock)] = each.value
        columns[each.title] = column
    return clock, rows, columns


def _row(time: Array, clock: Array) -> NDArray[np.intp]:
    """Rows (n,) of ``clock`` closest to ``time`` (n,)."""
    after = np.clip(np.searchsorted(clock, time), 1, len(clock) - 1)
    return np.asarray(after - (time - clock[after - 1] < clock[after] - time))
