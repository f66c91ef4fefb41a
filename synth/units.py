"""Conversion between text with units and SI numbers.

Angle is a dimension of its own here, unlike in pint's default registry. There ``N*m`` is accepted for a rate in
``N*m/rad`` and ``5 Hz`` for 5 rad/s, which is how degrees and turns get lost. The short list of units below
also loads in 5 ms, where pint's own takes 200 ms.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Any, cast

from synth.errors import UserError, did_you_mean
from synth.units_often import OFTEN
from synth.units_spelling import comma_mend, plain_signs, plain_unit, read_number

if TYPE_CHECKING:
    import pint

# Factors: NIST SP 811 (2008), appendix B; exact by definition except where a constant is rounded there.
DEFINITIONS = """
giga- = 1e9 = G-
mega- = 1e6 = M-
kilo- = 1e3 = k-
deci- = 1e-1 = d-
centi- = 1e-2 = c-
milli- = 1e-3 = m-
micro- = 1e-6 = µ- = μ- = u-
nano- = 1e-9 = n-
metre = [length] = m = meter
gram = [mass] = g
second = [time] = s = sec
radian = [angle] = rad
ampere = [current] = A = amp
kelvin = [temperature] = K
bit = [information]
degree = 3.141592653589793 / 180 * radian = deg = degrees
turn = 2 * 3.141592653589793 * radian = _ = revolution = rev
arcminute = degree / 60 = arcmin
arcsecond = degree / 3600 = arcsec
minute = 60 * second = min
hour = 3600 * second = h = hr
hertz = 1 / second = Hz
revolutions_per_minute = turn / minute = rpm
percent = 0.01 = _
inch = 0.0254 * metre = in
foot = 0.3048 * metre = ft
thou = 2.54e-5 * metre = mil
tonne = 1e6 * gram = t
pound = 453.59237 * gram = lb = lbm
ounce = pound / 16 = oz
standard_gravity = 9.80665 * metre / second ** 2 = g_0 = g0
newton = 1e3 * gram * metre / second ** 2 = N
gram_force = gram * standard_gravity = gf
pound_force = pound * standard_gravity = lbf
ounce_force = ounce * standard_gravity = ozf
pascal = newton / metre ** 2 = Pa
bar = 1e5 * pascal
pound_per_square_inch = pound_force / inch ** 2 = psi
kilopound_force = 1e3 * pound_force = kip
kilopound_per_square_inch = 1e3 * pound_per_square_inch = ksi
megapound_per_square_inch = 1e6 * pound_per_square_inch = Msi
joule = newton * metre = J
watt = joule / second = W
volt = watt / ampere = V
ohm = volt / ampere = Ω
henry = volt * second / ampere = H
litre = 1e-3 * metre ** 3 = L = liter
poise = 0.1 * pascal * second = P
stokes = 1e-4 * metre ** 2 / second = St
"""

# What a canonical unit measures, in words, and how a value of it is commonly written.
MEANINGS: dict[str, tuple[str, str]] = {
    "m": ("length", "200 mm"),
    "kg": ("mass", "740 g"),
    "s": ("time", "0.5 s"),
    "rad": ("angle", "90 deg"),
    "rad/s": ("angular speed", "50 rpm"),
    "rad/s^2": ("angular acceleration", "3 rad/s^2"),
    "m/s": ("speed", "0.1 m/s"),
    "m/s^2": ("acceleration", "9.81 m/s^2"),
    "kg*m^2": ("moment of inertia", "3.5e-3 kg*m^2"),
    "N": ("force", "10 N"),
    "N*m": ("torque", "0.05 N*m"),
    "N*m/rad": ("torsional spring rate", "23.7 N*m/rad"),
    "N*m*s/rad": ("torsional damper rate", "1.29 N*m*s/rad"),
    "N*m*s^2/rad^2": ("torsional quadratic drag", "0.01 N*m*s^2/rad^2"),
    "N*m/rad^3": ("cubic torsional rate", "5 N*m/rad^3"),
    "N/m": ("stiffness", "1200 N/m"),
    "N*s/m": ("damping", "3 N*s/m"),
    "Pa": ("pressure or stress", "1800 MPa"),
    "kg/m^3": ("density", "1820 kg/m^3"),
    "s/m": ("time per length", "5 s/m"),
    "s/rad": ("time per angle", "0.5 s/rad"),
    "J": ("energy", "2 J"),
    "W": ("power", "20 W"),
    "V": ("voltage", "12 V"),
    "A": ("current", "1.5 A"),
    "ohm": ("resistance", "2 ohm"),
    "H": ("inductance", "1 mH"),
    "Hz": ("frequency", "10 Hz"),
    "K": ("temperature difference", "5 K"),
    "N*m/A": ("torque constant", "0.02 N*m/A"),
    "1/rad": ("gain", "2 1/rad"),
    "1": ("ratio", "5 %"),
}

PLAIN_BELOW = 1e6  # numbers in sentences have no power of ten below it, as on the pages
TEXT_LIMIT = 100  # characters of a quantity; real ones are far shorter
# A product of names with one-digit powers, which pint can always evaluate safely. Matched token by token,
# because a single pattern for the whole text backtracks exponentially on a long word.
_GRAD = re.compile(r"(?<![a-z])grad(?![a-z])", re.IGNORECASE)  # a degree in German; pint reads Grad as giga-radian
_TOKEN = re.compile(r"[A-Za-zµμΩ_]+0?(?: ?(?:\*\*|\^)-?[1-9](?!\d))?|1(?=\s*/)|\*(?!\*)|[()/ ]")
_HEADER = re.compile(r"\s*([^\[\]]*?)\s*\[([^\[\]]*)\]\s*")


@dataclass(frozen=True)
class _Unit:
    """A unit's size in coherent SI units and its dimension as sorted (name, power)."""

    factor: float
    dimension: tuple[tuple[str, float], ...]


