"""The user's cache folder for compiled code and finished stages.

Cached content is executed or delivered again, so it must be trusted: folder and files belong to the user, nobody
else can write them, and links are not followed. Each file carries its hash; a truncated or
changed file counts as absent. On a full or read-only disk nothing is stored.
"""

from __future__ import annotations

import hashlib
import os
import stat
import tempfile
from contextlib import suppress
from pathlib import Path

from synth.errors import Problem, UserError

VARIABLE = "SYNTH_CACHE"
_OTHERS = stat.S_IWGRP | stat.S_IWOTH
_SEAL = b"synth-kept-1\n"  # first bytes of a cached file, followed by its SHA-256 and its content
_HASH = 32  # bytes of a SHA-256


def cache_folder() -> Path:
    """``$SYNTH_CACHE``, or ``synth`` in the user's cache folder; created if missing.

    If neither can be written or the user has no home, a folder of the user's among the temporary files.

    Raises
    ------
    UserError
        If ``$SYNTH_CACHE`` or the temporary folder belongs to another user or is writable by others.
    """
    named = os.environ.get(VARIABLE)
    base = Path(named) if named else _user_s_folder()
    if base is None:
        return _among_temporary_files()
    with suppress(OSError):
        base.mkdir(parents=True, exist_ok=True, mode=0o700)
        fault = _fault(base.stat())  # a link to a folder of the user's is allowed
        if fault is not None and named:
            text = f"{fault}: its content would be executed; name a folder that only you can write"
            raise UserError(Problem(text, named, key=VARIABLE))
        if fault is None and os.access(base, os.W_OK):
            return base
    return _among_temporary_files()


def home_folder() -> Path | None:
    """The user's home folder; None if there is none, such as for a user id that a container was started with."""
    try:
        return Path.home()
    except RuntimeError:
        return None


def _user_s_folder() -> Path | None:
    """``synth`` in the user's cache folder; None if the user has no home."""
    caches, home = os.environ.get("XDG_CACHE_HOME"), home_folder()
    if caches:
        return Path(caches) / "synth"
    return None if home is None else home / ".cache" / "synth"


def _among_temporary_files() -> Path:
    user = os.getuid() if hasattr(os, "getuid") else os.getlogin()
    folder = Path(tempfile.gettempdir()) / f"synth-cache-{user}"
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        status = folder.lstat()
    except OSError as error:
        raise UserError(Problem(f"cannot be made: {error.strerror}; set {VARIABLE} to your own folder",
                                str(folder))) from None  # fmt: skip
    fault = "is not a folder" if not stat.S_ISDIR(status.st_mode) else _fault(status)
    if fault is not None:
        raise UserError(Problem(f"{fault}; set {VARIABLE} to your own folder", str(folder)))
    return folder


def _fault(status: os.stat_result) -> str | None:
    """Why a file or folder is not trusted; None if only the user can write it."""
    if not hasattr(os, "getuid"):
        return None
    if status.st_uid != os.getuid():
        return "belongs to another user"
    return "can be written by others" if status.st_mode & _OTHERS else None


def is_own_folder(folder: Path) -> bool:
    """Whether it is a folder, not a link, that only the user can write."""
    try:
        status = folder.lstat()
    except OSError:
        return False
    return stat.S_ISDIR(status.st_mode) and _fault(status) is None


def own_folder(name: str) -> Path | None:
    """A folder in the cache, created if missing; None if it cannot be created or is not trusted."""
    folder = cache_folder() / name
    with suppress(OSError):
        folder.mkdir(mode=0o700, exist_ok=True)
    return folder if is_own_folder(folder) else None


def read_own(path: Path) -> bytes | None:
    """A file's content; None if it is missing, a link, not a file, or not trusted."""
    try:
        handle = os.open(path, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0))
        with open(handle, "rb") as stream:  # noqa: PTH123  by its handle, so that nobody swaps the file meanwhile
            status = os.fstat(handle)
            if not stat.S_ISREG(status.st_mode) or _fault(status) is not None:
                return None
            return stream.read()
    except OSError:
        return None


def read_sealed(path: Path) -> bytes | None:
    """Content stored by ``write_sealed``; None if missing, not trusted or damaged (then deleted)."""
    data = read_own(path)
    start = len(_SEAL) + _HASH
    if (
        data is not None
        and data.startswith(_SEAL)
        and hashlib.sha256(data[start:]).digest() == data[len(_SEAL) : start]
    ):
        return data[start:]
    if data is not None:
        with suppress(OSError):
            path.unlink()
    return None


def write_sealed(path: Path, content: bytes) -> bool:
    """Store the content with its hash, complete or not at all; False if it cannot be written."""
    temporary = None
    try:
        handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".partial-{os.getpid()}-")
        with os.fdopen(handle, "wb") as stream:
            stream.write(_SEAL + hashlib.sha256(content).digest() + content)
        Path(temporary).replace(path)
    except OSError:
        if temporary is not None:
            with suppress(OSError):
                Path(temporary).unlink(missing_ok=True)
        return False
    return True
