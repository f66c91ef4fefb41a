"""Stages kept on disk: by their inputs, whole and the user's own or not at all, and never more than a few."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from synth.cache import cache_folder
from synth.errors import UserError
from synth.files import stage_cache
from synth.files.stage_cache import StageCache, key_of


@dataclass(frozen=True)
class Kept:
    rate: float


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("SYNTH_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache" / stage_cache.FOLDER


def made(tmp_path: Path) -> Path:
    source = tmp_path / "made"
    (source / "parts" / "deep").mkdir(parents=True)
    (source / "parts" / "a.stl").write_bytes(b"solid" * 100)
    (source / "parts" / "deep" / "b.stl").write_bytes(b"deep")
    (source / "note.txt").write_text("left out")
    return source


def test_a_kept_folder_comes_back_under_its_key_alone(tmp_path: Path) -> None:
    cache, key = StageCache(), key_of("solids", 1.0, "x")
    target = tmp_path / "target"
    target.mkdir()
    assert not cache.fetch(key, target)
    cache.keep(key, made(tmp_path), ("parts",))
    assert cache.fetch(key, target)
    files = sorted(path.relative_to(target).as_posix() for path in target.rglob("*") if path.is_file())
    assert files == ["parts/a.stl", "parts/deep/b.stl"]
    assert (target / "parts" / "a.stl").read_bytes() == b"solid" * 100
    assert not cache.fetch(key_of("solids", 1.0, "y"), target)


def test_keys_distinguish_inputs_stages_and_program(monkeypatch: pytest.MonkeyPatch) -> None:
    keys = {key_of("solids", 1.0), key_of("solids", 1), key_of("leg", 1.0), key_of("solids", 1.0, None)}
    monkeypatch.setattr(stage_cache, "versions", lambda: {"synth": "another"})
    assert len(keys | {key_of("solids", 1.0)}) == 5


def test_keys_distinguish_arrays_in_every_element_and_digit() -> None:
    """An array's usual text shows only the ends of a long one, and eight digits of a number."""
    first = np.linspace(0.0, 1.0, 5000)
    other, near = first.copy(), first.copy()
    other[2500] = 99.0
    near[7] = np.nextafter(near[7], 1.0)
    arrays = (first, other, near, first.astype(np.float32))
    assert len({key_of("solids", each) for each in arrays}) == len(arrays)
    assert len({key_of("solids", {"a": (Kept(each),)}) for each in arrays}) == len(arrays)
    assert key_of("solids", first) == key_of("solids", first.copy())


DAMAGE: dict[str, Callable[[Path], object]] = {
    "cut": lambda path: path.write_bytes(path.read_bytes()[:100]),
    "a bit turned": lambda path: path.write_bytes(path.read_bytes()[:-1] + bytes([path.read_bytes()[-1] ^ 1])),
    "emptied": lambda path: path.write_bytes(b""),
    "removed": lambda path: path.unlink(),
    "a link": lambda path: (path.rename(path.parent.parent.parent / "moved"), path.symlink_to("../../moved")),
    "a folder": lambda path: (path.unlink(), path.mkdir()),
    "a pipe": lambda path: (path.unlink(), os.mkfifo(path)),
    "written by others": lambda path: path.chmod(0o666),
    "one more file": lambda path: (path.parent / "more").write_text(""),
    "an open folder": lambda path: path.parent.chmod(0o777),
    "no list": lambda path: (path.parent / ".kept.json").unlink(),
    "a list cut": lambda path: (path.parent / ".kept.json").write_text('{"a'),
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_damaged_entry_is_dropped_and_made_again(damage: str, tmp_path: Path, folder: Path) -> None:
    cache, source, target = StageCache(), made(tmp_path) / "parts", tmp_path / "target"
    target.mkdir()
    cache.keep("solid", source)
    cache.keep_value("value", Kept(2.5))
    DAMAGE[damage](folder / "solid" / "a.stl")
    DAMAGE[damage](folder / "value" / "value.npz")
    assert not cache.fetch("solid", target)
    assert cache.value("value", Kept) is None
    assert sorted(path.name for path in folder.iterdir() if not path.name.startswith(".")) in ([], ["moved"])
    cache.keep("solid", source)
    cache.keep_value("value", Kept(3.5))
    assert cache.fetch("solid", target)
    assert (target / "a.stl").read_bytes() == b"solid" * 100
    assert cache.value("value", Kept) == Kept(3.5)


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="no user numbers on this system")
def test_entries_of_another_user_are_not_used(tmp_path: Path, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cache = StageCache()
    cache.keep("one", made(tmp_path))
    stranger = os.getuid() + 1
    monkeypatch.setattr(os, "getuid", lambda: stranger)
    assert not cache.fetch("one", tmp_path)


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="no user numbers on this system")
def test_a_named_cache_that_others_can_write_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "cache").mkdir()
    (tmp_path / "cache").chmod(0o777)
    with pytest.raises(UserError, match=r"SYNTH_CACHE.*can be written by others"):
        cache_folder()
    (tmp_path / "cache").chmod(0o755)
    assert cache_folder() == tmp_path / "cache"
    stranger = os.getuid() + 1
    monkeypatch.setattr(os, "getuid", lambda: stranger)
    with pytest.raises(UserError, match="belongs to another user"):
        StageCache()


def test_a_link_in_place_of_the_stages_is_not_followed(tmp_path: Path, folder: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    folder.parent.mkdir()
    folder.symlink_to(tmp_path / "elsewhere")
    cache = StageCache()
    cache.keep("one", made(tmp_path))
    assert not cache.fetch("one", tmp_path)
    assert not list((tmp_path / "elsewhere").iterdir())


def test_a_cache_that_is_switched_off_stores_nothing(tmp_path: Path, folder: Path) -> None:
    cache = StageCache(on=False)
    cache.keep("one", made(tmp_path))
    cache.keep_value("two", Kept(2.0))
    assert cache.value("two", Kept) is None
    assert not cache.fetch("one", tmp_path)
    assert not folder.exists()


def test_the_least_recently_used_goes_first(tmp_path: Path, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stage_cache, "KEPT", 2)
    cache = StageCache()
    for age, key in ((3, "old"), (2, "older")):
        cache.keep_value(key, Kept(age))
        os.utime(folder / key, (1e9 - age, 1e9 - age))
    assert cache.value("old", Kept) == Kept(3)  # used again, so it is the newer one now
    cache.keep_value("new", Kept(0))
    assert sorted(path.name for path in folder.iterdir()) == ["new", "old"]


def test_a_disk_that_cannot_be_written_is_no_reason_to_fail(
    tmp_path: Path, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder.parent.mkdir(parents=True)
    folder.write_text("in the way")
    cache = StageCache()
    cache.keep("one", made(tmp_path))
    assert cache.value("one", Kept) is None
    folder.unlink()
    cache = StageCache()

    def full(self: Path, data: bytes) -> int:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_bytes", full)
        cache.keep("one", tmp_path / "made")
        cache.keep_value("two", Kept(1.0))
    assert not list(folder.iterdir())


def test_leftovers_of_a_killed_run_are_removed(tmp_path: Path, folder: Path) -> None:
    cache = StageCache()
    shutil.copytree(made(tmp_path), folder / ".partial-dead")
    cache.keep_value("one", Kept(1.0))
    assert [path.name for path in folder.iterdir()] == ["one"]
