"""Tricks on numba and on the interpreter: in one place, bounded, and with a plain way that gives the same."""

from __future__ import annotations

import importlib.metadata
import os
import pickle
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from numba import njit

from synth.cache import read_sealed
from synth.compiling import numba_internals
from synth.compiling.compiled import compiled, compiled_when_called, keep_code_of
from synth.compiling.modules import absent, made_module, module_from_text, source_file, with_constant
from synth.compiling.numba_internals import as_argument, entry_point

ROOT = Path(__file__).resolve().parents[2]
ROOM = ROOT / "synth" / "compiling"
PIPES = ROOT / "synth" / "side_processes.py"  # pickles calls of its own processes, and no file
TRICKS = re.compile(r"sys\.modules|\bpickle\b(?!=)|numba\.core|_nrt\b|cache=True|\"cache\": True|linecache")


def half(x: float) -> float:
    return 0.5 * x


def test_fragile_tricks_are_in_one_package() -> None:
    found = []
    for tree in ("synth", "cad", "reports"):
        for path in sorted({*(ROOT / tree).rglob("*.py")} - {PIPES}):
            lines = path.read_text(encoding="utf-8").splitlines()
            code = [line for line in lines if not line.lstrip().startswith("#") and "allow_pickle=False" not in line]
            found += [
                f"{path.relative_to(ROOT)}: {line}" for line in code if TRICKS.search(line) and ROOM not in path.parents
            ]
    assert found == []


def test_numba_is_bounded_from_above_and_the_installed_one_is_within() -> None:
    wanted = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
    (bound,) = [re.search(r"<(\d+)\.(\d+)", item) for item in wanted if item.startswith("numba")]
    assert bound is not None
    installed = tuple(map(int, importlib.metadata.version("numba").split(".")[:2]))
    assert installed < (int(bound[1]), int(bound[2]))
    assert numba_internals.KEEPS_CODE
    assert numba_internals.UNCOUNTED


