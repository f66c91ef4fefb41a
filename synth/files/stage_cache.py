"""Results of stages kept on disk by a hash of all that they depend on, so that what did not change is not done again.

A key holds the inputs' content, the program's own source and its libraries' versions: a changed input, program or
library is another key, and nothing is ever out of date. The folder is the user's own, as is numba's cache beside it.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import os
import pickle
import shutil
import tempfile
from collections.abc import Iterable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import synth
from synth.compiling.code_cache import cache_folder

FOLDER = "stages"
KEPT = 24  # entries; a leg with pictures takes 25 MB
LIBRARIES = (
    "numpy", "scipy", "numba", "cadquery", "cadquery-ocp", "vtk", "trimesh", "manifold3d", "ezdxf", "jinja2",
)  # fmt: skip
_VALUE = "value.pickle"


@cache
def program() -> str:
    """Hash of the program's source, data, templates and libraries' versions."""
    digest = hashlib.sha256()
    root = Path(synth.__file__).parent
    for package in (root, root.parent / "cad", root.parent / "reports", root.parent / "catalogs"):
        for path in sorted(package.rglob("*")):
            if path.is_file() and path.suffix != ".pyc":
                digest.update(path.relative_to(package).as_posix().encode())
                digest.update(path.read_bytes())
    for name in LIBRARIES:
        digest.update(f"{name} {importlib.metadata.version(name)}\n".encode())
    return digest.hexdigest()


def key_of(stage: str, *parts: object) -> str:
    """A key for a stage from values whose ``repr`` tells all of them, and from the program itself."""
    digest = hashlib.sha256(f"{stage}\n{program()}\n".encode())
    for part in parts:
        digest.update(repr(part).encode() + b"\0")
    return digest.hexdigest()[:32]


def digest_of(value: Any) -> str:
    """Hash of a value's content; equal values made in the same way give the same."""
    return hashlib.sha256(pickle.dumps(value, protocol=5)).hexdigest()


class StageCache:
    """Folders and values by key; switched off, it holds nothing and keeps nothing."""

    def __init__(self, *, on: bool = True) -> None:
        self._folder = cache_folder() / FOLDER if on else None

    def fetch(self, key: str, target: Path) -> bool:
        """Copy the kept folder's content into an existing ``target``; False where there is none."""
        entry = self._entry(key)
        if entry is None or not entry.is_dir():
            return False
        with suppress(OSError):
            os.utime(entry)  # the least recently used goes first
        shutil.copytree(entry, target, dirs_exist_ok=True)
        return True

    def keep(self, key: str, source: Path, names: Iterable[str] | None = None) -> None:
        """Keep a folder's content, or only some ``names`` in it. A full disk is no reason to fail: then it is not."""
        entry = self._entry(key)
        if entry is None or entry.exists():
            return
        with suppress(OSError):
            entry.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
            temporary = Path(tempfile.mkdtemp(dir=entry.parent, prefix=".partial-"))
            try:
                for path in source.iterdir():
                    if names is None or path.name in names:
                        copy = shutil.copytree if path.is_dir() else shutil.copy2
                        copy(path, temporary / path.name)
                temporary.rename(entry)
            finally:
                shutil.rmtree(temporary, ignore_errors=True)
            self._forget()

    def value(self, key: str) -> Any:
        """The kept value; None where there is none, or where it cannot be read any more."""
        entry = self._entry(key)
        if entry is None or not (entry / _VALUE).is_file():
            return None
        try:
            os.utime(entry)
            return pickle.loads((entry / _VALUE).read_bytes())
        except Exception:  # a file cut short, in ways that pickle answers with nearly any error
            shutil.rmtree(entry, ignore_errors=True)
            return None

    def keep_value(self, key: str, value: Any) -> None:
        """Keep a value of the program's own classes."""
        if self._folder is None:
            return
        with tempfile.TemporaryDirectory() as folder:
            (Path(folder) / _VALUE).write_bytes(pickle.dumps(value, protocol=5))
            self.keep(key, Path(folder))

    def _entry(self, key: str) -> Path | None:
        return None if self._folder is None else self._folder / key

    def _forget(self) -> None:
        """Remove all but the most recently used entries."""
        assert self._folder is not None
        entries = [path for path in self._folder.iterdir() if not path.name.startswith(".")]
        entries.sort(key=lambda path: path.stat().st_mtime, reverse=True)
        for entry in entries[KEPT:]:
            shutil.rmtree(entry, ignore_errors=True)
