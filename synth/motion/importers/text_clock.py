"""Clocks that are written as text: a date with a time, or a time of day, in seconds.

A date with its year first (ISO 8601) counts from 1970, UTC where no zone is written: only differences are used. Other
dates do not tell which number is the day, so they count as their times of day. These count from midnight, and go on
past it. Digits are kept exactly. A time that a spreadsheet has cut to minutes and seconds (``59:59.5``) is taken so.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import UTC, datetime, timedelta
from decimal import Decimal

DATE = re.compile(
    r"(\d{4}[-/]\d{1,2}[-/]\d{1,2})[T ](\d{1,2}:\d{2}:\d{2})(?:[.,](\d{1,12}))?\s?(Z|[+-]\d{2}:?\d{2})?", re.ASCII
)
# Day first or month first, and half a day as AM or PM: 03/05/2024 11:59:59.5 PM
TIME_OF_DAY = re.compile(
    r"(?:\d{1,2}[-/.]\d{1,2}[-/.]\d{2,4},?\s)?\s*(?:(\d{1,2}):)?(\d{1,2}):(\d{2})(?:[.,](\d{1,12}))?\s?([AaPp][Mm])?",
    re.ASCII,
)
DATE_WORDS, TIME_WORDS = "dates with times", "times of day"
DAY, HOUR = 86_400, 3_600  # s, after which the two kinds of times begin again


def text_clock(cells: Sequence[str]) -> tuple[list[str], str] | None:
    """The cells of a clock in seconds, as decimals, and what they are in a message; None if they are no such clock.

    Empty cells stay. Any other cell that is not of the kind of the first makes the column no clock.
    """
    places = [k for k, cell in enumerate(cells) if cell.strip()]
    filled = [cells[k].strip() for k in places]
    if not filled:
        return None
    words = TIME_WORDS if _of_date(filled[0]) is None else DATE_WORDS
    found = [_of_day(cell) if words == TIME_WORDS else _of_date(cell) for cell in filled]
    times = [each for each in found if each is not None]
    if len(times) < len(found):
        return None
    if words == TIME_WORDS:
        with_hours = any(_hours(cell) for cell in filled)
        times, turns = _continued(times, DAY if with_hours else HOUR)
        words += f", continued past {'midnight' if with_hours else 'the hour'}" if turns else ""
    made = [""] * len(cells)
    for k, time in zip(places, times, strict=True):
        made[k] = str(time)
    return made, words


def _of_date(text: str) -> Decimal | None:
    match = DATE.fullmatch(text)
    if match is None:
        return None
    day, time, fraction, zone = match.groups()
    offset = "+00:00" if zone in (None, "Z") else zone
    try:
        at = datetime.strptime(f"{day.replace('/', '-')} {time} {offset}", "%Y-%m-%d %H:%M:%S %z")
    except ValueError:
        return None  # the 31st of a shorter month, 25 o'clock
    return _seconds((at - datetime(1970, 1, 1, tzinfo=UTC)) // timedelta(seconds=1), fraction)


def _of_day(text: str) -> Decimal | None:
    match = TIME_OF_DAY.fullmatch(text)
    if match is None:
        return None
    hours, minutes, seconds, fraction, half = match.groups()
    if int(minutes) > 59 or int(seconds) > 59 or (hours is None and (fraction is None or half)):
        return None  # 11:59 alone may be hours and minutes
    hour = int(hours or 0)
    if hour > 23 or (half and not 1 <= hour <= 12):
        return None
    if half:
        hour = hour % 12 + (12 if half.casefold() == "pm" else 0)
    return _seconds(3600 * hour + 60 * int(minutes) + int(seconds), fraction)


def _hours(text: str) -> bool:
    match = TIME_OF_DAY.fullmatch(text)
    return match is not None and match[1] is not None


def _continued(times: Sequence[Decimal], period: int) -> tuple[list[Decimal], int]:
    """Times that begin again after ``period`` s, continued over each fall by more than half of it, and their number."""
    made, turns = list(times), 0
    for k in range(1, len(made)):
        turns += times[k - 1] - times[k] > period / 2
        made[k] = times[k] + turns * period
    return made, turns


def _seconds(whole: int, fraction: str | None) -> Decimal:
    return Decimal(whole) + Decimal(f"0.{fraction or 0}")
