"""Temporary folders beside a result: locked while their run lives, removed by the next one when it was killed."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

try:
    import fcntl
except ImportError:  # no such locks on Windows: nothing is known of other runs there, and nothing of theirs is touched
    fcntl = None  # type: ignore[assignment]

PARTIAL = ".{}.partial-"  # what a run writes, by the result's name
REPLACED = ".{}.replaced-"  # an earlier result, while the new one takes its place


def held_folder(parent: Path, prefix: str) -> tuple[Path, int | None]:
    """Make a folder that this process holds: its path and the lock's handle, to be closed when it is not needed.

    The kernel lets the lock go when the process ends, however it ends.
    """
    while True:
        path = Path(tempfile.mkdtemp(prefix=prefix, dir=parent))
        handle = _locked(path, wait=True)
        if path.is_dir():
            return path, handle
        if handle is not None:  # another run saw it before it was locked, and removed it
            os.close(handle)


@contextmanager
def one_at_a_time(folder: Path) -> Iterator[None]:
    """Let one process at a time look into the folder and add to it, where locks are to be had."""
    handle = _locked(folder, wait=True)
    try:
        yield
    finally:
        if handle is not None:
            os.close(handle)


def remove_leftovers(parent: Path, prefix: str) -> list[Path]:
    """Remove the folders of that prefix that no living process holds; returns those that one does hold."""
    living: list[Path] = []
    for path in _named(parent, prefix):
        handle = _locked(path)
        if handle is None:
            living.append(path)
        else:
            remove_tree(path)
            os.close(handle)
    return living


def put_back(target: Path) -> None:
    """An earlier result that a killed run had moved aside, where no other has come in its place."""
    for path in _named(target.parent, REPLACED.format(target.name)):
        handle = _locked(path)
        if handle is not None:
            with suppress(OSError):
                if (path / "old").is_dir() and not os.path.lexists(target):
                    (path / "old").rename(target)
            os.close(handle)


def remove_tree(folder: Path) -> None:
    """Remove a folder, and folders in it that may not be written; what cannot be removed stays."""
    with suppress(OSError):
        for place, _, _ in os.walk(folder):  # from the top, so that each can be entered
            if not os.access(place, os.W_OK | os.X_OK):
                Path(place).chmod(0o700)
    shutil.rmtree(folder, ignore_errors=True)


def _named(parent: Path, prefix: str) -> list[Path]:
    try:
        return [path for path in parent.iterdir() if path.name.startswith(prefix) and path.is_dir()]
    except OSError:
        return []


def _locked(folder: Path, *, wait: bool = False) -> int | None:
    """A handle that locks the folder; None where another process holds it, or the file system has no locks."""
    if fcntl is None:
        return None
    try:
        handle = os.open(folder, os.O_RDONLY)
    except OSError:
        return None
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except OSError:
        os.close(handle)
        return None
    return handle
