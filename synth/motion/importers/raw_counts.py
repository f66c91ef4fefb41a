"""Scale of a foreign file's angles: units, an encoder's raw counts, gears, and counters that ran over their end."""

from __future__ import annotations

import re

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.column_units import how_counts_are_written
from synth.files.import_mapping import InputColumn, JointColumn
from synth.files.turns import TURN
from synth.motion.importers.foreign_data import Channels
from synth.units import factor

PER_SECOND = re.compile(r"[\[(]\s*(counts?|cts|ticks?|pulses?|lsb)\s*/\s*s(ec)?\s*[\])]$", re.IGNORECASE)
WORD = 2.0**32  # numbers of a register of 32 bits; from the half on an unsigned reading is a negative number
TIMER = 2.0**16  # numbers of a microcontroller's timer that counts an encoder's edges


def angle_scale(own: Channels, index: int, column: JointColumn, what: str) -> float:
    """The joint's angle in rad of one number of a channel.

    Raises
    ------
    UserError : the file states a unit and the project counts, or neither states one.
    """
    if column.counts is None:
        unit = own.unit(index, column.unit, what, "deg", f"; {how_counts_are_written()}")
        return factor(unit, "rad") / column.gear_ratio
    if own.units[index]:
        text = f'{what}: the file says that "{own.names[index]}" is in {own.units[index]}, the project that it is raw '
        raise UserError(Problem(f"{text}counts; leave `counts` out", own.name))
    return TURN / (column.counts * column.gear_ratio)


def of_command(own: Channels, index: int, column: JointColumn, stated: InputColumn | None) -> JointColumn:
    """The unit, counts and gear of a command: the file's, or stated for it, else those of the angle."""
    unit, counts, gear = column.unit, column.counts, column.gear_ratio
    if stated is not None and (stated.unit is not None or stated.counts is not None):
        unit, counts = stated.unit, stated.counts
    elif own.units[index]:
        unit, counts = None, None
    if stated is not None and stated.gear_ratio is not None:
        gear = stated.gear_ratio
    return JointColumn(own.names[index], unit, counts=counts, gear_ratio=gear)


def speed_scale(own: Channels, index: int, column: JointColumn) -> float | None:
    """The joint's speed in rad/s of one number of a channel; None if its unit is not stated.

    Raises
    ------
    UserError : its unit is none of a speed.
    """
    if own.units[index]:
        return factor(own.units[index], "rad/s") / column.gear_ratio
    if column.counts is not None and PER_SECOND.search(own.names[index]):
        return TURN / (column.counts * column.gear_ratio)
    return None


def without_overflow(values: Array, column: JointColumn, what: str, notes: list[str]) -> Array:
    """Numbers (n,), nan where missing, of a counter that ran over its end, continued; others as they are.

    A reading of 32 bits is signed, so that 4294967295 is -1. An encoder that begins anew at each of its turns jumps by
    whole turns of the joint, which ``clean_angles`` removes; behind a gear it does not, and is continued here.
    """
    known = np.flatnonzero(np.isfinite(values))
    if column.counts is None or not len(known):
        return values
    given = values[known]
    if given.min() >= -WORD / 2 and WORD / 2 <= given.max() < WORD:
        given = np.where(given >= WORD / 2, given - WORD, given)
        notes.append(f"{what}: numbers from 2147483648 on are negative ones of 32 bits")
    geared = column.gear_ratio != 1.0
    within_turn = given.min() >= 0.0 and given.max() < column.counts
    for size in (*((float(column.counts),) if geared else ()), TIMER, WORD) if geared or not within_turn else ():
        inside = given.min() >= -size / 2 and given.max() < size and np.ptp(given) < size
        jumps = int((np.abs(np.diff(given)) > size / 2).sum())
        if inside and jumps:
            given = np.unwrap(given, period=size)
            notes.append(f"{what}: its counts begin anew after {size:.0f}; continued at {jumps} of its samples")
            break
    result = values.copy()
    result[known] = given
    return result
