"""Options made in code, checked as the same section of a file is: the same words, the same ranges."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields, replace
from numbers import Integral, Real
from pathlib import Path
from typing import Any, cast, get_type_hints

from synth import units
from synth.errors import Problem, UserError
from synth.files.schema import quantity_of, schema_model
from synth.files.validate import Quantity, check_part
from synth.files.yaml_lines import Document, Key


def in_code(path: Path) -> Document:
    """The place of a mistake that was made in code, for a project of this path."""
    return Document(path, str(path), {}, {}, b"")


def require_class(given: object, wanted: type[Any]) -> None:
    """Refuse an object of another class than the public one that is wanted.

    Raises
    ------
    UserError
    """
    if not isinstance(given, wanted):
        raise UserError(other_class(given, wanted))


def other_class(given: object, wanted: type[Any]) -> str:
    """What is wrong with an object that is not of the public class that is wanted."""
    return f"{given!r:.80} is no {wanted.__name__}: write synth.{wanted.__name__}(...)"


def check_section(
    wanted: type[Any],
    given: object,
    place: Document,
    key: Key,
    problems: list[Problem],
    schema: type[Any] | None = None,
) -> None:
    """Check an object of class ``wanted`` that stands for the mapping at ``key``; mistakes go to ``problems``.

    ``schema``: the dataclass that is the section's schema, in SI, with fields of ``wanted``; None: ``wanted`` is it.
    """
    if not isinstance(given, wanted):
        problems.append(place.problem(other_class(given, wanted), key))
        return
    names = [item.name for item in fields(schema or wanted)]
    check_values(schema or wanted, {name: getattr(given, name) for name in names}, place, key, problems)


def check_values(
    section: type[Any], values: Mapping[str, object], place: Document, key: Key, problems: list[Problem]
) -> None:
    """Check some of a section's values, in SI as its dataclass holds them."""
    hints = get_type_hints(section, include_extras=True)
    written, before = {}, len(problems)
    for name, value in values.items():
        quantity = quantity_of(hints[name]) if name in hints else None
        fault = "" if quantity is None or value is None else number_fault(value, quantity.unit)
        if fault:
            problems.append(place.problem(fault, (*key, name)))
            continue
        written[name] = _as_written(value, quantity)
    if len(problems) == before:
        check_part(schema_model(cast(Any, section)), place, written, key, problems)


def number_fault(value: object, unit: str) -> str:
    """Why a value in code is no number of this SI unit; empty if it is one."""
    if isinstance(value, Real) and not isinstance(value, bool) and math.isfinite(value):
        return ""
    unit = "a share, such as 0.05" if unit == "1" else f"a number in {unit}"
    shown = f'"{value}"' if isinstance(value, str) else str(value)
    return f"{shown} is not allowed: in code this is {unit}"


def with_hint(problem: Problem) -> Problem:
    """A problem of a value that was written in SI; one of an angle says how degrees are given."""
    if " rad is not allowed" not in problem.text:
        return problem
    return replace(problem, text=f"{problem.text}; in code angles are in rad, degrees as math.radians(...)")


def _as_written(value: Any, quantity: Quantity | None) -> object:
    """The value as a file has it: a quantity with its unit."""
    if quantity is not None and isinstance(value, Real):
        return units.write(float(value), quantity.shown)
    return int(value) if isinstance(value, Integral) and not isinstance(value, bool) else value
