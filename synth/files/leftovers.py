"""Temporary folders beside a result: locked during their run; those of killed runs are removed by the next one."""

from __future__ import annotations

import errno
import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

try:
    import fcntl
except ImportError:  # no such locks on Windows: other runs are unknown there, and their folders are left alone
    fcntl = None  # type: ignore[assignment]

_HELD = (errno.EWOULDBLOCK, errno.EACCES)  # of flock; its other errors come from a file system without locks
PARTIAL = ".{}.partial-"  # output of a run, by the result's name
REPLACED = ".{}.replaced-"  # an earlier result while it is being replaced


def held_folder(parent: Path, prefix: str) -> tuple[Path, int | None]:
    """Create a folder owned by this process: its path and the lock's handle, to be closed at the end; None: no locks.

    The kernel releases the lock when the process ends in any way.
    """
    while True:
        path = Path(tempfile.mkdtemp(prefix=prefix, dir=parent))
        lock = _lock(path, wait=True)
        if path.is_dir():
            return path, lock.handle
        lock.release()  # another run removed it before it was locked


@contextmanager
def one_at_a_time(folder: Path) -> Iterator[None]:
    """Let one process at a time read and extend the folder, if locks are available."""
    lock = _lock(folder, wait=True)
    try:
        yield
    finally:
        lock.release()


def remove_leftovers(parent: Path, prefix: str) -> list[Path]:
    """Remove the folders of that prefix that no living process holds; return those still held.

    Where no locks tell, a folder is left alone and not returned: it may be a killed run's, which would refuse its
    result to every later run.
    """
    living: list[Path] = []
    for path in _named(parent, prefix):
        lock = _lock(path)
        if lock.holder == "another":
            living.append(path)
        elif lock.holder == "this process":
            remove_tree(path)
            lock.release()
    return living


def put_back(target: Path) -> None:
    """Restore an earlier result that a killed run had moved aside, unless it was replaced."""
    for path in _named(target.parent, REPLACED.format(target.name)):
        lock = _lock(path)
        if lock.holder == "this process":
            with suppress(OSError):
                if (path / "old").is_dir() and not os.path.lexists(target):
                    (path / "old").rename(target)
            lock.release()


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


@dataclass(frozen=True)
class _Lock:
    """Who holds a folder; ``handle`` of a lock of this process."""

    holder: Literal["this process", "another", "unknown"]
    handle: int | None = None

    def release(self) -> None:
        if self.handle is not None:
            os.close(self.handle)


def _lock(folder: Path, *, wait: bool = False) -> _Lock:
    """Lock the folder unless another process holds it; unknown: the system or file system has no locks, or denies."""
    if fcntl is None:
        return _Lock("unknown")
    try:
        handle = os.open(folder, os.O_RDONLY)
    except OSError:
        return _Lock("unknown")
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except OSError as error:
        os.close(handle)
        return _Lock("another" if error.errno in _HELD else "unknown")
    return _Lock("this process", handle)
