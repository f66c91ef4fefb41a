"""Formatting of numbers: as many digits as the interval justifies, units as text."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

from synth.reports.reading import unit_of, value_of

WIDE_INTERVAL = 10.0  # ratio of an interval's ends from which each is rounded by itself
WIDE_DIGITS = 2  # significant, of the value and the ends of such an interval
DIGITS = 4  # significant digits of a number without an interval
_UNITS = {"deg": "°", "deg/s": "°/s", "1": "", "percent": "%", "degC": "°C", "ohm": "Ω"}
_IN_PROSE = (
    (re.compile(r"(?<=[A-Za-z])\*(?=[A-Za-z])"), "·"),  # of units; a product of numbers has spaces
    (re.compile(r"(?<=[a-z])\^2\b"), "²"),
    (re.compile(r"(?<=\d) deg\b"), "°"),
    (re.compile(r"(?<=\d) degC\b"), "\u00a0°C"),
    (re.compile(r"(?<=\d) %"), "\u00a0%"),
)
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

# Factors to SI of the units that figures convert to a common axis.
_LENGTHS = {"m": 1.0, "cm": 0.01, "mm": 1e-3}
_SI_OF_UNIT = {"rad/s": 1.0, "deg/s": math.pi / 180, "rpm": math.pi / 30, "Hz": math.tau}
_SI_OF_UNIT |= {"N*m": 1.0, "mN*m": 1e-3, "N*m*s/rad": 1.0, "N*m*s/deg": 180 / math.pi, "N*m/rpm": 30 / math.pi}
_SI_OF_UNIT |= {"rad": 1.0, "deg": math.pi / 180, "mm": 1e-3, "m": 1.0, "in": 0.0254, "N*m/rad": 1.0, "1": 1.0}
_SI_OF_UNIT |= {"in*lbf": 0.112984829, "in*lbf/rad": 0.112984829}  # 0.0254 m times 4.4482216 N
_SI_OF_UNIT |= {"N*m*s^2/rad^2": 1.0, "1/rad": 1.0}
_SI_OF_UNIT |= {"N*m/deg": 180 / math.pi, "N*mm/rad": 1e-3, "percent": 0.01, "s": 1.0, "ms": 1e-3}


def in_si(quantity: object) -> float | None:
    """A quantity in SI and radians; None if it has no value or a unit that figures do not use."""
    value, factor = value_of(quantity), _SI_OF_UNIT.get(unit_of(quantity))
    return None if value is None or factor is None else value * factor


def in_length_unit(quantity: object, unit: str) -> object:
    """A length and its interval in another unit of length; anything else as it is."""
    ratio = _LENGTHS.get(unit_of(quantity), 0.0) / _LENGTHS[unit]
    value, interval = value_of(quantity), interval_of(quantity)
    if not ratio or value is None or not isinstance(quantity, Mapping):
        return quantity
    moved = {**quantity, "value": ratio * value, "unit": unit}
    if interval is not None:
        moved["interval90"] = [None if end is None else ratio * end for end in interval]
    return moved


def factor(unit: str) -> float | None:
    """Factor from ``unit`` to SI; None for a unit that figures do not use."""
    return _SI_OF_UNIT.get(unit)


def unit_text(unit: str) -> str:
    """``N*m*s/rad`` as ``N·m·s/rad``, ``deg`` as ``°``, ``1`` as nothing."""
    if unit in _UNITS:
        return _UNITS[unit]
    return unit.replace("*", "·").replace("^2", "²").replace("^3", "³")


def prose(words: str) -> str:
    """A sentence with units as the page's numbers have them: ``2 N*m`` as ``2 N·m``, ``3 deg`` as ``3°``, ``89 %``."""
    for plain, set_ in _IN_PROSE:
        words = plain.sub(set_, words)
    return words


def number(value: float | None, digits: int = DIGITS, *, bare: bool = True) -> str:
    """A number with ``digits`` significant digits, ``bare`` without trailing zeros; a dash for None."""
    shorten = _without_zeros if bare else str
    if value is None or not math.isfinite(value):
        return "–"
    if value == 0.0:
        return "0"
    exponent = int(f"{value:.{digits - 1}e}".split("e")[1])  # of the rounded value: 0.009999 is 0.01
    if not -4 <= exponent < 6:
        mantissa, power = f"{value:.{digits - 1}e}".split("e")
        return f"{_minus(shorten(mantissa))}·10{str(int(power)).translate(_RAISED)}"
    return _minus(shorten(f"{value:.{max(0, digits - 1 - exponent)}f}"))


def with_decimals(value: float | None, decimals: int | None) -> str:
    """A number with ``decimals`` decimals; as ``number`` formats it if they are None."""
    if value is None or decimals is None:
        return number(value)
    text = _minus(f"{round(value, decimals):.{max(0, decimals)}f}")
    return text[1:] if text.startswith("−") and not text.strip("−0.") else text


def decimals_of(quantity: object) -> int | None:
    """Decimals justified by the 90 % interval: two digits of its half width, or of the distance to its only end.

    Negative: so many digits before the point are not known. None: as ``number`` formats it.
    """
    half, value = _half_width(quantity), value_of(quantity)
    if value is None or not half > 0.0 or not -4 <= math.floor(math.log10(max(abs(value), half))) < 6:
        return None
    wanted = 1 - math.floor(math.log10(half))
    most = 5 - math.floor(math.log10(max(abs(value), half)))  # never more than six digits
    return min(wanted, most)


def _half_width(quantity: object) -> float:
    """Half the width of the 90 % interval, or the distance to its only end; 0 without one."""
    interval, value = interval_of(quantity), value_of(quantity)
    if interval is None or value is None:
        return 0.0
    low, high = interval
    if low is not None and high is not None:
        return (high - low) / 2
    end = high if low is None else low
    return 0.0 if end is None else abs(value - end)


