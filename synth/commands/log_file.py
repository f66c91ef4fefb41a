"""``--log FILE``: a record of each run: command, stages with durations, notes and error messages."""

from __future__ import annotations

import os
import platform
import shlex
import time
import traceback
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from types import TracebackType
from typing import TextIO

from synth import __version__
from synth.commands.streams import printable
from synth.errors import Problem, UserError

HEAD = "# synth log\n"  # first line of every log; a run appends only to a file that begins with it


class LogFile:
    """A log that runs append to. Each line begins with the seconds since the start.

    Raises
    ------
    UserError
        If the file exists and is not a log, or cannot be written.
    """

    def __init__(self, path: Path, words: Sequence[str]) -> None:
        self._start = time.perf_counter()
        self._stream = _open_log(path)
        now = datetime.now(UTC).isoformat(timespec="seconds")
        self.line(f"{now} {shlex.join(['synth', *words])}")
        self.line(f"synth {__version__}, Python {platform.python_version()}, {platform.platform()}, in {os.getcwd()}")  # noqa: PTH109

    def line(self, text: str) -> None:
        """Write one line with control characters escaped."""
        self._stream.write(f"{time.perf_counter() - self._start:9.2f} s  {printable(text)}\n")
        self._stream.flush()

    def __enter__(self) -> LogFile:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, where: TracebackType | None
    ) -> None:
        """Record how the run ended: error messages as shown, an internal error with its traceback."""
        if isinstance(error, UserError):
            for problem in error.problems:
                self.line(f"mistake: {problem}")
        elif error is not None and isinstance(error, Exception):
            for line in traceback.format_exception(kind, error, where):
                for part in line.rstrip("\n").split("\n"):
                    self.line(part)
        elif error is not None:
            self.line("interrupted")
        self._stream.close()


def _open_log(path: Path) -> TextIO:
    name = str(path)
    try:
        if path.exists() and path.stat().st_size:
            if not path.is_file():
                raise UserError(Problem("is not a file; name another with --log", name))
            with path.open(encoding="utf-8", errors="replace") as stream:
                if stream.readline() != HEAD:
                    raise UserError(Problem("exists and is not a log of synth; name another with --log", name))
            return path.open("a", encoding="utf-8")
        stream = path.open("a", encoding="utf-8")
        stream.write(HEAD)
        return stream
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise UserError(Problem(f"cannot be written: {reason}; name another place with --log", name)) from None
