"""The single thread pool of a process: all its cores, or ``SYNTH_THREADS``; one thread in worker processes."""

from __future__ import annotations

import os
import re
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import TypeVar

from synth.errors import Problem, UserError

T = TypeVar("T")
_of_thread = threading.local()
VARIABLE = "SYNTH_THREADS"
# Read by numpy's linear algebra when it is loaded; Dask sets the same for its workers.
LIBRARIES = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


def core_count() -> int:
    """Cores that this process may use: a scheduler's job or ``taskset`` may leave it few of the machine's.

    macOS and Windows do not tell; there it is all cores.
    """
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def thread_count() -> int:
    """Threads for compiled code that releases the interpreter's lock: ``SYNTH_THREADS``, else one a core.

    Raises
    ------
    UserError : ``SYNTH_THREADS`` is not a whole number from 1 to 9999.
    """
    text = os.environ.get(VARIABLE, "")
    if not text:
        return core_count()
    if not re.fullmatch(r"0*[1-9][0-9]{0,3}", text):
        allowed = "must be a whole number of threads from 1 to 9999; unset it for one a core"
        raise UserError(Problem(f'"{text}" {allowed}', key=VARIABLE))
    return int(text)


@lru_cache(maxsize=1)
def _workers() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(thread_count(), thread_name_prefix="synth", initializer=_begin_work)


def _begin_work() -> None:
    _of_thread.works_for_pool = True


def in_parallel(work: Callable[[int], T], count: int, most: int | None = None) -> list[T]:
    """``work(index)`` for each index below ``count``, in order, on all cores; its compiled code must release the lock.

    ``most`` : largest number in parallel. Within ``work`` the same thread does all that another call asks for: if every
    thread waited for another, none would ever be done.
    """
    if _alone(count, most):
        return [work(index) for index in range(count)]
    return list(_workers().map(_admitted(work, most), range(count)))


def waited_for(wait: Callable[[Path], None], paths: Iterable[Path], most: int) -> None:
    """``wait(path)`` for each path, at most so many at once, also with one thread: they wait for a disk, not a core."""
    with ThreadPoolExecutor(most) as waiting:
        list(waiting.map(wait, paths))  # which raises what one of them has raised


def as_they_finish(work: Callable[[int], T], count: int, most: int | None = None) -> Iterator[tuple[int, T]]:
    """Like ``in_parallel``, but each index with its result as soon as that is there, handed to the calling thread."""
    if _alone(count, most):
        yield from ((index, work(index)) for index in range(count))
        return
    admitted = _admitted(work, most)
    running = {_workers().submit(admitted, index): index for index in range(count)}
    try:
        for done in as_completed(running):
            yield running[done], done.result()
    finally:
        for waiting in running:
            waiting.cancel()


def _alone(count: int, most: int | None) -> bool:
    """Whether the calling thread does all itself."""
    return count < 2 or min(thread_count(), most or count) < 2 or getattr(_of_thread, "works_for_pool", False)


def _admitted(work: Callable[[int], T], most: int | None) -> Callable[[int], T]:
    """The work, of which at most so many pieces run at once."""
    if most is None or most >= thread_count():
        return work
    gate = threading.Semaphore(most)

    def admitted(index: int) -> T:
        with gate:
            return work(index)

    return admitted


def shared_out(work: Callable[[int], T], count: int) -> list[T]:
    """Like ``in_parallel`` with one task per core, for work so short that scheduling would cost more."""
    workers = min(thread_count(), count)
    if _alone(count, None):
        return [work(index) for index in range(count)]
    shares = in_parallel(lambda first: [work(index) for index in range(first, count, workers)], workers)
    return [shares[index % workers][index // workers] for index in range(count)]


@contextmanager
def one_thread_of_linear_algebra() -> Iterator[None]:
    """In this block a product of matrices runs on one core: ours are so small that its threads wait for each other.

    Commands set that before numpy is loaded. Where a script has loaded it, the search of the next command of a servo
    took 105 s instead of 11 on a busy machine.
    """
    if all(os.environ.get(name) == "1" for name in LIBRARIES):
        yield
        return
    from threadpoolctl import threadpool_limits

    with threadpool_limits(limits=1, user_api="blas"):
        yield


@contextmanager
def children_of_one_thread() -> Iterator[None]:
    """Processes started in this block have one thread each; variables set by the user stay."""
    added = [name for name in (VARIABLE, *LIBRARIES) if name not in os.environ]
    os.environ.update(dict.fromkeys(added, "1"))
    try:
        yield
    finally:
        for name in added:
            os.environ.pop(name, None)