def parse(text: object, unit: str) -> float:
    """Read a quantity such as ``200 mm`` and return it in ``unit``.

    Parameters
    ----------
    text
        the user's text; a bare number is accepted only where ``unit`` is ``"1"``.
    unit
        the canonical unit wanted, for example ``m``, ``N*m/rad``, ``1``.

    Raises
    ------
    UserError
        If there is no unit, an unknown unit, another dimension, or a number that is not finite.
    """
    if text is None:
        raise UserError(f"has no value: write it like {_example(unit)}")
    if isinstance(text, bool) or not isinstance(text, (str, int, float)):
        raise UserError(f"{_shown(text)} is not a quantity; write it like {_example(unit)}")
    written = plain_signs(str(text))
    if len(written) > TEXT_LIMIT:
        raise UserError(f"{_shown(written)} is too long for a quantity; write it like {_example(unit)}")
    number = read_number(written)
    if number is None:
        mend = comma_mend(written) or f"; write it like {_example(unit)}"
        raise UserError(f"{_shown(text)} is not a number with a unit{mend}")
    value = number[0]
    if not math.isfinite(value):
        raise UserError(f"{_shown(text)} is too large a number")
    rest = number[1].strip()
    wanted = _unit(unit)
    if not rest:
        if not wanted.dimension:
            return value / wanted.factor
        raise UserError(f"{_shown(text)} has no unit: write it like {_example(unit)} ({_meaning(unit)})")
    found = _unit(rest)
    if found.dimension != wanted.dimension:
        raise UserError(
            f"{_shown(text)} is {_article(_meaning(rest))}, where {_article(_meaning(unit))} is needed, "
            f"such as {_example(unit)}{_near_dimension(rest, wanted)}"
        )
    result = value * found.factor / wanted.factor
    if not math.isfinite(result):
        raise UserError(f"{_shown(text)} is too large a number")
    return result


