"""Processes of this program beside it, for work that holds the interpreter's lock: the solids of a leg's joints.

Each is one Python interpreter that keeps what it has imported and built between calls. The first is started plainly
(no ``multiprocessing``), so a user's script without ``if __name__ == "__main__"`` is not run again in it; the others
are its copies where a system can copy a process. They end with this process, even if it is killed. With one thread
(``SYNTH_THREADS=1``, one core, a task of a folder) there is none, and every call is carried out here.
"""

from __future__ import annotations

import gc
import importlib
import os
import pickle
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from pathlib import Path
from typing import IO, Any, BinaryIO

from synth.shared_calls import SharedCalls, SideCall, here
from synth.threads import LIBRARIES, VARIABLE, thread_count

Stage = Callable[[str], AbstractContextManager[None]]  # names a stage of the work
ENDED = "a side process has ended, for lack of memory most likely"
_LENGTH = 8  # bytes of a message's length before it
MOST = 4  # processes; each takes 0.3 GB with the solids' kernel loaded, most of it shared where they are copies
AT_REST = 0.5  # s in which a process that works on nothing ends


class SideProcess:
    """One process; calls are answered in order.

    ``process``: it; of a twin None, and ``first`` is the process that forked it.
    """

    def __init__(
        self,
        calls: IO[bytes],
        answers: IO[bytes],
        process: subprocess.Popen[bytes] | None = None,
        first: subprocess.Popen[bytes] | None = None,
    ) -> None:
        self._calls, self._answers, self._process, self._first = calls, answers, process, first
        self._lock = threading.Lock()
        self._pid: int | None = None

    @property
    def pid(self) -> int:
        """Its number, once it has prepared itself.

        Raises
        ------
        EOFError, OSError
            If the process has ended.
        """
        with self._lock:
            return self._ready()

    def _ready(self) -> int:
        if self._pid is None:
            self._pid = int.from_bytes(_received(self._answers), "little")
        return self._pid

    def answer(self, call: SideCall) -> tuple[bool, Any] | None:
        """Whether the function returned, and its result or what it raised; None: what it raised cannot be sent.

        Raises
        ------
        EOFError, OSError
            If the process has ended, also in the midst of its answer, or another thread has closed it.
        """
        text = pickle.dumps((call.function, call.arguments))
        with self._lock:  # two threads of a user's program may design at once
            try:
                self._ready()
                _send(self._calls, text)
                text = _received(self._answers)
            except ValueError:  # a closed file
                raise EOFError("the process is closed") from None
        found: tuple[bool, Any] | None = pickle.loads(text)
        return found

    def close(self) -> None:
        """End it now, whatever it does; of twins the first one last, which waits for the others."""
        # A twin is not reaped while the first process lives; later its number may be another program's, and the end of
        # its calls must do.
        if self._first is not None and self._pid is not None and self._first.poll() is None:
            with suppress(OSError):
                os.kill(self._pid, signal.SIGKILL)
        with suppress(OSError):
            self._calls.close()  # at the end of its calls a process ends
        if self._process is not None:
            try:
                self._process.wait(AT_REST)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        with suppress(OSError):
            self._answers.close()


def packed(value: object) -> bytes:
    """A value as the pipes carry it: a process that only passes it on does not read it."""
    return pickle.dumps(value)


def unpacked(content: bytes) -> Any:
    """The value of ``packed``, of this process or one of its side processes, never of a file."""
    return pickle.loads(content)


def _send(stream: IO[bytes], text: bytes) -> None:
    """A message, after its length: of one that is cut off no part is taken for the whole."""
    stream.write(len(text).to_bytes(_LENGTH, "little") + text)
    stream.flush()


def _received(stream: IO[bytes]) -> bytes:
    """The next message.

    Raises
    ------
    EOFError
        If the stream ends before the message does.
    """
    length = stream.read(_LENGTH)
    wanted = int.from_bytes(length, "little")
    if len(length) < _LENGTH or len(text := stream.read(wanted)) < wanted:
        raise EOFError("the stream has ended")
    return text


def _started(count: int, prepare: Callable[[], None]) -> list[SideProcess]:
    """``count`` processes that begin with ``prepare()``.

    On Linux one that has done so is copied: to load the solids' kernel takes 2 s of a processor. Other systems cannot
    copy a process, or not one that has loaded their graphics.
    """
    if not sys.platform.startswith("linux"):
        return [_family(1, prepare)[0] for _ in range(count)]
    return _family(count, prepare)


def _family(count: int, prepare: Callable[[], None]) -> list[SideProcess]:
    """A process and the twins that it forks when it has prepared itself."""
    pipes = [(os.pipe(), os.pipe()) for _ in range(count - 1)]
    theirs = [(calls[0], answers[1]) for calls, answers in pipes]
    paths = [entry or str(Path.cwd()) for entry in sys.path]
    task = f"{prepare.__module__!r}, {prepare.__qualname__!r}, {theirs!r}"
    program = f"import sys; sys.path[:0] = {paths!r}; from {__name__} import serve; serve({task})"
    environment = {**os.environ, VARIABLE: "1", **{name: os.environ.get(name, "1") for name in LIBRARIES}}
    process = subprocess.Popen(
        [sys.executable, "-c", program],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        env=environment,
        pass_fds=[end for pair in theirs for end in pair],
    )
    assert process.stdin is not None
    assert process.stdout is not None
    for end in (end for pair in theirs for end in pair):
        os.close(end)
    twins = [
        SideProcess(os.fdopen(calls[1], "wb"), os.fdopen(answers[0], "rb"), first=process) for calls, answers in pipes
    ]
    return [SideProcess(process.stdin, process.stdout, process), *twins]


