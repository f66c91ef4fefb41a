"""Values as data: to the bit, one object still one, and nothing that the data could make run."""

from __future__ import annotations

import io
import json
import math
import pickle
import re
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from synth.files.plain_value import NotPlain, Remade, classes_of, digest_of, from_bytes, to_bytes
from synth.remarks import Remark, at_joint, decisive, joint_of, kind_of, like, severity_of


@dataclass(frozen=True)
class Said:
    texts: tuple[str, ...]


def test_a_remark_comes_back_with_all_that_it_states() -> None:
    said = (decisive("the law is assumed", "Record drops."), at_joint("hip", "at a bound", "note", kind="bound"))
    again = from_bytes(to_bytes(Said(("plain", *said))), Said)
    assert again.texts == ("plain", "the law is assumed", "hip: at a bound")
    assert [severity_of(text) for text in again.texts] == ["check", "decide", "note"]
    for text in (again.texts[2], pickle.loads(pickle.dumps(said[1])), like(said[1], "other words")):
        assert (joint_of(text), kind_of(text)) == ("hip", "bound")
    assert isinstance(again.texts[1], Remark)
    assert again.texts[1].remedy == "Record drops."


class Pair(NamedTuple):
    first: str
    second: float | None


@dataclass(frozen=True)
class Inner:
    name: str
    values: tuple[float, ...]


@dataclass(frozen=True)
class Outer:
    one: Inner | None
    two: dict[str, Inner]
    array: np.ndarray[Any, Any]
    path: Path
    pair: Pair
    flags: list[bool]


@dataclass(frozen=True)
class Stranger:
    name: str


def outer(values: tuple[float, ...] = (0.1, math.inf, -0.0)) -> Outer:
    inner = Inner("x", values)
    return Outer(inner, {"a": inner, "ü": Inner("y", ())}, np.array([[1.0, np.nan], [2e-308, 3.0]]), Path("/a/b"),
                 Pair("p", None), [True, False])  # fmt: skip


def test_a_value_comes_back_to_the_bit_with_its_objects_shared() -> None:
    data = to_bytes(outer())
    again = from_bytes(data, Outer)
    assert to_bytes(again) == data
    assert again.one is again.two["a"]
    assert again.one == Inner("x", (0.1, math.inf, -0.0))
    assert math.copysign(1.0, again.one.values[2]) == -1.0
    assert np.array_equal(again.array, outer().array, equal_nan=True)
    assert (again.path, again.pair, again.flags) == (Path("/a/b"), Pair("p", None), [True, False])
    assert set(classes_of(Outer).values()) == {Outer, Inner, Pair}


@given(st.lists(st.floats(), max_size=5).map(tuple))
def test_every_number_keeps_every_bit(values: tuple[float, ...]) -> None:
    again = from_bytes(to_bytes(Inner("x", values)), Inner)
    assert np.array(again.values).tobytes() == np.array(values, dtype=float).tobytes() or any(map(math.isnan, values))


def test_equal_values_have_one_digest_and_others_another() -> None:
    assert digest_of(outer()) == digest_of(outer())
    assert len({digest_of(outer()), digest_of(outer((0.1,))), digest_of({"a": 1.5}), digest_of({"a": 1.25})}) == 4


def test_a_class_may_have_its_own_conversion() -> None:
    remade = {Stranger: Remade(lambda item: item.name.upper(), Stranger)}
    data = to_bytes({"x": Stranger("ann")}, remade)
    assert from_bytes(data, dict, remade) == {"x": Stranger("ANN")}
    with pytest.raises(NotPlain):
        from_bytes(data, dict)


@pytest.mark.parametrize("value", [{1, 2}, object(), print, np.array([object()]), b"x", 1j])
def test_objects_that_are_not_data_are_not_written(value: object) -> None:
    with pytest.raises(TypeError, match="cannot be written as data"):
        to_bytes(value)


def test_data_name_no_class_beyond_the_expected_ones() -> None:
    with pytest.raises(NotPlain):
        from_bytes(to_bytes(Stranger("x")), Outer)
    with pytest.raises(NotPlain, match="holds no Outer"):
        from_bytes(to_bytes(Inner("x", ())), Outer)


def test_cut_or_changed_bytes_are_not_plain() -> None:
    data = to_bytes(outer())
    for end in (0, 1, 10, len(data) // 2, len(data) - 1):
        with pytest.raises(NotPlain):
            from_bytes(data[:end], Outer)
    with pytest.raises(NotPlain):
        from_bytes(rewritten(data, lambda tree: {**tree, "objects": tree["objects"][::-1]}), Outer)
    with pytest.raises(NotPlain):
        from_bytes(rewritten(data, lambda tree: {**tree, "value": [999]}), Outer)
    stream = io.BytesIO()
    np.savez(stream, tree=np.array([print], dtype=object))  # to read it would be to unpickle it
    with pytest.raises(NotPlain):
        from_bytes(stream.getvalue(), Outer)


def rewritten(data: bytes, change: Any) -> bytes:
    """The same file with another tree."""
    stream = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as old:
        tree = json.loads(np.load(io.BytesIO(old.read("tree.npy"))).tobytes())
        arrays = {name[:-4]: np.load(io.BytesIO(old.read(name))) for name in old.namelist() if name != "tree.npy"}
    np.savez(stream, tree=np.frombuffer(json.dumps(change(tree)).encode(), dtype=np.uint8), **arrays)
    return stream.getvalue()


def test_no_file_but_compiled_code_is_pickled() -> None:
    """Machine code and page templates, sealed; else only calls of side processes, by pipes nothing else can write."""
    root = Path(__file__).resolve().parents[2]
    files = [path for folder in ("synth", "cad", "reports") for path in (root / folder).rglob("*.py")]
    wrong = re.compile(r"\b(pickle|cloudpickle|dill|shelve|marshal|allow_pickle=True|\w+BytecodeCache)\b")
    found = {path.relative_to(root).as_posix() for path in files if wrong.search(path.read_text(encoding="utf-8"))}
    compiled = {"synth/compiling/numba_internals.py", "synth/files/kept_templates.py"}
    assert found - compiled - {"synth/side_processes.py"} == set()
