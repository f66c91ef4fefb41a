"""Standard output and error as they may be: closed, full, or read by nobody."""

from __future__ import annotations

import errno
import os
import sys
from contextlib import suppress
from typing import TextIO

_lost: list[str] = []  # why standard output could not be written


def prepare() -> None:
    """Put the null device in place of closed streams, and let no character stop what is written.

    A closed stream's number would go to the next file that is opened, and what a library prints would end there.
    """
    _lost.clear()
    for number in (0, 1, 2):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest free number, which is this one
    if sys.stdout is None:
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115, PTH123  for as long as the process lives
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115, PTH123
    for stream in (sys.stdout, sys.stderr):
        with suppress(AttributeError):  # a stream that a caller put there may be of another kind
            stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]


def write_result(stream: TextIO, text: str) -> None:
    """Write to standard output; where it is full, the work goes on, and ``lost`` tells it at the end.

    Raises
    ------
    BrokenPipeError : nobody reads it any more.
    """
    try:
        stream.write(text)
    except BrokenPipeError:
        raise
    except OSError as error:
        _lose(error)


def write_message(text: str, stream: TextIO | None = None) -> None:
    """Write to standard error; what cannot be written is not said."""
    target = stream or sys.stderr
    try:
        target.write(text)
        target.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        if error.errno == errno.EPIPE:
            raise


def lost() -> str | None:
    """Flush standard output; why some of it is lost, None where it is not."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        _lose(error)
    return _lost[0] if _lost else None


def read_by_nobody() -> None:
    """Give the flush at the process's end somewhere to go."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _lose(error: OSError) -> None:
    _lost.append(error.strerror or str(error))
    read_by_nobody()


def printable(text: str) -> str:
    """Text whose control characters (line breaks among them) are escaped: a file's name may hold any."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)
