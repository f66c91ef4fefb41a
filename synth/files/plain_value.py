"""Values of the program's own classes as JSON and arrays, and back, without executing anything from the data.

A dataclass becomes its fields by name, and its class an index into a list known to the reader: the
classes reachable by annotations of the expected one. A shared object is written once and shared again after
reading. Numbers keep every bit; arrays go into an ``.npz`` without objects.
"""

from __future__ import annotations

import hashlib
import io
import json
import types
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, is_dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar, cast, get_args, get_type_hints

import numpy as np

from synth.remarks import Remark

Value = TypeVar("Value")


@dataclass(frozen=True)
class Remade:
    """A class that is not written field by field: ``taken`` gives the written value, ``made`` the object."""

    taken: Callable[[Any], Any]
    made: Callable[[Any], Any]


class NotPlain(Exception):
    """The data are not a value of the expected class."""


def to_bytes(value: Any, remade: Mapping[Any, Remade] | None = None) -> bytes:
    """The value as the bytes of an ``.npz`` whose ``tree`` is JSON.

    Raises
    ------
    TypeError : it holds what is no dataclass, mapping, sequence, array, number, text or path.
    """
    writer = _Writer(remade or {})
    tree = {"value": writer.write(value), "objects": writer.objects}
    text = np.frombuffer(json.dumps(tree, allow_nan=True).encode(), dtype=np.uint8)
    stream = io.BytesIO()
    np.savez(stream, tree=text, **{f"a{index}": array for index, array in enumerate(writer.arrays)})  # type: ignore[arg-type]
    return stream.getvalue()


def from_bytes(data: bytes, expected: type[Value], remade: Mapping[Any, Remade] | None = None) -> Value:
    """The value of the ``expected`` class that ``to_bytes`` wrote.

    Raises
    ------
    NotPlain : the bytes are cut, changed, or hold something else.
    """
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as file:
            tree = json.loads(file["tree"].tobytes())
            arrays = [file[f"a{index}"] for index in range(len(file.files) - 1)]
        value = _ValueReader(tree["objects"], arrays, classes_of(cast(Any, expected)), remade or {}).read(tree["value"])
    except Exception as error:  # any error that numpy, zip, JSON or a class raises for a foreign file
        raise NotPlain(str(error)) from error
    if not isinstance(value, expected):
        raise NotPlain(f"holds no {expected.__name__}")
    return value


def digest_of(value: Any) -> str:
    """Hash of a value's content; equal values built in the same way have equal hashes."""
    writer = _Writer({})
    digest = hashlib.sha256(json.dumps([writer.write(value), writer.objects]).encode())
    for array in writer.arrays:
        digest.update(f"{array.dtype.str}{array.shape}".encode() + np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


@cache
def classes_of(root: type) -> dict[str, type]:
    """The dataclasses and named tuples reachable through the annotations of ``root``'s fields, including itself."""
    found: dict[str, type] = {}
    waiting: list[Any] = [root]
    while waiting:
        hint = waiting.pop()
        waiting += get_args(hint)
        if isinstance(hint, type) and not isinstance(hint, types.GenericAlias) and _is_record(hint):
            name = _name(hint)
            if name not in found:
                found[name] = hint
                waiting += get_type_hints(hint, vars(import_module(hint.__module__))).values()
    return found


def _is_record(kind: type) -> bool:
    return is_dataclass(kind) or (issubclass(kind, tuple) and hasattr(kind, "_fields"))


def _name(kind: type) -> str:
    return f"{kind.__module__}.{kind.__qualname__}"


def _fields(kind: Any) -> tuple[str, ...]:
    return tuple(item.name for item in fields(kind)) if is_dataclass(kind) else kind._fields


class _Writer:
    """The written objects, once each."""

    def __init__(self, remade: Mapping[Any, Remade]) -> None:
        self.objects: list[Any] = []
        self.arrays: list[np.ndarray[Any, Any]] = []
        self._remade = remade
        self._known: dict[int, tuple[int, Any]] = {}  # keeps the object alive, so that its address stays unique

    def write(self, value: Any) -> Any:
        """Plain values stand for themselves; anything else is ``[number]`` of an object."""
        if value is None or type(value) in (bool, int, float, str):
            return value
        if isinstance(value, np.generic):
            return self.write(value.item())
        if id(value) not in self._known:
            content = self._content(value)
            self._known[id(value)] = len(self.objects), value
            self.objects.append(content)
        return [self._known[id(value)][0]]

    def _content(self, value: Any) -> list[Any]:
        remade = self._remade.get(type(value))
        if remade is not None:
            return ["remade", _name(type(value)), self.write(remade.taken(value))]
        if _is_record(type(value)):
            names = _fields(type(value))
            return ["record", _name(type(value)), {name: self.write(getattr(value, name)) for name in names}]
        if isinstance(value, np.ndarray) and value.dtype.kind in "biufU":
            self.arrays.append(value)
            return ["array", len(self.arrays) - 1]
        if isinstance(value, Mapping):
            return ["mapping", [[self.write(key), self.write(item)] for key, item in value.items()]]
        if isinstance(value, (tuple, list)):
            return [type(value).__name__, [self.write(item) for item in value]]
        if isinstance(value, Path):
            return ["path", str(value)]
        if isinstance(value, Remark):
            return ["remark", str(value), *value.attributes]
        raise TypeError(f"a {_name(type(value))} cannot be written as data")


class _ValueReader:
    """Objects by number, of known classes only."""

    def __init__(
        self, objects: list[Any], arrays: list[Any], classes: Mapping[str, type], remade: Mapping[Any, Remade]
    ) -> None:
        self._arrays = arrays
        self._classes = classes
        self._remade = {_name(kind): item for kind, item in remade.items()}
        self._made: list[Any] = []
        for content in objects:  # each refers only to earlier ones
            self._made.append(self._object(content))

    def read(self, written: Any) -> Any:
        """A plain value, or the object of that number."""
        return self._made[written[0]] if isinstance(written, list) else written

    def _object(self, content: list[Any]) -> Any:
        kind, *rest = content
        if kind == "remade":
            return self._remade[rest[0]].made(self.read(rest[1]))
        if kind == "record":
            known = self._classes[rest[0]]
            given = {name: self.read(item) for name, item in rest[1].items()}
            if tuple(given) != _fields(known):
                raise NotPlain(f"the fields of {rest[0]} are others")
            return known(**given)
        if kind == "mapping":
            return {self.read(key): self.read(item) for key, item in rest[0]}
        if kind == "array":
            return self._arrays[rest[0]]
        if kind == "path":
            return Path(rest[0])
        if kind == "remark":
            return Remark(*rest)
        return {"tuple": tuple, "list": list}[kind](self.read(item) for item in rest[0])
