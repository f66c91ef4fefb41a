"""``--log FILE``: a record of each run: command, stages with durations, notes and error messages."""

from __future__ import annotations

import os
import platform
import shlex
import time
import traceback
from collections.abc import Sequence
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from types import TracebackType
from typing import TextIO

from synth import __version__
from synth.commands.streams import printable, write_message
from synth.errors import Problem, UserError
from synth.files.paths import size_of_regular

HEAD = "# synth log\n"  # first line of every log; a run appends only to a file that begins with it


class LogFile:
    """A log that runs append to. Each line begins with the seconds since the start.

    If it can no longer be written, on a full disk, the work goes on without it, and its end says so.

    Raises
    ------
    UserError
        If the file exists and is not a log, or cannot be written; at the end of the block, if lines were lost.
    """

    def __init__(self, path: Path, words: Sequence[str]) -> None:
        self._start = time.perf_counter()
        self._name = str(path)
        self._stream: TextIO | None = _open_log(path)
        self._lost = ""  # why lines could not be written
        now = datetime.now(UTC).isoformat(timespec="seconds")
        self.line(f"{now} {shlex.join(['synth', *words])}")
        self.line(f"synth {__version__}, Python {platform.python_version()}, {platform.platform()}, in {os.getcwd()}")  # noqa: PTH109

    def line(self, text: str) -> None:
        """Write one line with control characters escaped."""
        if self._stream is None:
            return
        try:
            self._stream.write(f"{time.perf_counter() - self._start:9.2f} s  {printable(text)}\n")
            self._stream.flush()
        except OSError as failure:
            self._lost = failure.strerror or str(failure)
            self._close()

    def _close(self) -> None:
        """Close the file; of a full disk the lines that it still holds are lost."""
        stream, self._stream = self._stream, None
        if stream is not None:
            with suppress(OSError):
                stream.close()

    def __enter__(self) -> LogFile:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        """Record how the run ended: error messages as shown, an internal error with its traceback; tell lost lines."""
        if isinstance(error, UserError):
            for problem in error.problems:
                self.line(f"mistake: {problem}")
        elif error is not None and isinstance(error, Exception):
            for line in traceback.format_exception(kind, error, where):
                for part in line.rstrip("\n").split("\n"):
                    self.line(part)
        elif error is not None:
            self.line("interrupted")
        self._close()
        if self._lost:
            text = f"cannot be written: {self._lost}"
            if error is None:
                raise UserError(Problem(f"{text}; the command itself is complete", self._name))
            write_message(f"synth: {printable(str(Problem(text, self._name)))}\n")


def _open_log(path: Path) -> TextIO:
    name = str(path)
    try:
        if path.exists() and size_of_regular(path, name):  # a pipe would wait for its reader
            with path.open(encoding="utf-8", errors="replace") as stream:
                if stream.readline() != HEAD:
                    raise UserError("exists and is not a log of synth")
            return path.open("a", encoding="utf-8")
        stream = path.open("a", encoding="utf-8")
        try:
            stream.write(HEAD)
            stream.flush()
        except OSError:
            with suppress(OSError):
                stream.close()
            raise
        return stream
    except UserError as error:
        raise UserError(Problem(f"{error.problems[0].text}; name another with --log", name)) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise UserError(Problem(f"cannot be written: {reason}; name another place with --log", name)) from None
