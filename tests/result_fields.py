"""The fields of a written result, and those that no text of the reference explains."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from typing import Any

import pytest

from synth.files.reference.result_schema import result_schema
from synth.files.reference.result_texts import RESULTS


def paths_of(value: Any, place: str, names: Collection[str] = ()) -> set[str]:
    """Paths of a result's fields; a quantity is one field, a name of ``names`` or of a file is NAME."""
    if value in ({}, []):  # holds no field here
        return set()
    if isinstance(value, dict) and not {"value", "unit"} <= value.keys():
        found = set()
        for key, inner in value.items():
            named = "NAME" if key in names or " of the " in key or key.endswith((".csv", ".yaml", ".json")) else key
            found |= paths_of(inner, f"{place}.{named}" if place else named, names)
        return found
    if isinstance(value, list) and value and isinstance(value[0], (dict, list)):
        return set().union(*(paths_of(item, f"{place}[]", names) for item in value))
    return {place}


def unexplained(found: set[str], texts: Mapping[str, str]) -> set[str]:
    """Paths that no text's path fits: NAME stands for any word, WHY for any sentence."""
    patterns = [re.escape(key).replace("NAME", r"[^.\[\]]+").replace("WHY", ".+") for key in texts]
    whole = re.compile("|".join(f"(?:{pattern})" for pattern in patterns))
    return {path for path in found if not whole.fullmatch(path)}


def require_explained(name: str, content: Mapping[str, Any], names: Collection[str] = ()) -> None:
    """Every field of a result of this file name has a text in the reference, and its schema takes the result."""
    assert sorted(unexplained(paths_of(content, "", names), RESULTS[name])) == [], name
    jsonschema = pytest.importorskip("jsonschema")
    schema = result_schema(name)
    jsonschema.Draft7Validator.check_schema(schema)
    assert [error.message for error in jsonschema.Draft7Validator(schema).iter_errors(content)] == []
    assert list(jsonschema.Draft7Validator(schema).iter_errors({**content, "unheard_of": 1}))
