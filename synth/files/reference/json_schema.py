"""JSON Schema of each kind of file, for editors that complete and check YAML while it is written."""

from __future__ import annotations

from typing import Any, get_origin

from synth.files.reference.keys import choices, example, marks, model_of, options, rows
from synth.files.reference.sections import KINDS, KeySection, kind_word
from synth.files.schema import Written
from synth.files.validate import Quantity

DRAFT = "http://json-schema.org/draft-07/schema#"  # what the YAML language server reads
# A number and a unit; synth itself checks the details.
QUANTITY = r"^\s*[+-]?(\d|\.\d|[½¼¾⅛]).*[A-Za-z%°\"Ωµ].*$"


def json_schema(kind: str) -> dict[str, Any]:
    """The schema of a kind of file."""
    schema = _mapping(KINDS[kind])
    schema["properties"]["kind"] = {"const": kind_word(kind), "description": "what kind of file this is"}
    return {"$schema": DRAFT, "title": f"synth: kind {kind}", **schema}


def _mapping(section: KeySection) -> dict[str, Any]:
    fields = model_of(section).model_fields
    properties: dict[str, Any] = {}
    for row in rows(section):
        item = fields[row.name]
        inner = section.inner.get(row.name)
        found = _placed(inner, row.name) if inner is not None else _value(item)
        unit = f" Unit: {row.unit}." if row.unit else ""
        default = "" if row.default is None else f" Default: {row.default}."
        found["description"] = f"{row.meaning}{unit}{default}"
        if shown := example(section, row.name, item, next(marks(item, Quantity), None)):
            found["examples"] = [shown]
        properties[row.name] = found
    required = [row.name for row in rows(section) if row.default is None]
    return {"type": "object", "additionalProperties": False, "properties": properties, "required": required}


def _placed(inner: KeySection, key: str) -> dict[str, Any]:
    """A section at its key: a mapping, a list, or under names."""
    mapping = _mapping(inner)
    if inner.how == "by name":
        return {"type": "object", "additionalProperties": {"anyOf": [mapping, {"type": "string"}]}}
    if inner.how == "list":
        several = {"type": "array", "minItems": 1, "items": {"anyOf": [mapping, {"type": "string"}]}}
        return {"anyOf": [several, mapping, {"type": "string"}]} if inner.name == "commands" else several
    if key in ("tip_mass", "time") or inner.name in (
        "input_column",
        "command_column",
    ):  # a quantity or a word is also allowed
        return {"anyOf": [mapping, {"type": ["string", "number"]}]}
    if key == "tolerance":  # a joint's name is allowed as a key for that joint only
        mapping["additionalProperties"] = {"type": "object"}
    return mapping


def _value(item: Any) -> dict[str, Any]:
    if values := choices(item):
        return {"enum": list(values)}
    written = next(marks(item, Written), None)
    if written is not None and written.each is not None:
        return {"type": "object", "additionalProperties": {"type": "string", "pattern": QUANTITY}}
    quantity = next(marks(item, Quantity), None)
    one: dict[str, Any] = {}
    if quantity is not None:
        one = {"type": ["string", "number"]} if quantity.unit == "1" else {"type": "string", "pattern": QUANTITY}
    kinds = [get_origin(option) or option for option in options(item.annotation)]
    if any(kind in (list, tuple) for kind in kinds):
        return {"type": "array", "items": one}
    if dict in kinds:
        return {"type": "object", "additionalProperties": one}
    if quantity is not None:
        return one
    types = {str: "string", bool: "boolean", int: "integer", float: "number"}
    found = [types[kind] for kind in kinds if kind in types]
    return {"type": found[0]} if len(found) == 1 else {}
