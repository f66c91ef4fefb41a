"""An estimate and its 90 % interval in words: rounded alike on the screen, in notes and in proposals."""

from __future__ import annotations

import math

from synth.units import significant

WIDE_INTERVAL = 10.0  # ratio of the ends from which each is rounded by itself, as on the pages
MOST_DECIMALS = 6  # of an estimate in a table
ALIKE = 3  # digits where the width does not tell how many
SMALL = 1e-3  # in the unit shown; a smaller value that needs more decimals is shown with a power of ten
OPEN_RATIO = 1e12  # of an interval's ends, beyond which they are no numbers: nothing determines the value


def estimate_words(value: float, low: float, high: float) -> tuple[str, str]:
    """A value and its interval, ``low`` to ``high`` above it; in any unit.

    Rounded to two digits of the half width; to two digits each if the interval is wide, to ``ALIKE`` if it has no width
    or an end is infinite.
    """
    if low > 0.0 and high > WIDE_INTERVAL * low:
        return significant(value, 2), f"{significant(low, 2)} to {significant(high, 2)}"
    half = (high - low) / 2
    if not 0.0 < half < math.inf:
        return significant(value, ALIKE), f"{significant(low, ALIKE)} to {significant(high, ALIKE)}"
    decimals = max(0, 1 - math.floor(math.log10(half)))
    if decimals > MOST_DECIMALS and abs(value) < SMALL:  # an insect's spring, 2e-7 N m/rad
        digits = max(0, decimals + math.floor(math.log10(max(abs(value), half))))
        return f"{value:.{digits}e}", f"{low:.{digits}e} to {high:.{digits}e}"
    decimals = min(MOST_DECIMALS, decimals)
    return f"{value:.{decimals}f}", f"{low:.{decimals}f} to {high:.{decimals}f}"


def interval_words(value: float, low: float, high: float, unit: str) -> str:
    """``0.064 to 0.76 N*m/rad``, as the table has it; ``anything`` where the ends are no numbers."""
    if low > 0.0 and high > OPEN_RATIO * low:
        return "anything"
    ends = estimate_words(value, low, high)[1]
    return ends if unit == "1" else f"{ends} {unit}"