def factor(unit: str, canonical: str) -> float:
    """Number of ``canonical`` in one ``unit``: ``factor("deg", "rad") == pi / 180``.

    Raises
    ------
    UserError
        If either is unknown or the dimensions differ.
    """
    found, wanted = _unit(unit), _unit(canonical)
    if found.dimension != wanted.dimension:
        raise UserError(
            f"[{unit}] is the unit of {_article(_meaning(unit))}, where that of {_article(_meaning(canonical))} "
            f"is needed, such as [{_example(canonical).split(' ', 1)[1]}]{_near_dimension(unit, wanted)}"
        )
    return found.factor / wanted.factor


def header(text: str) -> tuple[str, str]:
    """Split a CSV header ``name [unit]`` into name and unit; the unit is not checked.

    Raises
    ------
    UserError
        If there is no unit in square brackets.
    """
    match = _HEADER.fullmatch(text) if len(text) <= 4 * TEXT_LIMIT else None
    if match is None or not match.group(1):
        raise UserError(f"column {_shown(text)} has no unit: write the header as name [unit], such as hip [deg]")
    name, unit = match.groups()
    if not unit.strip():
        raise UserError(f"column {_shown(text)} has empty brackets: write its unit there, such as {name} [deg]")
    return name, unit.strip()


def quantity(value: float, unit: str, interval90: Sequence[float] | None = None) -> dict[str, Any]:
    """Build ``{"value", "unit", "interval90"}`` for a result file.

    Parameters
    ----------
    value
        in coherent SI units (radians for angles).
    unit
        the unit for display, for example ``deg``.
    interval90
        the two ends of the 90 % interval, SI; an unbounded end (``inf``) becomes ``None``.
        Left out of the result when None.

    Raises
    ------
    ValueError
        If the value is not finite or an end is NaN: such a number must not reach a result file.
    """
    scale = _unit(unit).factor
    if not math.isfinite(value):
        raise ValueError(f"a quantity in {unit} is {value}")
    shown: dict[str, Any] = {"value": float(value) / scale, "unit": unit}
    if interval90 is not None:
        low, high = (float(end) for end in interval90)
        if math.isnan(low) or math.isnan(high):
            raise ValueError(f"an interval in {unit} is ({low}, {high})")
        shown["interval90"] = [end / scale if math.isfinite(end) else None for end in (low, high)]
    return shown


def shown_unit(unit: str) -> str:
    """The unit in which results write a parameter of this SI unit."""
    return {"rad": "deg", "rad/s": "deg/s", "H": "mH"}.get(unit, unit)


def si_unit(unit: str) -> str:
    """The coherent SI unit of a product of units: ``rad/s`` of ``deg/s``, ``m`` of ``cm``, ``1`` of ``%``."""

    def coherent(found: re.Match[str]) -> str:
        one = _unit(found[0])
        same = (name for name in MEANINGS if _unit(name).dimension == one.dimension)
        return found[0] if one.factor == 1.0 else next(same)

    return re.sub(r"[^\W\d_]+|%", coherent, unit)


def significant(value: float, digits: int) -> str:
    """A value in a sentence, with so many significant digits: 140, 1.4, 0.014; no power of ten below a million."""
    text = f"{value:.{digits}g}"
    return f"{float(text):.0f}" if "e+0" in text and abs(float(text)) < PLAIN_BELOW else text


def write(value: float, unit: str) -> str:
    """Write an SI value as a quantity in ``unit`` that ``parse`` reads back within 1e-14 relative."""
    if not math.isfinite(value):
        raise ValueError(f"a quantity in {unit} is {value}")
    number = format(value / _unit(unit).factor, ".15g")
    return f"{'0' if number == '-0' else number} {unit}"


@cache
def _registry() -> pint.UnitRegistry[Any]:
    """The only registry, created on first use (importing pint takes 0.15 s beside numpy)."""
    import pint

    registry: pint.UnitRegistry[Any] = pint.UnitRegistry(None, on_redefinition="raise")
    registry.load_definitions(DEFINITIONS.strip().splitlines())
    return registry


@lru_cache(maxsize=512)
def _unit(text: str) -> _Unit:
    """Size and dimension of a unit; only products of names with one-digit powers are accepted."""
    plain = plain_unit(text)
    if plain == "1":
        return _Unit(1.0, ())
    if plain in OFTEN:
        return _Unit(*OFTEN[plain])
    return _by_pint(plain, text)


