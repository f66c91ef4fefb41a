"""A frozen dataclass as the schema of a mapping in a file: one definition for the checks and for the code.

Fields carry their checks in ``Annotated``: a ``Quantity`` for a value with a unit (the dataclass holds SI), pydantic's
``Field`` for the rest, and ``Because`` for the reason of a default, which is recorded when applied.
"""

from __future__ import annotations

from dataclasses import MISSING, dataclass, fields
from functools import cache
from typing import Annotated, Any, NamedTuple, TypeVar, cast, get_args, get_origin, get_type_hints

from pydantic import Field, create_model

from synth import units
from synth.errors import Problem
from synth.files.validate import FileModel, Quantity, check_part
from synth.files.yaml_lines import Document, Key

Section = TypeVar("Section")


@dataclass(frozen=True)
class Because:
    """The reason of a default; ``shown`` is its value in words if the value itself is not informative."""

    reason: str
    shown: str | None = None


@dataclass(frozen=True)
class Written:
    """What a key that its reader checks itself holds, in words, for the reference; ``each`` : of a mapping's values."""

    type: str
    each: Quantity | None = None


class Default(NamedTuple):
    """A default that was applied because the file omits the key."""

    key: str
    value: str
    reason: str


def read_section(
    section: type[Section],
    document: Document,
    key: Key,
    problems: list[Problem],
    defaults: list[Default] | None = None,
    value: Any = None,
) -> Section | None:
    """Check the mapping at ``key`` and build the dataclass from it.

    Parameters
    ----------
    section
        the dataclass, whose fields are the keys.
    document, key
        the file and where in it the mapping stands.
    problems
        mistakes are added here, and the result is None.
    defaults
        defaults that applied are added here.
    value
        the mapping; None if the file omits it, then all defaults apply.
    """
    model = schema_model(cast(Any, section))
    checked = check_part(model, document, {} if value is None else value, key, problems)
    if checked is None:
        return None
    if defaults is not None:
        place = ".".join(str(part) for part in key)
        defaults += _defaults(section, checked, f"{place}." if place else "")
    return section(**{name: getattr(checked, name) for name in model.model_fields})


@cache
def schema_model(section: type[Any]) -> type[FileModel]:
    """The pydantic model with the dataclass' fields."""
    hints = get_type_hints(section, include_extras=True)
    definitions: dict[str, Any] = {}
    for item in fields(section):
        default: Any = item.default
        if item.default_factory is not MISSING:
            default = Field(default_factory=item.default_factory)
        definitions[item.name] = (hints[item.name], ... if default is MISSING else default)
    return create_model(section.__name__, __base__=FileModel, **definitions)


def _defaults(section: type[Any], checked: FileModel, prefix: str) -> list[Default]:
    hints = get_type_hints(section, include_extras=True)
    found: list[Default] = []
    for name in type(checked).model_fields:
        marks = get_args(hints[name])[1:] if get_origin(hints[name]) is Annotated else ()
        why = next((mark for mark in marks if isinstance(mark, Because)), None)
        if why is not None and name not in checked.model_fields_set:
            shown = why.shown or _shown(getattr(checked, name), hints[name])
            found.append(Default(prefix + name, shown, why.reason))
    return found


def _shown(value: object, hint: Any) -> str:
    """A value as it would be written in a file."""
    if isinstance(value, tuple):
        return "[" + ", ".join(_shown(item, hint) for item in value) + "]"
    quantity = quantity_of(hint)
    if isinstance(value, float) and quantity is not None:
        return units.write(value, quantity.shown)
    if isinstance(value, bool):
        return "true" if value else "false"
    return "none" if value is None else str(value)


def quantity_of(hint: Any) -> Quantity | None:
    """The quantity that a field's type is marked with; None if it has no unit."""
    for part in get_args(hint):
        found = part if isinstance(part, Quantity) else quantity_of(part)
        if found is not None:
            return found
    return None