def interval_of(quantity: object) -> tuple[float | None, float | None] | None:
    """The two ends of the 90 % interval, None for an open end; None without an interval."""
    interval = quantity.get("interval90") if isinstance(quantity, Mapping) else None
    if not isinstance(interval, (list, tuple)) or len(interval) != 2:
        return None
    return interval[0], interval[1]


def is_wide(quantity: object) -> bool:
    """Whether the interval's ends, or the value and the only end, differ by more than ``WIDE_INTERVAL`` times.

    Such numbers are rounded by themselves: a rate of 0.12 from 0.0003 to 43 would be "0" and start at "0".
    """
    interval = interval_of(quantity)
    if interval is None:
        return False
    known = [end for end in interval if end is not None]
    sizes = sorted(abs(end) for end in (known if len(known) == 2 else [*known, value_of(quantity) or 0.0]))
    one_sense = all(end > 0.0 for end in known) or all(end < 0.0 for end in known)
    return not known or (one_sense and sizes[-1] > WIDE_INTERVAL * sizes[0] > 0.0)


def _as_known(value: float | None, quantity: object) -> str:
    """The value of a quantity, or an end of its interval, in as many digits as the interval justifies."""
    if value == 0.0:
        return "0"
    if is_wide(quantity):
        return number(value, WIDE_DIGITS, bare=False)
    decimals, half = decimals_of(quantity), _half_width(quantity)
    if decimals is None and value and half > 0.0:  # very small or large: as many digits of the power's factor
        known = math.floor(math.log10(abs(value))) - math.floor(math.log10(half)) + 2
        return number(value, max(1, min(known, 6)), bare=False)
    return with_decimals(value, decimals)


def value_text(quantity: object) -> str:
    """The number alone."""
    return _as_known(value_of(quantity), quantity)


def is_any_angle(quantity: object) -> bool:
    """Whether it is an angle whose interval spans a full turn, as the free angle of a spring that may not be there."""
    interval = interval_of(quantity)
    if interval is None or unit_of(quantity) != "deg":
        return False
    low, high = interval
    return low is not None and high is not None and high - low >= 360.0


def interval_text(quantity: object) -> str:
    """``9.71 to 10.11``, ``above 9.71``; empty without an interval."""
    interval = interval_of(quantity)
    if interval is None or is_any_angle(quantity):
        return ""
    low, high = (_as_known(end, quantity) for end in interval)
    if interval[0] is None and interval[1] is None:
        return "unknown"
    if interval[0] is None:
        return f"below {high}"
    return f"above {low}" if interval[1] is None else f"{low} to {high}"


def text(quantity: object) -> str:
    """``1.71 N·m/rad`` with a no-break space, ``12°`` without a space, ``unknown`` for any angle."""
    return "unknown" if is_any_angle(quantity) else with_unit(value_text(quantity), quantity)


def brief(quantity: object) -> str:
    """``text`` with three digits and trailing zeros, for columns of errors and characteristics."""
    return with_unit(number(value_of(quantity), 3, bare=False), quantity)


def signed(quantity: object) -> str:
    """With its sign and two decimals, for costs and gains."""
    value = value_of(quantity)
    shown = with_decimals(value, 2)
    return ("+" if value is not None and not shown.startswith("−") else "") + with_unit(shown, quantity)


def with_unit(shown: str, quantity: object) -> str:
    """``shown`` with the quantity's unit."""
    if value_of(quantity) is None:
        return "–"
    unit = unit_text(unit_of(quantity))
    close = unit == "" or (unit == "°" and "·10" not in shown)  # a degree sign after an exponent would be read as 0
    return shown + (unit if close else f"\u00a0{unit}")


def percent(part: float | None, whole: float | None) -> str:
    """Relative difference of ``part`` from ``whole``, ``+4.9 %``; a dash if either is missing or ``whole`` is 0."""
    if part is None or not whole:
        return "–"
    share = 100.0 * (part / whole - 1.0)
    decimals = 1 if abs(share) < 10 else 0
    shown = f"{abs(share):.{decimals}f}\u00a0%"
    if not shown.strip("0.\u00a0%"):
        return "0\u00a0%"
    return ("+" if share > 0 else "−") + shown


def share_text(quantity: object) -> str:
    """A probability in whole per cent, ``83 %``; ``under 1 %`` or ``over 99 %`` instead of a rounded 0 or 100."""
    value = value_of(quantity) if isinstance(quantity, Mapping) else quantity
    if isinstance(value, (int, float)) and 0.0 <= value < 0.005:  # would round to 0 %
        return "under 1\u00a0%"
    if isinstance(value, (int, float)) and 0.995 <= value < 1.0:  # would round to 100 %
        return "over 99\u00a0%"
    return whole_percent(value)


def whole_percent(quantity: object) -> str:
    """A share in whole per cent, ``83 %``, ``−12 %``; a dash for none."""
    value = value_of(quantity) if isinstance(quantity, Mapping) else quantity
    if not isinstance(value, (int, float)) or not math.isfinite(value):
        return "–"
    return f"{_minus(f'{round(100.0 * value):d}')}\u00a0%"


def percent_interval(quantity: object) -> str:
    """``78 % to 88 %``; empty without an interval."""
    interval = interval_of(quantity)
    return "" if interval is None else " to ".join(whole_percent(end) for end in interval)


def _without_zeros(written: str) -> str:
    """Without trailing zeros of the decimals, which would suggest a higher accuracy."""
    return written.rstrip("0").rstrip(".") if "." in written else written


def _minus(written: str) -> str:
    return written.replace("-", "−")
