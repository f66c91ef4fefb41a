"""Clocks that count from a distant moment: Unix time in s, ms, us or ns, a machine's uptime.

Their times have more digits than a result is written with, and as Unix seconds more than a double holds (it steps by
2.4e-7 s). They are counted from the first sample where they are read, before the digits are lost.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from typing import Any

import numpy as np

from synth.arrays import Array

LARGE = 1e4  # s, nearly three hours: ten digits, as results have, hold the microsecond of stamps below it
Numbers = Callable[[], Sequence[Any]]


@dataclass(frozen=True, eq=False)
class LogClock:
    """Times (n,) s of the samples, and ``begins`` s, the file's own time at their 0; 0 where the clock is kept."""

    time: Array
    begins: float = 0.0

    @property
    def notes(self) -> tuple[str, ...]:
        """The message on a clock that is set to 0."""
        return (begins_at(self.begins),) if self.begins else ()


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
    left = values - values[known[0]]
    if numbers is not None:
        exact = numbers()
        left[known] = [float(exact[k] - exact[known[0]]) for k in known]
    return LogClock(left * scale, float(values[known[0]] * scale))


def exact_number(cell: str) -> Decimal | None:
    """A cell's number with all its digits; None for a cell without one."""
    try:
        return Decimal(cell.strip())
    except InvalidOperation:
        return None