def _by_pint(plain: str, text: str) -> _Unit:
    """Size and dimension according to pint; ``text`` as the user wrote it."""
    if len(plain) > TEXT_LIMIT or "".join(_TOKEN.findall(plain)) != plain:
        raise UserError(f"{_shown(text)} cannot be read as a unit; write it like N*m/rad or kg*m^2")
    if grad := _GRAD.search(plain):
        how = "write deg for degrees; a gradian is 0.9 deg"
        raise UserError(f"{_shown(grad[0])} in {_shown(text)} is not accepted as a unit: {how}")
    import pint

    registry = _registry()
    try:
        unit = registry.parse_units(plain)
        root, _ = registry.get_root_units(unit)
        powers = registry.get_dimensionality(unit)
        dimension = {str(name): float(cast(float, power)) for name, power in powers.items()}
    except pint.UndefinedUnitError as error:
        names = [error.unit_names] if isinstance(error.unit_names, str) else list(error.unit_names)
        raise UserError(f"unit {_shown(names[0])} in {_shown(text)} is not known{_near_units(names[0])}") from None
    except Exception as error:  # pint's own parser raises many kinds on a malformed product
        raise UserError(f"{_shown(text)} cannot be read as a unit; write it like N*m/rad or kg*m^2") from error
    # pint counts mass in grams, SI in kilograms.
    in_si = float(cast(float, root)) * 1e-3 ** dimension.get("[mass]", 0.0)
    return _Unit(in_si, tuple(sorted((name, power) for name, power in dimension.items() if power)))


def _near_units(name: str) -> str:
    names = ["mm", "cm", "m", "in", "ft", "kg", "g", "lb", "oz", "s", "ms", "min", "rad", "deg", "rpm", "N", "mN"]
    names += ["lbf", "ozf", "kgf", "Pa", "MPa", "GPa", "psi", "ksi", "Msi", "Hz", "J", "W", "V", "A", "ohm", "H"]
    names += ["percent", "rev"]
    lower = {known.lower(): known for known in reversed(names)}
    if name.lower() in lower:
        return f"; did you mean {lower[name.lower()]}?"
    # A unit that begins otherwise has another prefix: what was meant would be a thousand times as much.
    return did_you_mean(name, [known for known in names if known[0].lower() == name[0].lower()])


def _near_dimension(written: str, wanted: _Unit) -> str:
    """The two most frequent mistakes: ``N*m`` for ``N*m/rad``, and ``oz*in`` for ``ozf*in``, written with ``*``."""
    if not wanted.dimension:
        return ""
    written = re.sub(r"(?<=\w) (?=\w)", "*", plain_unit(written).replace(" per ", "/"))
    forces = re.sub(r"\b(oz|lb|kg|g)s?\b", r"\1f", written)
    for candidate in (f"{written}/rad", forces, f"{forces}/rad"):
        try:
            if _unit(candidate).dimension == wanted.dimension:
                return f"; did you mean {candidate}?"
        except UserError:
            continue
    return ""


def _meaning(unit: str) -> str:
    """The name of what a unit measures, or the unit itself."""
    dimension = _unit(unit).dimension
    for canonical, (meaning, _) in MEANINGS.items():
        if _unit(canonical).dimension == dimension:
            return meaning
    return f"quantity in {unit}"


def _example(unit: str) -> str:
    dimension = _unit(unit).dimension
    for canonical, (_, example) in MEANINGS.items():
        if _unit(canonical).dimension == dimension:
            return example
    return f"1 {unit}"


def _article(words: str) -> str:
    return f"{'an' if words[0] in 'aeiou' else 'a'} {words}"


def _shown(value: object) -> str:
    """A value as the user wrote it, shortened if long."""
    text = value if isinstance(value, str) else repr(value)
    text = text if len(text) <= 40 else text[:37] + "..."  # letters: the message stays on one line
    return f'"{text}"' if isinstance(value, str) else text
