"""Compiled code: trigonometry, the cache's folder, and recompilation when the text changes."""

from __future__ import annotations

import linecache
import os
import pickle
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numba import njit

from synth.cache import cache_folder
from synth.compiling import code_cache
from synth.compiling.numba_internals import KeptCode
from synth.compiling.trigonometry import sine_cosine
from synth.errors import UserError
from synth.files.paths import repository_root
from synth.swing.lane_layout import MOST_LINKS, LaneLaw, Layout


@njit
def both(angle: np.ndarray, sine: np.ndarray, cosine: np.ndarray) -> None:
    """The compiled pair over an array: it is inlined, so it is called from compiled code."""
    for i in range(len(angle)):
        sine[i], cosine[i] = sine_cosine(angle[i])


def test_sine_and_cosine_are_numpys() -> None:
    generator = np.random.default_rng(0)
    quarters = np.arange(-6366, 6367) * (np.pi / 2)
    angle = np.r_[generator.uniform(-1e4, 1e4, 200_000), quarters, np.nextafter(quarters, 9e9), 0.0, -1e-300, 1e-8]
    sine, cosine = np.empty_like(angle), np.empty_like(angle)
    both(angle, sine, cosine)
    rounding = 2e-16 * np.abs(angle)  # of the angle itself, and as much of the whole turns taken off it
    assert (np.abs(sine - np.sin(angle)) < 3e-14 + rounding).all()
    assert (np.abs(cosine - np.cos(angle)) < 3e-14 + rounding).all()
    assert np.abs(sine**2 + cosine**2 - 1).max() < 3e-14


def test_a_fresh_process_compiles_into_the_named_cache(tmp_path: Path) -> None:
    program = """
from synth.swing.chain import simulate
from synth.swing.leg_model import Joint, Leg, Link
leg = Leg("one", (Joint("hip", Link(1.0, 1.0, 1.0, 0.0)),), gravity=1.0)
print(float(simulate(leg, [0.01], [0.0], [0.0, 3.141592653589793], tolerance=1e-9)[-1, 0]))
"""
    environment = os.environ | {"SYNTH_CACHE": str(tmp_path / "new" / "cache")}
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True)
    assert float(done.stdout) == pytest.approx(-0.01, abs=1e-6)  # half a period of 2 pi s
    kept = sorted(path.name.split("_")[1] for path in (tmp_path / "new" / "cache" / "code").iterdir())
    assert kept == ["chain1", "plain1"]  # a leg without effects needs no more


