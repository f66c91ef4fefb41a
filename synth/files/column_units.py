"""Units of a foreign file's columns in an import project; an encoder's raw counts have none, but counts a turn.

How servos and motor drivers log a position: Dynamixel (registers 116 and 132) and Feetech (42 and 56) in counts of
4096 a turn of the output shaft, 2048 in its middle; ODrive (``pos_estimate``, ``input_pos``) in turns of the motor; a
microcontroller in the counts of its timer. Each is a unit or counts a turn, and a gear ratio if the encoder sits on
the motor's side.
"""

from __future__ import annotations

import re

from synth import units
from synth.errors import UserError
from synth.units_spelling import read_number

USUAL_COUNTS = 4096  # a turn, in examples: 12 bits, as Dynamixel's, Feetech's and most magnetic encoders have
NEARLY_WHOLE = 2e-3  # of a count a turn: 0.088 deg, as Dynamixel's manual rounds 360 deg / 4096, means 4096
_COUNTED = re.compile(r"(counts?|cts|cpr|ticks?|pulses?|steps?|lsb)\b", re.IGNORECASE)
_PART = re.compile(r"(turn|rev|revolution|360 ?deg)s? ?/ ?(\d{1,9})", re.IGNORECASE)


def column_factor(unit: str, canonical: str) -> float:
    """Number of ``canonical`` in one ``unit`` of a column.

    Raises
    ------
    UserError : an unknown unit, or one of something else; where an angle is needed it tells how counts are written.
    """
    try:
        return units.factor(unit, canonical)
    except UserError as error:
        if canonical != "rad":
            raise
        raise UserError(_of_an_angle(unit, error.problems[0].text)) from None


def _of_an_angle(unit: str, fault: str) -> str:
    """The message on a unit that is none of an angle: what is allowed, and how counts are written."""
    turn = _counts_a_turn(unit)
    if turn is None:
        return f"{fault}; an angle's unit is deg, rad or turn; {how_counts_are_written()}"
    such = f"its counts a turn, counts: {turn}" if turn else f"its counts a turn, such as counts: {USUAL_COUNTS}"
    return f'"{unit}" is no unit, but a count of an encoder: write {such}, instead of `unit`'


def how_counts_are_written() -> str:
    """What a project states of raw counts."""
    return f"raw counts of an encoder have counts: {USUAL_COUNTS} (a turn) instead of `unit`"


def _counts_a_turn(unit: str) -> int | None:
    """The counts a turn that ``turn/4096`` or ``0.088 deg`` means, 0 of a bare ``count``; None of any other unit."""
    part = _PART.fullmatch(unit.strip())
    if part is not None and int(part[2]):
        return int(part[2])
    if _COUNTED.match(unit.strip()):
        return 0
    number = read_number(unit.strip())
    if number is None or not number[0] > 0.0:
        return None
    try:
        turn = 1.0 / (number[0] * units.factor(number[1].strip(), "turn"))
    except UserError:
        return None
    bits = 1 << max(round(turn) - 1, 0).bit_length()
    near = [each for each in (bits, bits // 2) if abs(turn / each - 1.0) < NEARLY_WHOLE] if turn >= 2.0 else []
    return near[0] if near else round(turn) or None
