"""One pool of threads: order kept, the bound on simultaneous pieces of work held, errors handed on."""

from __future__ import annotations

import re
import threading
import time
from pathlib import Path

import pytest

from synth import threads
from synth.threads import in_parallel, shared_out

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture
def four(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(threads.VARIABLE, "4")
    threads._workers.cache_clear()
    yield
    threads._workers().shutdown()
    threads._workers.cache_clear()


@pytest.mark.usefixtures("four")
@pytest.mark.parametrize("most", [None, 1, 2, 3, 4, 9])
def test_results_are_in_order_and_no_more_than_so_many_run_at_once(most: int | None) -> None:
    running, seen, lock = 0, 0, threading.Lock()

    def work(index: int) -> int:
        nonlocal running, seen
        with lock:
            running += 1
            seen = max(seen, running)
        time.sleep(0.01)
        with lock:
            running -= 1
        return index * index

    assert in_parallel(work, 12, most) == [k * k for k in range(12)]
    assert seen <= min(most or 4, 4)
    assert most == 1 or seen > 1
    assert shared_out(work, 7) == [k * k for k in range(7)]


@pytest.mark.usefixtures("four")
def test_an_error_of_a_task_is_raised() -> None:
    def work(index: int) -> float:
        return 1.0 / (index - 3)

    with pytest.raises(ZeroDivisionError):
        in_parallel(work, 8)
    assert in_parallel(work, 2) == [-1.0 / 3.0, -0.5]  # the pool goes on


def test_there_is_one_pool() -> None:
    """Threads of a pool are made in ``synth.threads`` alone."""
    made = re.compile(r"ThreadPool(Executor)?\(")
    found = [
        str(path.relative_to(ROOT))
        for tree in ("synth", "cad", "reports")
        for path in sorted((ROOT / tree).rglob("*.py"))
        if made.search(path.read_text(encoding="utf-8"))
    ]
    assert found == ["synth/threads.py"]


def test_linear_algebra_of_a_diagnosis_has_one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where numpy was loaded with more; afterwards it is as it was."""
    import numpy as np
    from threadpoolctl import threadpool_info, threadpool_limits

    def used() -> set[int]:
        return {pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"}

    assert np.eye(2).trace() == 2.0  # loaded
    for name in threads.LIBRARIES:
        monkeypatch.delenv(name, raising=False)
    with threadpool_limits(limits=2, user_api="blas"):
        before = used()
        with threads.one_thread_of_linear_algebra():
            assert used() == {1}
        assert used() == before
