"""Progress of a command: stages with durations on stderr, results on stdout."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, TextIO

from synth.commands.streams import printable as printable
from synth.commands.streams import write_message, write_result

if TYPE_CHECKING:
    from synth.commands.log_file import LogFile

TICK = 0.5  # s, between updates on a terminal


class Progress:
    """Reports progress to the user.

    Parameters
    ----------
    quiet : only ``result`` prints.
    as_json : text for people goes to the stage stream; standard output holds only ``document``.
    messages : stream of the stages, default stderr.
    results : stream of ``say`` and ``result``, default stdout.
    log : file that also receives everything, ``quiet`` or not.
    """

    def __init__(
        self,
        *,
        quiet: bool = False,
        as_json: bool = False,
        messages: TextIO | None = None,
        results: TextIO | None = None,
        log: LogFile | None = None,
    ) -> None:
        self._log = log
        self.quiet, self.as_json = quiet, as_json
        self._messages = messages or sys.stderr
        self._results = results or sys.stdout
        self._terminal = self._messages.isatty()
        self._depth = 0
        self._open: object = None  # the stage on whose line the cursor is
        self._lock = threading.Lock()

    @contextmanager
    def stage(self, text: str) -> Iterator[None]:
        """Print a stage of the work, and its duration when it ends. Stages may be nested."""
        with self._logged(text):
            if self.quiet:
                yield
                return
            with self._shown(text):
                yield

    @contextmanager
    def _logged(self, text: str) -> Iterator[None]:
        """A stage in the log: start and end."""
        if self._log is None:
            yield
            return
        start = time.perf_counter()
        self._log.line(f"{text} ...")
        yield
        self._log.line(f"{text} ... done in {time.perf_counter() - start:.2f} s")

    @contextmanager
    def _shown(self, text: str) -> Iterator[None]:
        """A stage on the screen."""
        key = object()
        label = "  " * self._depth + printable(text)
        start = time.perf_counter()
        self._break_line()
        with self._lock:
            self._write(f"{label} ...")
            self._open = key
        finished = threading.Event()
        ticker = threading.Thread(target=self._tick, args=(key, label, start, finished), daemon=True)
        if self._terminal:
            ticker.start()
        self._depth += 1
        ending = "stopped after "
        try:
            yield
            ending = ""
        finally:
            self._depth -= 1
            finished.set()
            self._end(key, label, f"{ending}{time.perf_counter() - start:.1f} s")

    def say(self, text: str) -> None:
        """One line of text on stdout; nothing when quiet."""
        if not self.quiet:
            self.result(printable(text))
        elif self._log is not None:
            self._log.line(text)

    def result(self, text: str) -> None:
        """Requested output on stdout, also when quiet."""
        self._break_line()
        lines = text.split("\n")
        if self._log is not None:
            for line in lines:
                self._log.line(line)
        stream = self._messages if self.as_json else self._results
        write_result(stream, "".join(f"{printable(line)}\n" for line in lines))

    def document(self, text: str) -> None:
        """A result's JSON file, on stdout."""
        self._break_line()
        write_result(self._results, text if text.endswith("\n") else f"{text}\n")

    def compiling(self, n_link: int, *, effects: bool = True) -> None:
        """Load the equations of motion of ``n_link`` links; compile them, with a message, if needed.

        Without ``effects``: springs, linear dampers and gravity only.
        """
        from synth.cache import cache_folder
        from synth.compiling.numba_internals import without_products
        from synth.swing.chain import compiled_chain, is_compiled
        from synth.swing.chain_modules import how_often

        links = f"{n_link} link{'s' if n_link > 1 else ''}"
        text = f"loading the equations of motion for {links}"
        if not is_compiled(n_link, plain=not effects):
            without_products()
            # Measured on two idle cores, nothing on disk: 3 s for three links, 9 s with effects, and 9 s more of a busy
            # processor for the implicit step of bent damper curves.
            what, spent = ("with effects", "8 to 20") if effects else ("without effects", "3 to 6")
            often = how_often(compiled_chain(n_link).effects if effects else ())
            once = f"{what}, {often}, {spent} s; stored in {cache_folder()}"
            text = f"compiling the equations of motion for {links} ({once})"
        with self.stage(text):
            compiled_chain(n_link).load(plain=not effects)

    def _tick(self, key: object, label: str, start: float, finished: threading.Event) -> None:
        """Update the seconds on the terminal line while this stage is the innermost."""
        while not finished.wait(TICK):
            with self._lock:
                if self._open is key and not finished.is_set():
                    self._write(f"\r{label} ... {time.perf_counter() - start:.0f} s")

    def _end(self, key: object, label: str, ending: str) -> None:
        with self._lock:
            own = self._open is key
            if self._open is not None and not own:
                self._write("\n")
            self._open = None
            if own and not self._terminal:
                self._write(f" {ending}\n")
            else:
                self._write(f"\r{label} ... {ending}\n" if self._terminal else f"{label} ... {ending}\n")

    def _break_line(self) -> None:
        """Move the cursor to the start of a line."""
        with self._lock:
            if self._open is not None:
                self._write("\n")
                self._open = None

    def _write(self, text: str) -> None:
        write_message(text, self._messages)
