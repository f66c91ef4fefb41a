"""Spellings of quantities: numbers with fractions, and units with hyphens, without signs, in vendors' plurals.

Everything is converted to the one spelling of ``synth.units``. Nothing is guessed: an ambiguous text
is refused with both possible spellings.
"""

from __future__ import annotations

import re

_NUMBER = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d{1,3})?")
# 1/2, 1 1/4, 1-1/4: inch sizes. Whole numbers only, so that 1.5/2 stays a mistake.
_FRACTION = re.compile(r"([+-]?)(?:(\d{1,6})[ -])?(\d{1,6})/(\d{1,6})(?![\d./,])")
_EUROPEAN = re.compile(r"([+-]?\d{1,3}(?:\.\d{3})+),(\d+)(?=\D|$)")  # 1.234,5
_DECIMAL_COMMA = re.compile(r"([+-]?\d*),(\d+)(?=\D|$)")
_THOUSANDS = re.compile(r"[+-]?[1-9]\d{0,2}(?:,\d{3})+(?:\.\d+)?(?=[^\d,.]|$)")
_SIGNS = str.maketrans(
    {"·": "*", "⋅": "*", "×": "*", "−": "-", "‐": "-", "‑": "-", "–": "-", "Ω": "Ω", "⁄": "/", "\u00a0": " ", "º": "°"}
)
_VULGAR = {"½": "1/2", "¼": "1/4", "¾": "3/4", "⅛": "1/8", "⅜": "3/8", "⅝": "5/8", "⅞": "7/8"}
_SUPERSCRIPTS = {"²": "^2", "³": "^3", "°": "deg", "%": "percent"}
# Vendors' words for a unit; pint's own plurals of full names (metres, degrees) need no line.
_WORDS = {
    "lbs": "lb", "ozs": "oz", "pound": "lb", "pounds": "lb", "ounce": "oz", "ounces": "oz", "inch": "in",
    "inches": "in", "foot": "ft", "feet": "ft", "Deg": "deg", "RPM": "rpm", "fps": "Hz", "FPS": "Hz", "radians": "rad",
    "inlb": "in*lbf", "inlbs": "in*lbf", "ftlb": "ft*lbf", "ftlbs": "ft*lbf", "ozin": "ozf*in", "inoz": "in*ozf",
}  # fmt: skip
# Servos' torques in kgcm and gcm, rotors' inertias in gcm² and kgm²: with a squared length the mass is a mass.
_RUN_TOGETHER = re.compile(r"(?<![A-Za-z])(kg|g)(mm|cm|m)(\^?2)?(?![A-Za-z0-9^*])")
_ABBREVIATED = re.compile(r"(?<=[A-Za-z])\.(?=\s*-|\s*$)")  # in.-lb, 0.5 in.
_WORD = re.compile(r"[A-Za-z]+")
# Newton, metre and second without separators, as in data sheets: Nm, mNm, Nmm, Nms, Ns, Ncm.
_NEWTON = re.compile(r"(?<![A-Za-z])([mkcuµμ]?N)(mm|cm|m)?(s)?(?![A-Za-z])")
# Between hyphens or dots a pound, ounce, kilogram or gram beside a plain length is a weight (in-lb, oz-in, kg-cm);
# beside a squared length it is a mass (lb-in^2). NIST SP 811 (2008), B.8, lists the inch-pound so.
_LENGTH, _MASS, _JOIN = r"(?:in|ft|mm|cm|m)", r"(lb|oz|kg|g)", r"\s*[-.]\s*"
_WEIGHT_FIRST = re.compile(rf"(?<![A-Za-z*]){_MASS}(?={_JOIN}{_LENGTH}(?![A-Za-z0-9^*]|\s*\*\*))")
_WEIGHT_LAST = re.compile(rf"(?<![A-Za-z])({_LENGTH}{_JOIN}){_MASS}(?![A-Za-z])")
_HYPHEN = re.compile(r"(?<=[A-Za-z0-9)])\s*[-.]\s*(?=[A-Za-z(])")
_INCH_MARK = re.compile(r"^\s*(?:\"|″|'')")


def plain_signs(text: str) -> str:
    """Text with a single sign for product, minus, fraction and degree."""
    plain = text.strip().translate(_SIGNS)
    for sign, meant in _VULGAR.items() if not plain.isascii() else ():
        plain = re.sub(rf"(?<=\d)\s*{sign}", f" {meant}", plain).replace(sign, meant)
    return plain


def read_number(text: str) -> tuple[float, str] | None:
    """A number at the start of a text, decimal or with a fraction, and the rest; None if there is none.

    ``1/2 in`` and ``1 1/4 in`` are halves and quarters; in ``5 1/s`` the number is 5, because its slash belongs to
    the unit.
    """
    fraction = _FRACTION.match(text)
    if fraction is not None:
        sign, whole, above, below = fraction.groups()
        if int(below) == 0:
            return None
        value = int(whole or 0) + int(above) / int(below)
        return (-value if sign == "-" else value), text[fraction.end() :]
    number = _NUMBER.match(text)
    if number is None or text[number.end() : number.end() + 1] in set(".,0123456789"):
        return None
    return float(number.group()), text[number.end() :]


def comma_mend(text: str) -> str:
    """``; write ...`` for a number with a comma, with both readings if ambiguous; empty without a comma."""
    thousands = _THOUSANDS.match(text)
    decimal = _DECIMAL_COMMA.match(text)
    european = _EUROPEAN.match(text)
    if european is not None and "," not in text[european.end() :]:
        return f"; write {european.group(1).replace('.', '')}.{european.group(2)}{text[european.end() :]}"
    if thousands is not None:
        without = text.replace(",", "")
        if text.count(",") > 1 or "." in thousands.group():
            return f"; leave the commas out: {without}"
        pointed = text.replace(",", ".")
        return f"; commas are not accepted: write {without} if it separates thousands, {pointed} if decimals"
    if decimal is not None and "," not in text[decimal.end() :]:
        whole = decimal.group(1)
        return f"; decimals take a point, not a comma: write {whole or '0'}.{decimal.group(2)}{text[decimal.end() :]}"
    return ""


def plain_unit(text: str) -> str:
    """A unit in the registry's spelling: ``Nm/rad`` is ``N*m/rad``, ``in-lb`` is ``in*lbf``."""
    plain = _INCH_MARK.sub("in", plain_signs(text))
    for written, meant in _SUPERSCRIPTS.items():
        plain = plain.replace(written, meant)
    if not any(sign in plain for sign in "-.NsSehDRlgz"):  # most units need none of the following
        return plain
    plain = _ABBREVIATED.sub("", plain)
    plain = _RUN_TOGETHER.sub(
        lambda found: "*".join((found[1] + ("" if found[3] else "f"), found[2] + (found[3] or ""))), plain
    )
    plain = _WORD.sub(lambda found: _WORDS.get(found[0], found[0]), plain)
    plain = _NEWTON.sub(lambda found: "*".join(part for part in found.groups() if part), plain)
    plain = _WEIGHT_FIRST.sub(r"\1f", plain)
    plain = _WEIGHT_LAST.sub(r"\1\2f", plain)
    return _HYPHEN.sub("*", plain)
