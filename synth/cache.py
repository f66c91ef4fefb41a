"""The user's own folder of what need not be made twice: compiled code and finished stages.

What lies there is run or delivered again, so it must be the user's own: folder and files belong to the user, nobody
else can write them, links are not followed. And it must be whole: each file carries its hash, and one that is cut or
changed counts as absent. A full or read-only disk is no reason to fail: then nothing is kept.
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
_SEAL = b"synth-kept-1\n"  # in front of a kept file, before its SHA-256 and its content
_HASH = 32  # bytes


def cache_folder() -> Path:
    """``$SYNTH_CACHE``, or ``synth`` in the user's cache folder; made where it is not there.

    Where neither can be written it is a folder of the user's own among the temporary files.

    Raises
    ------
    UserError
        If ``$SYNTH_CACHE``, or the folder among the temporary files, is another user's or others can write in it.
    """
    named = os.environ.get(VARIABLE)
    base = Path(named) if named else Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "synth"
    with suppress(OSError):
        base.mkdir(parents=True, exist_ok=True, mode=0o700)
        fault = _fault(base.stat())  # a link to a folder of the user's own is the user's choice
        if fault is not None and named:
            text = f"{fault}: what is kept there would be run; name a folder that only you can write"
            raise UserError(Problem(text, named, key=VARIABLE))
        if fault is None and os.access(base, os.W_OK):
            return base
    return _among_temporary_files()


def _among_temporary_files() -> Path:
    user = os.getuid() if hasattr(os, "getuid") else os.getlogin()
    folder = Path(tempfile.gettempdir()) / f"synth-cache-{user}"
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        status = folder.lstat()
    except OSError as error:
        raise UserError(Problem(f"cannot be made: {error.strerror}; set {VARIABLE} to a folder of your own",
                                str(folder))) from None  # fmt: skip
    fault = "is no folder" if not stat.S_ISDIR(status.st_mode) else _fault(status)
    if fault is not None:
        raise UserError(Problem(f"{fault}; set {VARIABLE} to a folder of your own", str(folder)))
    return folder


def _fault(status: os.stat_result) -> str | None:
    """Why a file or folder is not trusted; None where it is the user's alone."""
    if not hasattr(os, "getuid"):
        return None
    if status.st_uid != os.getuid():
        return "belongs to another user"
    return "can be written by others" if status.st_mode & _OTHERS else None


def is_own_folder(folder: Path) -> bool:
    """Whether it is a folder, no link to one, that is the user's alone."""
    try:
        status = folder.lstat()
    except OSError:
        return False
    return stat.S_ISDIR(status.st_mode) and _fault(status) is None


def own_folder(name: str) -> Path | None:
    """A folder in the cache, made where it is not there; None where it cannot be had or is not the user's alone."""
    folder = cache_folder() / name
    with suppress(OSError):
        folder.mkdir(mode=0o700, exist_ok=True)
    return folder if is_own_folder(folder) else None


def read_own(path: Path) -> bytes | None:
    """A file's content; None where there is none, it is a link or no file, or not the user's alone."""
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
    """What ``write_sealed`` kept; None where it is not there, not the user's alone, cut or changed: that one goes."""
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
    """Keep the content with its hash, whole or not at all; False where it cannot be written."""
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