def test_a_user_without_a_home_has_a_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A container's user id without an entry in the password file: every command ended in a traceback."""
    monkeypatch.setattr("pathlib.Path.home", _no_home)
    for name in ("SYNTH_CACHE", "XDG_CACHE_HOME"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("tempfile.gettempdir", lambda: str(tmp_path))
    assert cache_folder().parent == tmp_path
    assert repository_root(tmp_path) is None


def _no_home() -> Path:
    raise RuntimeError("Could not determine home directory.")


def test_cache_folder_is_the_named_one(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SYNTH_CACHE", str(tmp_path / "a"))
    assert cache_folder() == tmp_path / "a"
    monkeypatch.delenv("SYNTH_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "b"))
    assert cache_folder() == tmp_path / "b" / "synth"


@pytest.fixture
def unwritable(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A named cache that not even root can make, since a file is in its way; returns the temporary folder."""
    (tmp_path / "file").write_text("")
    (tmp_path / "temporary").mkdir()
    monkeypatch.setenv("SYNTH_CACHE", str(tmp_path / "file" / "cache"))
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "temporary"))
    return tmp_path / "temporary"


def test_an_unwritable_cache_falls_back_to_a_private_folder(unwritable: Path) -> None:
    folder = cache_folder()
    assert folder.parent == unwritable
    assert folder.stat().st_mode & 0o077 == 0


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="no user numbers on this system")
def test_a_fallback_of_another_user_is_not_trusted(unwritable: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    stranger = os.getuid() + 1
    monkeypatch.setattr(os, "getuid", lambda: stranger)
    with pytest.raises(UserError, match="SYNTH_CACHE"):
        cache_folder()


def test_code_is_loaded_once_and_again_when_text_or_dependency_change(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SYNTH_CACHE", str(tmp_path / "cache"))
    needed = tmp_path / "needed.py"
    needed.write_text("one = 1\n")
    first = code_cache.load("probe", "answer = 1\n", (needed,))
    assert code_cache.load("probe", "answer = 1\n", (needed,)) is first
    assert code_cache.load("probe", "answer = 2\n", (needed,)).answer == 2
    needed.write_text("one = 2\n")
    assert code_cache.load("probe", "answer = 1\n", (needed,)) is not first


PROBE = """
from synth.compiling.compiled import compiled

@compiled("float64(float64)")
def twice(x):
    return 2.0 * x
"""


def compiled_probe(folder: Path, counted: list[str], monkeypatch: pytest.MonkeyPatch) -> float:
    """The probe's answer from a freshly loaded module; each compilation is counted."""
    monkeypatch.setenv("SYNTH_CACHE", str(folder))
    kept = KeptCode.save_overload

    def counting(self: KeptCode, sig: object, cres: object) -> None:
        counted.append(self._name)
        kept(self, sig, cres)

    with monkeypatch.context() as patch:
        patch.setattr(KeptCode, "save_overload", counting)
        module = code_cache.load("probe", PROBE)
        del sys.modules[module.__name__]
    return float(module.twice(21.0))


def replaced(path: Path, data: bytes) -> None:
    path.unlink()
    path.write_bytes(data)
    path.chmod(0o600)


DAMAGE: dict[str, Callable[[Path], object]] = {
    "cut": lambda path: replaced(path, path.read_bytes()[:100]),
    "emptied": lambda path: replaced(path, b""),
    "a bit turned": lambda path: replaced(path, path.read_bytes()[:-9] + b"\0" + path.read_bytes()[-8:]),
    "no seal": lambda path: replaced(path, pickle.dumps(print)),
    "a link": lambda path: (path.rename(path.parent.parent / "moved"), path.symlink_to("../moved")),
    "a pipe": lambda path: (path.unlink(), os.mkfifo(path)),
    "a folder": lambda path: (path.unlink(), path.mkdir()),
    "written by others": lambda path: path.chmod(0o666),
    "an open folder": lambda path: path.parent.chmod(0o777),
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_damaged_code_is_compiled_again_without_a_message(
    damage: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    counted: list[str] = []
    assert compiled_probe(tmp_path / "cache", counted, monkeypatch) == 42.0
    assert compiled_probe(tmp_path / "cache", counted, monkeypatch) == 42.0
    assert len(counted) == 1  # the second came from disk
    (path,) = (tmp_path / "cache" / "code").iterdir()
    DAMAGE[damage](path)
    assert compiled_probe(tmp_path / "cache", counted, monkeypatch) == 42.0
    assert len(counted) == 2
    if damage in ("cut", "emptied", "a bit turned", "no seal", "a link", "a pipe", "written by others"):
        compiled_probe(tmp_path / "cache", counted, monkeypatch)
        assert len(counted) == 2  # the recompiled code is stored


def test_a_full_disk_only_prevents_storing_code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*arguments: object, **more: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(tempfile, "mkstemp", full)
    assert compiled_probe(tmp_path / "cache", [], monkeypatch) == 42.0
    assert not list((tmp_path / "cache" / "code").iterdir())


def test_generated_text_is_never_read_from_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SYNTH_CACHE", str(tmp_path))
    module = code_cache.load("probe", "answer = 3\n")
    assert not list(tmp_path.rglob("*.py*"))
    assert linecache.getlines(f"<{module.__name__}>") == ["answer = 3\n"]  # for a traceback


@pytest.mark.parametrize("n", [1, 2, 7])
def test_blocks_of_the_workspace_are_contiguous_and_independent_of_n(n: int) -> None:
    laws = (LaneLaw("coulomb_friction", 2, memory=True), LaneLaw("another", 3))
    layout = Layout(n, laws)
    ends = [0, *np.cumsum([size for _, size in layout.blocks.values()])]
    assert [first for first, _ in layout.blocks.values()] == ends[:-1]
    assert layout.n_row == ends[-1]
    assert layout.blocks == Layout(3, laws).blocks
    pairs = [layout.inertia_row(i, j) for i in range(n) for j in range(i, n)]
    assert pairs == list(range(*layout.rows("inertia").indices(10**6)))
    third = layout.parameter_rows("another", 2)
    assert (third.start, third.stop) == (layout.row("another") + 2 * MOST_LINKS, layout.row("another") + 14 + n)


def test_memories_and_their_derivatives_have_rows() -> None:
    layout = Layout(2, (LaneLaw("coulomb_friction", 2, memory=True),))
    state, derivative = layout.memories([("coulomb_friction", 1)])
    assert state == [layout.row("coulomb_friction memory", 1)]
    assert derivative == [layout.row("coulomb_friction memory rate", 1)]
