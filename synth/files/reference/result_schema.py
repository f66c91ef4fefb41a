"""JSON Schema of each result file, from the texts of its fields: for programs that read results."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from synth.files.reference.json_schema import DRAFT
from synth.files.reference.result_texts import RESULTS

WILD = ("NAME", "WHY")  # parts of a path that stand for any name
ITEMS = "[]"
ANYTHING = ["object", "array", "string", "number", "boolean", "null"]
QUANTITY = {
    "type": "object",
    "description": "A number with its unit; interval90, a 90 % interval, where it is an estimate.",
    "properties": {
        "value": {"type": ["number", "null"]},
        "unit": {"type": "string"},
        "interval90": {"type": ["array", "null"], "items": {"type": ["number", "null"]}},
        "unknown": {"const": True, "description": "Its interval spans a full turn: any angle fits."},
    },
    "required": ["value", "unit"],
}


def result_schema(name: str) -> dict[str, Any]:
    """The schema of ``fit.json`` and its like: which fields there are, and what each means.

    A field that the reference does not know is refused, but in what has no text below it; what is unknown is null.
    """
    root: dict[str, Any] = {}
    for path, text in RESULTS[name].items():
        _put(root, [part for part in path.replace(ITEMS, f".{ITEMS}").split(".") if part], text)
    return {"$schema": DRAFT, "title": f"synth: {name}", "definitions": {"quantity": QUANTITY}, **_schema(root)}


def _put(tree: dict[str, Any], parts: list[str], text: str) -> None:
    """A field's text in the tree of fields; a node is ``{"text", "inner"}``."""
    node: dict[str, Any] = {"inner": tree}
    for part in parts:
        node = node["inner"].setdefault(part, {"inner": {}})
    node["text"] = text


def _schema(inner: Mapping[str, Any]) -> dict[str, Any]:
    """What stands at a place: a mapping of these fields, a list of items, or null."""
    found: list[dict[str, Any]] = [{"type": "null"}]
    if ITEMS in inner:
        found.append({"type": "array", "items": _field(inner[ITEMS])})
    if set(inner) - {ITEMS}:
        named = {key: _field(node) for key, node in inner.items() if key not in (*WILD, ITEMS)}
        others = [_field(inner[key]) for key in WILD if key in inner]
        mapping = {"type": "object", "properties": named, "additionalProperties": others[0] if others else False}
        found.append(mapping)
    return {"anyOf": found}


def _field(node: Mapping[str, Any]) -> dict[str, Any]:
    """A field: what stands below it where anything does, else a quantity or a plain value."""
    text = {"description": node["text"]} if "text" in node else {}
    if not node["inner"]:
        return {**text, "anyOf": [{"$ref": "#/definitions/quantity"}, {"type": ANYTHING}]}
    deeper = _schema(node["inner"])
    if "text" in node:  # a quantity, a word or an empty list may stand in its place
        plain = [{"$ref": "#/definitions/quantity"}, {"type": ["string", "number", "array"]}]
        deeper = {"anyOf": [*deeper["anyOf"], *plain]}
    return {**text, **deeper}
