"""Processes of this program beside it, for work that holds the interpreter's lock: the solids of a leg's joints.

Each is one Python interpreter that keeps what it has imported and built between calls. They are started plainly (no
``multiprocessing``), so a user's script without ``if __name__ == "__main__"`` is not run again in them. They end with
this process, even if it is killed. With one thread (``SYNTH_THREADS=1``, one core, a task of a folder) there is none,
and every call is carried out here.
"""

from __future__ import annotations

import os
import pickle
import queue
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

from synth.threads import LIBRARIES, VARIABLE, thread_count

_LENGTH = 8  # bytes of a call's length before it
MOST = 4  # processes; each takes 0.3 GB with the solids' kernel loaded


@dataclass(frozen=True)
class SideCall:
    """``function(*arguments)``, importable by name. ``place``: the number of its process, None: the first free one."""

    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    place: int | None = None


class SideProcess:
    """One process; calls are answered in order."""

    def __init__(self, prepare: Callable[[], None]) -> None:
        paths = [entry or str(Path.cwd()) for entry in sys.path]
        program = f"import sys; sys.path[:0] = {paths!r}; from {__name__} import serve; serve()"
        environment = {**os.environ, VARIABLE: "1", **{name: os.environ.get(name, "1") for name in LIBRARIES}}
        self._process = subprocess.Popen(
            [sys.executable, "-c", program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment
        )
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._calls, self._answers = self._process.stdin, self._process.stdout
        self._lock = threading.Lock()
        self._send(SideCall(prepare, ()))
        self._unread = 1  # answers to come before that of the next call

    def answer(self, call: SideCall) -> tuple[bool, Any]:
        """Whether the function returned, and its result or what it raised.

        Raises
        ------
        EOFError, OSError
            If the process has ended.
        """
        with self._lock:  # two threads of a user's program may design at once
            self._send(call)
            while self._unread:
                pickle.load(self._answers)
                self._unread -= 1
            passed, value = pickle.load(self._answers)
        return passed, value

    def _send(self, call: SideCall) -> None:
        text = pickle.dumps((call.function, call.arguments))
        self._calls.write(len(text).to_bytes(_LENGTH, "little") + text)
        self._calls.flush()

    def close(self) -> None:
        """End it now, whatever it does."""
        self._process.kill()
        self._process.wait()
        for stream in (self._calls, self._answers):
            with suppress(OSError):
                stream.close()


_open: list[SideProcess] = []


def process_count() -> int:
    """Number of side processes; 0: every call is carried out here."""
    return len(_open)


@contextmanager
def side_processes(most: int, prepare: Callable[[], None]) -> Iterator[None]:
    """Within the block ``carried_out`` uses up to ``most`` processes, each of which begins with ``prepare()``.

    Blocks may be nested; the inner ones use the processes of the outermost.
    """
    count = min(most, MOST, thread_count())
    if _open or count < 2:
        yield
        return
    _open.extend(SideProcess(prepare) for _ in range(count))
    try:
        yield
    finally:
        while _open:
            _open.pop().close()


def carried_out(calls: Sequence[SideCall]) -> list[Any]:
    """The calls' results, in order; in the side processes if any are open, else here.

    Raises
    ------
    BaseException
        What the first of the calls that failed raised.
    """
    if not _open:
        return [call.function(*call.arguments) for call in calls]
    shared = _Shared(calls)
    threads = [threading.Thread(target=shared.work, args=(k, each), daemon=True) for k, each in enumerate(_open)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return shared.results()


class _Shared:
    """Calls that several processes share: each takes those of its own place first, then those of none."""

    def __init__(self, calls: Sequence[SideCall]) -> None:
        self._calls = calls
        self._left = set(range(len(calls)))
        self._lock = threading.Lock()
        self._found: dict[int, tuple[bool, Any]] = {}

    def work(self, number: int, process: SideProcess) -> None:
        """Take calls until none is left."""
        while (index := self._next(number)) is not None:
            try:
                self._found[index] = process.answer(self._calls[index])
            except (EOFError, OSError):  # the process has ended, for lack of memory most likely: the call is done here
                return

    def _next(self, number: int) -> int | None:
        with self._lock:
            own = [k for k in sorted(self._left) if self._calls[k].place == number]
            free = [k for k in sorted(self._left) if self._calls[k].place is None]
            index = next(iter((*own, *free)), None)
            if index is not None:
                self._left.discard(index)
            return index

    def results(self) -> list[Any]:
        """In the order of the calls; what no process could answer is done here."""
        values = []
        for index, call in enumerate(self._calls):
            passed, value = self._found.get(index) or (True, call.function(*call.arguments))
            if not passed:
                raise value
            values.append(value)
        return values


def serve() -> None:
    """The life of a side process: answer calls from standard input until it closes."""
    import signal

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # an interrupt is the parent's
    calls, answers = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    nothing = os.open(os.devnull, os.O_RDWR)
    os.dup2(nothing, 0)
    os.dup2(nothing, 1)  # kernels print there
    waiting: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(calls, waiting), daemon=True).start()
    while True:
        text = waiting.get()
        try:
            function, arguments = pickle.loads(text)
            answer = pickle.dumps((True, function(*arguments)))
        except BaseException as error:
            answer = pickle.dumps((False, error))
        answers.write(answer)
        answers.flush()


def _listen(calls: BinaryIO, waiting: queue.SimpleQueue[bytes]) -> None:
    """Queue the calls; at the end of the input the parent has ended, and so does this process."""
    while len(length := calls.read(_LENGTH)) == _LENGTH:
        waiting.put(calls.read(int.from_bytes(length, "little")))
    os._exit(0)
