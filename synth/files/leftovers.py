"""Temporary folders beside a result: locked during their run; those of killed runs are removed by the next one."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

try:
    import fcntl
except ImportError:  # no such locks on Windows: other runs are unknown there, and their folders are left alone
    fcntl = None  # type: ignore[assignment]

PARTIAL = ".{}.partial-"  # output of a run, by the result's name
REPLACED = ".{}.replaced-"  # an earlier result while it is being replaced


def held_folder(parent: Path, prefix: str) -> tuple[Path, int | None]:
    """Create a folder owned by this process: its path and the lock's handle, to be closed at the end.

    The kernel releases the lock when the process ends in any way.
    """
    while True:
        path = Path(tempfile.mkdtemp(prefix=prefix, dir=parent))
        handle = _locked(path, wait=True)
        if path.is_dir():
            return path, handle
        if handle is not None:  # another run removed it before it was locked
            os.close(handle)


@contextmanager
def one_at_a_time(folder: Path) -> Iterator[None]:
    """Let one process at a time read and extend the folder, if locks are available."""
    handle = _locked(folder, wait=True)
    try:
        yield
    finally:
        if handle is not None:
            os.close(handle)


def remove_leftovers(parent: Path, prefix: str) -> list[Path]:
    """Remove the folders of that prefix that no living process holds; return those still held."""
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
    """Restore an earlier result that a killed run had moved aside, unless it was replaced."""
    for path in _named(target.parent, REPLACED.format(target.name)):
        handle = _locked(path)
        if handle is not None:
            with suppress(OSError):
                if (path / "old").is_dir() and not os.path.lexists(target):
                    (path / "old").rename(target)
            os.close(handle)


def remove_tree(folder: Path) -> None:
    """Remove a folder with its read-only folders; what cannot be removed stays."""
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
    """A handle that locks the folder; None if another process holds it, or the file system has no locks."""
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
