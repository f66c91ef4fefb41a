"""Signals that end a process, while results are written: turned into exceptions, or held back for a moment."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

ENDING = (signal.SIGINT, signal.SIGTERM, *([signal.SIGHUP] if hasattr(signal, "SIGHUP") else []))


@contextmanager
def terminated_as_exception() -> Iterator[None]:
    """Let SIGTERM and SIGHUP raise like an interrupt, so that the temporary folder is removed; main thread only.

    An ignored hang-up (``nohup``) stays ignored. A library being imported may convert the exception;
    whatever is raised after a signal counts as the signal's.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    asked: list[BaseException] = []

    def stop(number: int, frame: FrameType | None) -> None:
        asked.append(KeyboardInterrupt() if number == signal.SIGINT else SystemExit(128 + number))
        raise asked[-1]

    heard = [number for number in ENDING if signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler)]
    previous = [signal.signal(number, stop) for number in heard]
    try:
        yield
    except BaseException as error:
        if asked and error is not asked[-1]:
            raise asked[-1] from None
        raise
    finally:
        for number, handler in zip(heard, previous, strict=True):
            signal.signal(number, handler)


@contextmanager
def signals_held_back() -> Iterator[None]:
    """Let signals that end the process arrive after the block: for a few renames, of which a half loses a result.

    Handlers run in the main thread only, so that there is nothing to hold back in another. They are exchanged because
    a blocked signal goes to any other thread of the process, and its handler then runs all the same.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    arrived: list[int] = []
    previous = {number: signal.getsignal(number) for number in ENDING}
    # None: a handler that Python did not set, and could not set again. An ignored signal stays ignored.
    held = {number: handler for number, handler in previous.items() if handler not in (None, signal.SIG_IGN)}
    for number in held:
        signal.signal(number, lambda received, frame: arrived.append(received))
    try:
        yield
    finally:
        for number, handler in held.items():
            signal.signal(number, handler)
        for received in dict.fromkeys(arrived):
            signal.raise_signal(received)
