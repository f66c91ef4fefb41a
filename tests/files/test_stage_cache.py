"""Stages kept on disk: by their inputs, whole or not at all, and never more than a few."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from synth.files import stage_cache
from synth.files.stage_cache import StageCache, digest_of, key_of


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("SYNTH_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache" / stage_cache.FOLDER


def made(tmp_path: Path) -> Path:
    source = tmp_path / "made"
    (source / "parts").mkdir(parents=True)
    (source / "parts" / "a.stl").write_bytes(b"solid")
    (source / "note.txt").write_text("left out")
    return source


def test_a_kept_folder_comes_back_under_its_key_alone(tmp_path: Path) -> None:
    cache, key = StageCache(), key_of("solids", 1.0, "x")
    target = tmp_path / "target"
    target.mkdir()
    assert not cache.fetch(key, target)
    cache.keep(key, made(tmp_path), ("parts",))
    assert cache.fetch(key, target)
    assert (target / "parts" / "a.stl").read_bytes() == b"solid"
    assert not (target / "note.txt").exists()
    assert not cache.fetch(key_of("solids", 1.0, "y"), target)


def test_keys_tell_inputs_stages_and_program_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    keys = {key_of("solids", 1.0), key_of("solids", 1), key_of("leg", 1.0), key_of("solids", 1.0, None)}
    monkeypatch.setattr(stage_cache, "program", lambda: "another version")
    assert len(keys | {key_of("solids", 1.0)}) == 5
    assert digest_of({"a": 1.5}) == digest_of({"a": 1.5}) != digest_of({"a": 1.25})


def test_a_value_comes_back_and_a_broken_one_is_forgotten(folder: Path) -> None:
    cache = StageCache()
    assert cache.value("one") is None
    cache.keep_value("one", {"rate": 2.5})
    assert cache.value("one") == {"rate": 2.5}
    (folder / "one" / "value.pickle").write_bytes(b"\x80\x05cut")
    assert cache.value("one") is None
    assert not (folder / "one").exists()


def test_switched_off_it_keeps_nothing(tmp_path: Path, folder: Path) -> None:
    cache = StageCache(on=False)
    cache.keep("one", made(tmp_path))
    cache.keep_value("two", 2)
    assert cache.value("two") is None
    assert not cache.fetch("one", tmp_path)
    assert not folder.exists()


def test_the_least_recently_used_goes_first(tmp_path: Path, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stage_cache, "KEPT", 2)
    cache = StageCache()
    for age, key in ((3, "old"), (2, "older")):
        cache.keep_value(key, key)
        os.utime(folder / key, (1e9 - age, 1e9 - age))
    assert cache.value("old") == "old"  # used again, so it is the newer one now
    cache.keep_value("new", "new")
    assert sorted(path.name for path in folder.iterdir()) == ["new", "old"]


def test_a_disk_that_cannot_be_written_is_no_reason_to_fail(tmp_path: Path, folder: Path) -> None:
    folder.parent.mkdir(parents=True)
    folder.write_text("in the way")
    cache = StageCache()
    cache.keep("one", made(tmp_path))
    assert cache.value("one") is None