def _unseen(text: str) -> AbstractContextManager[None]:
    """A stage that is not shown."""
    return nullcontext()


class _SideProcesses:
    """The side processes of this process, open while any block of any thread uses them."""

    def __init__(self) -> None:
        self.processes: tuple[SideProcess, ...] = ()
        self.stage: Stage = _unseen
        self._blocks = 0
        self._lock = threading.Lock()

    def begin(self, count: int, prepare: Callable[[], None], stage: Stage) -> None:
        """A block begins: the first one starts ``count`` processes."""
        with self._lock:
            if self._blocks == 0:
                self.processes, self.stage = tuple(_started(count, prepare)), stage
            self._blocks += 1

    def drop(self, process: SideProcess) -> None:
        """Take out a process that has ended; the others go on."""
        with self._lock:
            if process not in self.processes:
                return
            self.processes = tuple(each for each in self.processes if each is not process)
        process.close()

    def end(self) -> None:
        """A block ends: the last one closes the processes, the twins before the first, which waits for them."""
        with self._lock:
            self._blocks -= 1
            if self._blocks == 0:
                ended, self.processes = self.processes, ()
                for process in reversed(ended):
                    process.close()


_pool = _SideProcesses()


def process_count() -> int:
    """Number of side processes; 0: every call is carried out here."""
    return len(_pool.processes)


@contextmanager
def side_processes(most: int, prepare: Callable[[], None], stage: Stage = _unseen) -> Iterator[None]:
    """Within the block ``carried_out`` uses up to ``most`` processes, each of which begins with ``prepare()``.

    Blocks may be nested, and stand in several threads: all use the processes of the first, and the last to end closes
    them. ``stage``: what is done again because a process has ended, a stage of the work.
    """
    count = min(most, MOST, thread_count())
    if count < 2:
        yield
        return
    _pool.begin(count, prepare, stage)
    try:
        yield
    finally:
        _pool.end()


def carried_out(calls: Sequence[SideCall]) -> list[Any]:
    """The calls' results, in order; in the side processes if any are open, else here.

    What a process leaves that ends, for lack of memory most likely, the others do, and without any this one.

    Raises
    ------
    BaseException
        What the first of the calls that failed raised.
    """
    processes = _pool.processes
    if not processes:
        return here(calls)
    shared = SharedCalls(calls, _pool.drop)
    shared.work_in(processes)
    while shared.left and (processes := _pool.processes):
        with _pool.stage(f"{ENDED}; what it left is done by {len(processes)} of them"):
            shared.work_in(processes)
    if shared.left:
        with _pool.stage(f"{ENDED}, the last of them; what it left is done here"):
            return shared.results()
    return shared.results()


def serve(module: str, prepare: str, twins: Sequence[tuple[int, int]]) -> None:
    """The life of a side process: prepare, fork the twins, answer calls from standard input until it closes.

    ``twins``: descriptors of each one's calls and answers.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # an interrupt is the parent's
    ends = os.dup(0), os.dup(1)
    nothing = os.open(os.devnull, os.O_RDWR)
    os.dup2(nothing, 0)
    os.dup2(nothing, 1)  # kernels print there
    with suppress(Exception):  # the call that needs what is missing reports it
        getattr(importlib.import_module(module), prepare)()
    gc.freeze()  # what is loaded stays shared
    forked: list[int] = []
    others = {ends, *twins}
    for twin in twins:
        if (number := os.fork()) == 0:
            ends, forked = twin, []
            break
        forked.append(number)
    for end in (end for pair in others - {ends} for end in pair):
        os.close(end)
    _answer(os.fdopen(ends[0], "rb"), os.fdopen(ends[1], "wb"), forked)


def _answer(calls: BinaryIO, answers: BinaryIO, forked: Sequence[int]) -> None:
    """Send the number of this process, then answer calls until the parent wants no more."""
    with suppress(BrokenPipeError):  # the parent has closed what it did not need, maybe before this process began
        _send(answers, os.getpid().to_bytes(_LENGTH, "little"))
        waiting: queue.SimpleQueue[bytes] = queue.SimpleQueue()
        threading.Thread(target=_listen, args=(calls, waiting, forked), daemon=True).start()
        while True:
            text = waiting.get()
            try:
                function, arguments = pickle.loads(text)
                answer = pickle.dumps((True, function(*arguments)))
            except BaseException as error:
                answer = _failure(error)
            _send(answers, answer)
    _end(forked)


def _failure(error: BaseException) -> bytes:
    """What a call raised; of an error that cannot be sent, None: the caller raises it by doing the call itself."""
    try:
        text = pickle.dumps((False, error))
        pickle.loads(text)  # an error with other arguments than its class takes is written, but not read
    except Exception:
        return pickle.dumps(None)
    return text


def _listen(calls: BinaryIO, waiting: queue.SimpleQueue[bytes], forked: Sequence[int]) -> None:
    """Queue the calls; at the end of the input the parent wants no more or has ended, and so does this process."""
    with suppress(EOFError):
        while True:
            waiting.put(_received(calls))
    _end(forked)


def _end(forked: Sequence[int]) -> None:
    """End this process after its twins, so that their time is counted as that of the program."""
    for number in forked:
        with suppress(ChildProcessError):  # the other thread has waited for it
            os.waitpid(number, 0)
    os._exit(0)