def test_without_numbas_internals_code_is_compiled_and_not_stored(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SYNTH_CACHE", str(tmp_path))
    monkeypatch.setattr(numba_internals, "KEEPS_CODE", False)
    assert compiled("float64(float64)")(half)(3.0) == 1.5
    assert compiled_when_called()(half)(3) == 1.5
    assert not list(tmp_path.rglob("*.*"))


def test_a_function_without_an_entry_point_is_called_as_it_is() -> None:
    assert entry_point(half) is half
    assert as_argument(half) is half
    made = compiled("float64(float64)")(half)
    assert entry_point(made)(5.0) == 2.5
    assert as_argument(made).__wrapper_address__() != 0


def test_code_compiled_at_its_first_call_is_kept_for_each_type(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SYNTH_CACHE", str(tmp_path))
    assert compiled_when_called()(half)(3.0) == 1.5
    assert compiled_when_called()(half)(3) == 1.5
    assert len(list((tmp_path / "code").iterdir())) == 2
    taken = []
    monkeypatch.setattr(numba_internals, "read_sealed", lambda path: (taken.append(path.name), read_sealed(path))[1])
    assert compiled_when_called()(half)(7.0) == 3.5
    assert len(taken) == 1


def test_code_of_an_independent_module_is_stored(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SYNTH_CACHE", str(tmp_path))
    taken = []
    monkeypatch.setattr(numba_internals, "read_sealed", lambda path: (taken.append(path.name), read_sealed(path))[1])
    inner = "@njit\ndef half(x):\n    return 0.5 * x\n"
    text = f"from numba import njit\n{inner}@njit\ndef quarter(x):\n    return half(half(x))\n"
    for _ in range(2):
        made = module_from_text("synth_probe_of_others", text)
        keep_code_of(made)
        assert made.quarter(8.0) == 2.0
    (kept,) = {path.name for path in (tmp_path / "code").iterdir() if ".quarter." in path.name}
    assert kept in taken


HASHED_STEP = """
import hashlib
import numpy as np
from synth.swing.chain import compiled_chain
from synth.swing.lane_layout import WORKING
from synth.swing.stage_rows import SINGLE_ROOM

chain, random = compiled_chain(2), np.random.default_rng(0)
stages = chain.sources["stages"].load()
lanes, work = random.uniform(0.5, 1.5, chain.layout.n_row * 16), random.uniform(0.5, 1.5, WORKING)
single = np.zeros(SINGLE_ROOM, dtype=np.float32)
stages.begin(lanes, work)
stages.iterate(lanes, work, single, 1)
stages.filter_error(work, single)
print(hashlib.sha256(work.tobytes() + single.tobytes()).hexdigest())
"""


def test_compiled_and_loaded_code_round_alike(tmp_path: Path) -> None:
    """Both functions called here call ``equations``, which is optimised into each in another way."""
    environment = {**os.environ, "SYNTH_CACHE": str(tmp_path)}
    command = [sys.executable, "-c", HASHED_STEP]
    found = [subprocess.run(command, env=environment, capture_output=True, check=True).stdout for _ in range(2)]
    assert list((tmp_path / "code").glob("*iterate*"))
    assert found[0] == found[1] != b""


KEPT_WITH_RULES = """
from numba import types
from synth.compiling.numba_internals import KeptCode

def half(x):
    return 0.5 * x

class Codegen:
    def magic_tuple(self):
        return ()

print(KeptCode(half, {"fastmath": {"nsz", "arcp", "contract", "afn", "reassoc"}})._path(types.float64, Codegen()))
"""


def test_each_process_finds_the_code_of_rules_in_a_set(tmp_path: Path) -> None:
    """The order of a set of words differs from process to process: each compiled the jumps' recorder again."""
    found = {
        subprocess.run(
            [sys.executable, "-c", KEPT_WITH_RULES], check=True, capture_output=True, text=True,
            env={**os.environ, "SYNTH_CACHE": str(tmp_path), "PYTHONHASHSEED": seed},
        ).stdout
        for seed in ("1", "2")
    }  # fmt: skip
    assert len(found) == 1
    assert str(tmp_path) in found.pop()


@pytest.mark.parametrize("mode", [0o666, 0o620])
def test_nothing_is_unpickled_that_others_can_write(mode: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SYNTH_CACHE", str(tmp_path))
    assert compiled("float64(float64)")(half)(3.0) == 1.5
    (path,) = (tmp_path / "code").iterdir()
    path.chmod(mode)

    def never(data: bytes) -> object:
        raise AssertionError("unpickled")

    monkeypatch.setattr(pickle, "loads", never)
    assert compiled("float64(float64)")(half)(3.0) == 1.5


def test_a_constant_that_occurs_once_in_a_text_is_replaced() -> None:
    assert with_constant("A = 1\nWHOLE = True\nB = WHOLE\n", "WHOLE", False) == "A = 1\nWHOLE = False\nB = WHOLE\n"
    for text in ("A = 1\n", "WHOLE = True\nWHOLE = True\n", "    WHOLE = True\n"):
        with pytest.raises(ValueError, match="one is needed"):
            with_constant(text, "WHOLE", False)


def test_a_module_whose_text_raises_is_not_left_behind() -> None:
    with pytest.raises(ZeroDivisionError):
        module_from_text("synth_probe_that_raises", "1 / 0\n")
    assert "synth_probe_that_raises" not in sys.modules


def test_a_module_is_made_once_and_found_by_its_file(tmp_path: Path) -> None:
    first = made_module("synth_probe_made", "answer = []\n")
    assert made_module("synth_probe_made", "answer = 1 / 0\n") is first
    module_from_text("synth_probe_of_file", b"x = 1\n", str(tmp_path / "own.py"))
    assert source_file("synth_probe_of_file") == tmp_path / "own.py"
    assert source_file("synth.compiling.modules") == ROOM / "modules.py"
    with pytest.raises(ImportError):
        source_file("synth.no_such_module.at_all")


def test_an_absent_module_is_absent_only_in_the_block() -> None:
    with absent("colorsys"), pytest.raises(ImportError):
        import colorsys
    import colorsys

    assert colorsys.rgb_to_hsv(0.0, 0.0, 0.0) == (0.0, 0.0, 0.0)


def test_numba_still_passes_functions_by_their_address() -> None:
    """What ``as_argument`` rests on: a compiled function may be an argument of another, and is called."""
    from numba import float64, types

    made = compiled("float64(float64)")(half)
    signature = float64(types.FunctionType(float64(float64)), float64)

    @njit(signature)
    def twice(function, x):  # type: ignore[no-untyped-def]
        return function(function(x))

    assert twice(as_argument(made), 8.0) == 2.0
