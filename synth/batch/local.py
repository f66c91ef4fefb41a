"""Tasks on this machine's cores, one single-threaded process each; they end with their parent."""

from __future__ import annotations

import multiprocessing
import os
import signal
import tempfile
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from multiprocessing.connection import Connection
from typing import Any

from synth.batch.task_outcome import TaskOutcome, performed
from synth.errors import Problem
from synth.swing.foreign_effects import own_files
from synth.threads import children_of_one_thread

AHEAD = 2  # queued tasks per process; each holds a project's recordings
DIED = "its process was killed twice, probably for lack of memory. Try it alone, or with fewer in parallel (--workers)"


class _Pool:
    """Processes that end when this object is closed or when this process dies, even if killed.

    ``folder``: where they and what they start make temporary files; they may end before they have removed them.
    """

    def __init__(self, workers: int, folder: str) -> None:
        context = multiprocessing.get_context("spawn")
        watched, self._lifeline = context.Pipe(duplex=False)
        self.processes = ProcessPoolExecutor(workers, context, initializer=_begin, initargs=(watched, folder))

    def close(self, *, finished: bool) -> None:
        if not finished:
            self._lifeline.close()
            self._let_go_of_results()
        self.processes.shutdown(wait=True, cancel_futures=True)
        if finished:
            self._lifeline.close()

    def _let_go_of_results(self) -> None:
        """Close this process's writing end of the results, which the executor leaves open.

        A process that ends half-way through sending one leaves its reader waiting for the rest: only with the last
        writing end closed does it see that nothing more comes.
        """
        results = getattr(self.processes, "_result_queue", None)
        writer = getattr(results, "_writer", None)
        if writer is not None:
            writer.close()


def _begin(watched: Connection, folder: str) -> None:
    """Leave interrupts to the parent, exit with it, and put temporary files where it removes them."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    tempfile.tempdir = folder
    os.environ["TMPDIR"] = folder  # of processes that this one starts

    def watch() -> None:
        with suppress(EOFError, OSError):
            watched.recv()  # nothing is ever sent: this returns when the other end closes
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def run_here(
    function: Callable[[Any], Any], calls: Iterable[tuple[str, Any]], workers: int
) -> Iterator[tuple[str, TaskOutcome]]:
    """Run ``function(argument)`` for each ``(key, argument)``; yields results as they finish.

    Tasks that were running when a process died are repeated one at a time, so that none affects another.
    """
    rest = iter(calls)
    # What a process still writes as it ends must not become the error of an interrupted run.
    place = tempfile.TemporaryDirectory(prefix="synth-run-", ignore_cleanup_errors=True)
    with children_of_one_thread(), place as folder:
        pool, finished = _Pool(workers, folder), False
        waiting: dict[Future[TaskOutcome], tuple[str, Any]] = {}
        try:
            while True:
                while len(waiting) < AHEAD * workers and (call := next(rest, None)) is not None:
                    waiting[pool.processes.submit(performed, function, call[1], None, own_files())] = call
                if not waiting:
                    break
                broken: list[tuple[str, Any]] = []
                for future in wait(waiting, return_when=FIRST_COMPLETED).done:
                    call = waiting.pop(future)
                    try:
                        ended = future.result()
                    except BrokenProcessPool:
                        broken.append(call)
                        continue
                    yield call[0], ended
                if broken:
                    broken += waiting.values()
                    waiting.clear()
                    pool.close(finished=True)
                    for key, argument in broken:
                        yield key, _alone(function, argument, folder)
                    pool = _Pool(workers, folder)
            finished = True
        finally:
            pool.close(finished=finished)


def _alone(function: Callable[[Any], Any], argument: Any, folder: str) -> TaskOutcome:
    """Run in a separate process; try twice, because the first attempt may have been the task's first start."""
    for _ in range(2):
        pool, finished = _Pool(1, folder), False
        try:
            ended = pool.processes.submit(performed, function, argument, None, own_files()).result()
            finished = True
            return ended
        except BrokenProcessPool:
            continue
        finally:
            pool.close(finished=finished)
    return TaskOutcome(problems=(Problem(DIED),))
