"""Results of stages cached on disk by a hash of all their input, so that unchanged stages are not repeated.

A key contains the inputs' content, the program's own source and its libraries' versions, so an entry never becomes
outdated. The folder belongs to the user (``synth.cache``); an entry lists its files with their hashes, and a damaged
one is removed and made again. Values are stored as JSON and arrays (``plain_value``).
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import sys
from collections.abc import Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from synth.cache import is_own_folder, own_folder, read_own
from synth.files.leftovers import held_folder, remove_leftovers
from synth.files.plain_value import NotPlain, Remade, from_bytes, to_bytes
from synth.files.program_versions import versions

FOLDER = "stages"
KEPT = 24  # entries; a leg with pictures takes 25 MB
_VALUE = "value.npz"
_PARTIAL = ".partial-"
_LIST = ".kept.json"  # of an entry: each of its files with its SHA-256

Value = TypeVar("Value")


def key_of(stage: str, *parts: object) -> str:
    """A key for a stage from values fully described by their ``repr``, and from the program itself.

    Arrays count with all their elements and digits; of large ones ``plain_value.digest_of`` is faster.
    """
    digest = hashlib.sha256(f"{stage}\n{versions()}\n".encode())
    with np.printoptions(threshold=sys.maxsize, floatmode="unique"):  # usually the middle and later digits are left out
        for part in parts:
            digest.update(repr(part).encode() + b"\0")
    return digest.hexdigest()[:32]


class StageCache:
    """Cached folders and values by key; when switched off, it is empty and stores nothing."""

    def __init__(self, *, on: bool = True) -> None:
        self._folder = own_folder(FOLDER) if on else None

    def fetch(self, key: str, target: Path) -> bool:
        """Copy the cached folder's content into an existing ``target``; False if there is none, or it is damaged."""
        files = self._files(key)
        if files is None:
            return False
        for name, content in files.items():
            path = target / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        return True

    def keep(self, key: str, source: Path, names: Iterable[str] | None = None) -> None:
        """Store a folder's files, or only the ``names`` given. A full disk is not an error."""
        wanted = None if names is None else set(names)
        with suppress(OSError):
            found = (path for path in sorted(source.rglob("*")) if path.is_file())
            files = {path.relative_to(source).as_posix(): path for path in found}
            chosen = {name: path for name, path in files.items() if wanted is None or name.split("/")[0] in wanted}
            self._keep(key, {name: path.read_bytes() for name, path in chosen.items()})

    def value(self, key: str, expected: type[Value], remade: Mapping[Any, Remade] | None = None) -> Value | None:
        """The cached value of that class; None if there is none, or it is damaged."""
        files = self._files(key)
        if files is None:
            return None
        try:
            return from_bytes(files[_VALUE], expected, remade)
        except (NotPlain, KeyError):
            self._drop(key)
            return None

    def keep_value(self, key: str, value: object, remade: Mapping[Any, Remade] | None = None) -> None:
        """Store a value of the program's own classes."""
        if self._folder is not None:
            with suppress(OSError):
                self._keep(key, {_VALUE: to_bytes(value, remade)})

    def _files(self, key: str) -> dict[str, bytes] | None:
        """An entry's files if all are unchanged; otherwise None, and the entry is removed."""
        entry = self._entry(key)
        if entry is None or not os.path.lexists(entry):
            return None
        files = _as_listed(entry)
        if files is None:
            self._drop(key)
        else:
            with suppress(OSError):
                os.utime(entry)  # the least recently used is removed first
        return files

    def _keep(self, key: str, files: Mapping[str, bytes]) -> None:
        entry = self._entry(key)
        if entry is None or os.path.lexists(entry):
            return
        remove_leftovers(entry.parent, _PARTIAL)
        temporary, lock = held_folder(entry.parent, _PARTIAL)
        try:
            for name, content in files.items():
                path = temporary / name
                for parent in reversed(Path(name).parents):
                    (temporary / parent).mkdir(exist_ok=True, mode=0o700)
                path.write_bytes(content)
                path.chmod(0o600)
            listed = {name: hashlib.sha256(content).hexdigest() for name, content in files.items()}
            (temporary / _LIST).write_text(json.dumps(listed), encoding="utf-8")
            (temporary / _LIST).chmod(0o600)
            temporary.rename(entry)
        finally:
            shutil.rmtree(temporary, ignore_errors=True)
            if lock is not None:
                os.close(lock)
        self._forget()

    def _drop(self, key: str) -> None:
        entry = self._entry(key)
        if entry is not None:
            shutil.rmtree(entry, ignore_errors=True)
            with suppress(OSError):
                entry.unlink(missing_ok=True)  # a file or a link in its place

    def _entry(self, key: str) -> Path | None:
        return None if self._folder is None else self._folder / key

    def _forget(self) -> None:
        """Remove all but the most recently used entries."""
        assert self._folder is not None
        entries = [path for path in self._folder.iterdir() if not path.name.startswith(".")]
        entries.sort(key=lambda path: path.stat().st_mtime, reverse=True)
        for entry in entries[KEPT:]:
            shutil.rmtree(entry, ignore_errors=True)


def _as_listed(entry: Path) -> dict[str, bytes] | None:
    """The files of an entry if they are the listed ones, unchanged, and the user's own; else None."""
    if not is_own_folder(entry):
        return None
    try:
        listed = json.loads(read_own(entry / _LIST) or b"")
        folders = [path for path in entry.rglob("*") if path.is_dir()]
        there = {path.relative_to(entry).as_posix() for path in entry.rglob("*")} - {_LIST}
        there -= {path.relative_to(entry).as_posix() for path in folders}
        if not isinstance(listed, dict) or there != set(listed) or not all(map(is_own_folder, folders)):
            return None
        files = {name: read_own(entry / name) for name in listed}
    except (OSError, ValueError):
        return None
    whole = {name: data for name, data in files.items() if data is not None}
    same = all(hashlib.sha256(data).hexdigest() == listed[name] for name, data in whole.items())
    return whole if same and len(whole) == len(listed) else None
