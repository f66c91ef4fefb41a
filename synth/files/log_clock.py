"""Clocks that count from a distant moment: Unix time in s, ms, us or ns, a machine's uptime.

Their times have more digits than a result is written with, and as Unix seconds more than a double holds (it steps by
2.4e-7 s). They are counted from the first sample where they are read, before the digits are lost. Where the file itself
holds doubles (MATLAB), that rounding is in it: steps that are even within it are taken as even.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from typing import Any

import numpy as np

from synth.arrays import Array

LARGE = 1e4  # s, nearly three hours: ten digits, as results have, hold the microsecond of stamps below it
TOLD = 1e-9  # s, grain from which it is worth a note: results hold times to that
LEAST_GRAINS = 10.0  # in the usual step, for the number of steps between two samples to be sure
WITHIN = 1.01  # of the grain: the range of rounded even times, half a grain to either side, and the arithmetic's own
MOST_DIGITS = 16  # of a step: a double's
Numbers = Callable[[], Sequence[Any]]


@dataclass(frozen=True, eq=False)
class LogClock:
    """Times (n,) s of the samples, and ``begins`` s, the file's own time at their 0; 0 where the clock is kept.

    ``grain`` s : to which the file's numbers round such a time, 0 where they hold it; ``even`` s : the step, where all
    steps are whole multiples of one within the grain.
    """

    time: Array
    begins: float = 0.0
    grain: float = 0.0
    even: float = 0.0

    @property
    def notes(self) -> tuple[str, ...]:
        """The messages on a clock that is set to 0, and on its rounding."""
        found = [begins_at(self.begins)] if self.begins else []
        if self.grain:
            text = f"the file's numbers hold such times to {self.grain:.2g} s only"
            even = f"; its steps are multiples of {self.even:.6g} s within that, and are taken as such"
            found.append(text + (even if self.even else ", so much of its unevenness may be rounding"))
        return tuple(found)


def begins_at(seconds: float) -> str:
    """The message on a clock that began at so many s and is set to 0."""
    return f"the clock begins at {seconds:.6f} s, set to 0"


def log_clock(values: Array, scale: float, numbers: Numbers | None = None) -> LogClock:
    """The clock of a column; a large one counts from its first sample.

    Parameters
    ----------
    values : (n,) of the file, nan where missing, in its unit of ``scale`` s.
    numbers : gives the same n values with all the file's digits, such as ``Decimal`` or ``int``.
    """
    known = np.flatnonzero(np.isfinite(values)).tolist()
    if not known or abs(values[known[0]]) * scale < LARGE:
        return LogClock(values * scale)
    left, exact = values - values[known[0]], None if numbers is None else numbers()
    if exact is not None:
        left[known] = [float(exact[k] - exact[known[0]]) for k in known]
    time, begins = left * scale, float(values[known[0]] * scale)
    if exact is not None and not isinstance(exact[known[0]], float):
        return LogClock(time, begins)
    grain = float(np.spacing(np.abs(values[known]).max())) * scale
    if grain <= TOLD:
        return LogClock(time, begins)
    even = _even_step(time, grain) if len(known) == len(values) else None
    return LogClock(time, begins, grain) if even is None else LogClock(even[0], begins, grain, even[1])


def _even_step(time: Array, grain: float) -> tuple[Array, float] | None:
    """The times as whole multiples of one step, and that step, s; None if they are none within ``grain`` s.

    The step is the roundest number with which they are.
    """
    steps = np.diff(time)
    usual = float(np.median(steps)) if len(steps) > 1 else 0.0
    if usual < LEAST_GRAINS * grain:
        return None
    count = np.concatenate([[0.0], np.cumsum(np.rint(steps / usual))])
    slope = float(np.polyfit(count, time, 1)[0])
    for digits in range(1, MOST_DIGITS):
        step = float(f"{slope:.{digits}g}")
        off = time - step * count
        if float(np.ptp(off)) <= WITHIN * grain:
            return step * count, step
    return None


def exact_number(cell: str) -> Decimal | None:
    """A cell's number with all its digits; None for a cell without one."""
    try:
        return Decimal(cell.strip())
    except InvalidOperation:
        return None
