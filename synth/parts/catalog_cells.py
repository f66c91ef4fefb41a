"""Cells of a catalogue's columns: units, allowed numbers, words. Texts of errors are the user's messages."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import Field
from difflib import get_close_matches
from typing import Any

from synth.errors import UserError
from synth.files.names import title_fault
from synth.parts.headers import standard_value
from synth.parts.price import currency_code, price
from synth.units import factor, header

TITLES = ("part", "vendor", "material")  # columns that lists of parts and pages show
ROUNDING = 1e-9  # relative, of converted units
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")


def scale_of(title: str, item: Field[Any]) -> float:
    """The factor from a column's unit to SI; ``title`` with the unit in brackets.

    Raises
    ------
    UserError : the unit is missing or wrong.
    """
    unit = item.metadata["unit"]
    if unit is None:
        if "[" in title and not item.metadata.get("currency"):
            raise UserError(f'"{title}" is a text column and has no unit')
        return 1.0
    if "[" not in title:
        raise UserError(f'column "{title}" has no unit: write it like {item.name} [{item.metadata["shown"]}]')
    written = header(title)[1]
    if unit == "degC":
        if written != "degC":
            raise UserError(f'"{written}" is not a temperature unit here; write {item.name} [degC]')
        return 1.0
    return factor(written, unit)


def currency_of(title: str, item: Field[Any]) -> str:
    """The code of the currency in a price column's header; empty for other columns, and if it has none.

    Raises
    ------
    UserError : it is no currency.
    """
    _, bracket, written = title.partition("[")
    if not bracket or not item.metadata.get("currency"):
        return ""
    try:
        return currency_code(written.rstrip("] "))
    except ValueError as error:
        raise UserError(str(error)) from None


def number_cell(text: str, scale: float, rules: Mapping[str, Any]) -> float:
    """A number in SI units; ``scale``: factor of the column's unit, ``rules``: metadata of the column's field.

    Raises
    ------
    ValueError : it is no number, or not an allowed one.
    """
    if _NUMBER.fullmatch(text) is None:
        comma = "; decimals take a point" if re.fullmatch(r"\d+,\d+", text) else "; the unit belongs in the header"
        known = any(sign.isdigit() for sign in text)
        raise ValueError(f'"{text}" is not a number{comma if known else "; leave the cell empty if it is not known"}')
    return require_allowed(float(text) * scale, text, rules)


def require_allowed(value: float, text: str, rules: Mapping[str, Any]) -> float:
    """The value; ValueError if it is not finite, or has a sign or a size that the column does not allow."""
    if not math.isfinite(value):
        raise ValueError(f'"{text}" is too large a number')
    if not rules["signed"] and (value < 0.0 or (value == 0.0 and not rules["zero"])):
        raise ValueError(f'"{text}" must be {"at least" if rules["zero"] else "above"} 0')
    least, most = rules["least"] * (1.0 - ROUNDING), rules["most"] * (1.0 + ROUNDING)
    if not least <= value <= most:
        scale = 1.0 if rules["unit"] == rules["shown"] else factor(rules["shown"], rules["unit"])
        words, bound = ("at least", rules["least"]) if value < least else ("at most", rules["most"])
        given = "" if rules["least"] == -math.inf else f" ({value / scale:.4g} {rules['shown']})"
        raise ValueError(f'"{text}"{given} must be {words} {bound / scale:.6g} {rules["shown"]}')
    return value


def text_cell(text: str, item: Field[Any], currency: str = "") -> str:
    """A word, a title or a price as the catalogue writes it; ``currency``: that of a price's column.

    Raises
    ------
    ValueError : it cannot be printed, is none of the column's words, or is no price.
    """
    rules = item.metadata
    if rules.get("currency"):
        return price(text, currency)
    fault = title_fault(text) if item.name in TITLES else None
    if fault is not None:
        raise ValueError(f'"{text[:60]}" {fault}')
    if rules.get("choices") or item.name == "material":
        text = standard_value(item.name, text)
    if rules.get("choices") and text not in rules["choices"]:
        near = get_close_matches(text.lower(), rules["choices"], n=1, cutoff=0.5)
        hint = f'; did you mean "{near[0]}"?' if near else ""
        raise ValueError(f'"{text}" is not one of {", ".join(rules["choices"])}{hint}')
    return text
