"""Standard output and error that may be closed, full, or no longer read."""

from __future__ import annotations

import errno
import os
import sys
from contextlib import suppress
from typing import TextIO

_lost: list[str] = []  # why standard output could not be written


def prepare() -> None:
    """Replace closed streams by the null device, and escape characters that a stream cannot encode.

    Otherwise the next opened file would take the closed stream's number and receive a library's output.
    """
    _lost.clear()
    for number in (0, 1, 2):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # takes the lowest free number, which is this one's
    if sys.stdout is None:
        sys.stdout = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115, PTH123  for as long as the process lives
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115, PTH123
    for stream in (sys.stdout, sys.stderr):
        with suppress(AttributeError):  # a caller's own stream may lack this method
            stream.reconfigure(errors="backslashreplace")  # type: ignore[union-attr]


def write_result(stream: TextIO, text: str) -> None:
    """Write to standard output; if it is full, the work goes on and ``lost`` gives the reason at the end.

    Raises
    ------
    BrokenPipeError : the reader has closed the pipe.
    """
    try:
        stream.write(text)
    except BrokenPipeError:
        raise
    except OSError as error:
        _lose(error)


def write_message(text: str, stream: TextIO | None = None) -> None:
    """Write to standard error; failures to write are ignored."""
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
    """Flush standard output; return the reason if output was lost, else None."""
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        raise
    except OSError as error:
        _lose(error)
    return _lost[0] if _lost else None


def read_by_nobody() -> None:
    """Redirect the flush at the end of the process."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _lose(error: OSError) -> None:
    _lost.append(error.strerror or str(error))
    read_by_nobody()


def printable(text: str) -> str:
    """Text with control characters escaped, line breaks included: a file name may contain any."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)
