"""One pool of threads: order kept, the bound on simultaneous pieces of work held, errors handed on."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from synth import threads
from synth.cli import main
from synth.compiling import code_cache
from synth.errors import UserError
from synth.threads import VARIABLE, as_they_finish, core_count, in_parallel, shared_out, thread_count

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
    assert sorted(as_they_finish(work, 7, most)) == [(k, k * k) for k in range(7)]


@pytest.mark.usefixtures("four")
def test_the_first_to_finish_comes_first_and_the_rest_is_left_out_after_an_error() -> None:
    turns = [threading.Event() for _ in range(3)]
    begun: list[int] = []

    def work(index: int) -> int:
        begun.append(index)
        if index < 3:
            turns[index].wait(10.0)
        else:
            time.sleep(0.01)
        if index == 3:
            raise ValueError("3")
        return index

    found = as_they_finish(work, 50, 3)
    turns[2].set()
    assert next(found) == (2, 2)
    with pytest.raises(ValueError, match="3"):
        next(found)
    for turn in turns:
        turn.set()
    assert len(begun) < 50


@pytest.mark.usefixtures("four")
def test_an_error_of_a_task_is_raised() -> None:
    def work(index: int) -> float:
        return 1.0 / (index - 3)

    with pytest.raises(ZeroDivisionError):
        in_parallel(work, 8)
    assert in_parallel(work, 2) == [-1.0 / 3.0, -0.5]  # the pool goes on


@pytest.mark.usefixtures("four")
def test_a_thread_of_the_pool_does_what_it_asks_for_itself() -> None:
    """Six tasks of four threads each asked for three more, and waited for each other without end."""

    def work(index: int) -> bool:
        own = threading.get_ident()
        both = in_parallel(lambda k: threading.get_ident(), 3), shared_out(lambda k: threading.get_ident(), 3)
        return both == ([own] * 3, [own] * 3) and dict(as_they_finish(lambda k: k, 3)) == {0: 0, 1: 1, 2: 2}

    done = threading.Thread(target=lambda: found.extend(in_parallel(work, 6)), daemon=True)
    found: list[bool] = []
    done.start()
    done.join(5.0)
    assert found == [True] * 6


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


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="this system binds no process to cores")
def test_a_process_bound_to_one_core_counts_one() -> None:
    """As a job of a scheduler is on a machine of many cores."""
    program = (
        "import os; os.sched_setaffinity(0, sorted(os.sched_getaffinity(0))[:1])\n"
        "from synth.threads import core_count, thread_count; print(core_count(), thread_count())"
    )
    environment = {name: value for name, value in os.environ.items() if name != VARIABLE}
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["1", "1"]


def test_where_the_system_tells_no_affinity_all_cores_count(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(os, "sched_getaffinity", raising=False)
    monkeypatch.setattr(os, "cpu_count", lambda: 12)
    assert core_count() == 12


def test_nothing_else_counts_cores() -> None:
    asking = re.compile(r"\bcpu_count\(")
    folders = [ROOT / name for name in ("synth", "cad", "reports", "tests/blind", "tests/bench", "tests/robustness")]
    found = {path.name for folder in folders for path in folder.rglob("*.py") if asking.search(path.read_text("utf-8"))}
    assert found == {"threads.py", "asked.py"}  # asked.py belongs to a generator that imports nothing of the program


def test_on_one_core_nothing_is_compiled_aside(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(code_cache, "core_count", lambda: 1)
    assert code_cache.compile_aside("never", "raise SystemExit") is None


@pytest.mark.parametrize("text", ["abc", "0", "-2", "2.5", "²", " 2", "1_0", "10000", "9" * 5000])
def test_a_wrong_number_of_threads_is_refused_before_any_work(
    text: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv(VARIABLE, text)
    with pytest.raises(UserError):
        thread_count()
    assert main(["catalog", "list"]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith(f'synth: {VARIABLE}: "{text[:8]}')
    assert said.err.endswith("must be a whole number of threads from 1 to 9999; unset it for one a core\n")


@pytest.mark.parametrize(("text", "wanted"), [("1", 1), ("007", 7), ("9999", 9999)])
def test_a_number_of_threads_counts(text: str, wanted: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, text)
    assert thread_count() == wanted
    monkeypatch.setenv(VARIABLE, "")
    assert thread_count() == core_count()
