"""Calls carried out beside this process: in order, with their errors, and done here where no process can."""

from __future__ import annotations

import io
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path

import pytest

from side_calls import OddError, fail_oddly, fail_to_read, first_of, leave, nothing, refuse, square, wait_for
from synth import side_processes as beside
from synth.cad import DimensionError
from synth.shared_calls import ResultOf, SharedCalls, SideCall
from synth.side_processes import carried_out, process_count, side_processes
from synth.threads import VARIABLE


@pytest.fixture
def two(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "2")


@pytest.mark.usefixtures("two")
def test_results_are_in_order_and_places_are_kept() -> None:
    calls = [SideCall(square, (k,), k % 2) for k in range(6)] + [SideCall(square, (k,)) for k in range(6, 9)]
    with side_processes(3, nothing):
        assert process_count() == 2  # as many as there are threads
        found = carried_out(calls)
    assert process_count() == 0
    assert [value for value, _ in found] == [k * k for k in range(9)]
    assert len({found[k][1] for k in (0, 2, 4)}) == len({found[k][1] for k in (1, 3, 5)}) == 1
    assert len({process for _, process in found} | {os.getpid()}) == 3


@pytest.mark.usefixtures("two")
def test_blocks_within_blocks_use_the_processes_of_the_first() -> None:
    with side_processes(2, nothing):
        first = carried_out([SideCall(square, (1,), 0)])
        with side_processes(2, nothing):
            assert carried_out([SideCall(square, (1,), 0)]) == first
        assert process_count() == 2


@pytest.mark.usefixtures("two")
def test_errors_are_raised_with_what_they_hold_and_the_processes_go_on() -> None:
    with side_processes(2, nothing):
        with pytest.raises(DimensionError) as error:
            carried_out([SideCall(square, (1,)), SideCall(refuse, (1,)), SideCall(square, (2,))])
        assert [problem.dimension for problem in error.value.problems] == ["knee.wall"]
        with pytest.raises(FileNotFoundError):  # an error of the call, not of the process
            carried_out([SideCall(fail_to_read, ())])
        assert carried_out([SideCall(square, (3,))])[0][0] == 9


@pytest.mark.parametrize("threads", ["1", "2"])
def test_a_call_gets_the_results_that_it_needs(threads: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, threads)
    calls = [SideCall(square, (3,), 0), SideCall(first_of, (ResultOf(0), 4), 1), SideCall(first_of, (ResultOf(1), 5))]
    with side_processes(2, nothing):
        assert carried_out(calls)[1:] == [(9, 4), (9, 5)]


@pytest.mark.usefixtures("two")
def test_while_a_call_waits_for_a_result_its_process_does_another(tmp_path: Path) -> None:
    """The first call ends only when the last has been done, by the process whose own call needs the first."""
    path = str(tmp_path / "done")
    calls = [SideCall(wait_for, (path,), 0), SideCall(first_of, (ResultOf(0), 1), 1), SideCall(leave, (path,))]
    with side_processes(2, nothing):
        assert carried_out(calls) == [(path, True), (path, 1), path]


@pytest.mark.usefixtures("two")
def test_a_call_that_needs_what_failed_is_not_made(tmp_path: Path) -> None:
    path = tmp_path / "done"
    with side_processes(2, nothing):
        with pytest.raises(DimensionError):
            carried_out([SideCall(refuse, (1,), 0), SideCall(leave, (str(path), ResultOf(0)), 1)])
        with pytest.raises(OddError):  # it cannot be sent, so all is done here, in order
            carried_out([SideCall(fail_oddly, ("knee", 7), 0), SideCall(leave, (str(path), ResultOf(0)), 1)])
    assert not path.exists()


@pytest.mark.usefixtures("two")
@pytest.mark.parametrize("dead", [0, 1])
def test_what_a_dead_process_has_not_found_another_finds_for_those_who_need_it(dead: int) -> None:
    calls = [SideCall(square, (k,), k) for k in range(2)]
    calls += [SideCall(first_of, (ResultOf(k), k), 1 - k) for k in range(2)]
    with side_processes(2, nothing):
        os.kill(beside._pool.processes[dead].pid, signal.SIGKILL)
        assert carried_out(calls)[2:] == [(0, 0), (1, 1)]


@pytest.mark.usefixtures("two")
def test_what_a_dead_process_leaves_is_done_here() -> None:
    with side_processes(2, nothing):
        for each in beside._pool.processes:
            os.kill(each.pid, signal.SIGKILL)
        assert carried_out([SideCall(square, (k,), k) for k in range(2)]) == [(0, os.getpid()), (1, os.getpid())]
        assert process_count() == 0


@pytest.mark.usefixtures("two")
@pytest.mark.parametrize("dead", [0, 1])  # the first process, and the twin that it forked
def test_what_a_dead_process_leaves_another_does_and_that_is_told(dead: int) -> None:
    """It was done here after all other calls, in every later batch too, and nothing said so."""
    told: list[str] = []

    def stage(text: str) -> AbstractContextManager[None]:
        told.append(text)
        return nullcontext()

    with side_processes(2, nothing, stage):
        pids = [each.pid for each in beside._pool.processes]
        os.kill(pids.pop(dead), signal.SIGKILL)
        found = carried_out([SideCall(square, (k,), k % 2) for k in range(4)])
        assert found == [(k * k, pids[0]) for k in range(4)]
        assert process_count() == 1
        assert carried_out([SideCall(square, (k,), k) for k in range(3)]) == [(k * k, pids[0]) for k in range(3)]
    assert told == [f"{beside.ENDED}; what it left is done by 1 of them"]


@pytest.mark.usefixtures("two")
def test_a_twin_s_number_is_not_killed_when_the_first_process_is_gone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nobody of ours reaps the twin then, so that its number may be another program's."""
    killed: list[int] = []
    with side_processes(2, nothing):
        first, twin = beside._pool.processes
        number = twin.pid
        os.kill(first.pid, signal.SIGKILL)
        assert first._process is not None
        first._process.wait()
        monkeypatch.setattr(os, "kill", lambda number, sent: killed.append(number))
    assert killed == []
    until = time.monotonic() + 30.0
    while _lives(number) and time.monotonic() < until:
        time.sleep(0.02)
    assert not _lives(number)


@pytest.mark.parametrize("kept", [0, 4, 8, 20, -1])
def test_an_answer_that_is_cut_off_is_none(kept: int, capfd: pytest.CaptureFixture[str]) -> None:
    """Of a process that is killed while it writes: the call is done here, without a word."""
    answers = io.BytesIO()
    beside._send(answers, (4321).to_bytes(8, "little"))
    begun = answers.tell()
    beside._send(answers, pickle.dumps((True, ["wrong"] * 1000)))
    cut = answers.getvalue()[:-1] if kept < 0 else answers.getvalue()[: begun + kept]
    shared = SharedCalls([SideCall(square, (3,))], beside._pool.drop)
    thread = threading.Thread(target=shared.work, args=(0, beside.SideProcess(io.BytesIO(), io.BytesIO(cut))))
    thread.start()
    thread.join()
    assert shared.results() == [(9, os.getpid())]
    assert "Traceback" not in capfd.readouterr().err


@pytest.mark.usefixtures("two")
def test_an_error_that_cannot_be_sent_is_raised_all_the_same(capfd: pytest.CaptureFixture[str]) -> None:
    with side_processes(2, nothing):
        with pytest.raises(Exception, match="7 of knee"):
            carried_out([SideCall(fail_oddly, ("knee", 7))])
        assert carried_out([SideCall(square, (3,))])[0][0] == 9
        with pytest.raises((pickle.PicklingError, AttributeError, TypeError), match="pickle"):
            carried_out([SideCall(square, (threading.Lock(),))])
        assert carried_out([SideCall(square, (3,))])[0][1] != os.getpid()
    assert "Traceback" not in capfd.readouterr().err


def test_a_process_whose_parent_wants_no_more_ends_without_a_word() -> None:
    """Closed before it had begun, a process that was not needed printed a traceback."""
    calls, ours = os.pipe()
    theirs, answers = os.pipe()
    os.close(theirs)
    if (number := os.fork()) == 0:
        try:
            os.close(ours)
            beside._answer(os.fdopen(calls, "rb"), os.fdopen(answers, "wb"), ())
        finally:
            os._exit(1)
    os.close(calls)
    os.close(answers)
    assert os.waitstatus_to_exitcode(os.waitpid(number, 0)[1]) == 0
    os.close(ours)


@pytest.mark.usefixtures("two")
def test_a_thread_that_is_done_leaves_another_its_processes(capfd: pytest.CaptureFixture[str]) -> None:
    inside, first_done = threading.Event(), threading.Event()
    found: list[tuple[int, int]] = []

    def second() -> None:
        with side_processes(2, nothing):
            inside.set()
            first_done.wait(10.0)
            found.extend(carried_out([SideCall(square, (k,), k) for k in range(2)]))

    thread = threading.Thread(target=second)
    with side_processes(2, nothing):
        thread.start()
        assert inside.wait(10.0)
    first_done.set()
    thread.join()
    assert [value for value, _ in found] == [0, 1]
    assert os.getpid() not in {process for _, process in found}
    assert process_count() == 0
    assert "Traceback" not in capfd.readouterr().err


@pytest.mark.usefixtures("two")
def test_a_closed_process_has_ended() -> None:
    with side_processes(2, nothing):
        processes = beside._pool.processes
    for each in processes:
        with pytest.raises(EOFError):
            each.answer(SideCall(square, (3,)))


def test_with_one_thread_everything_is_done_here(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "1")
    with side_processes(3, nothing):
        assert process_count() == 0
        assert carried_out([SideCall(square, (3,))]) == [(9, os.getpid())]


def test_the_processes_end_with_a_parent_that_is_killed() -> None:
    program = (
        "from synth.side_processes import *; from synth import side_processes as s; import time\n"
        "def main():\n"
        "    with side_processes(2, int):\n"
        "        print(*(each.pid for each in s._pool.processes), flush=True)\n"
        "        time.sleep(60)\n"
        "main()"
    )
    environment = {**os.environ, VARIABLE: "2"}
    parent = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, env=environment)
    assert parent.stdout is not None
    children = [int(word) for word in parent.stdout.readline().split()]
    assert len(children) == 2
    parent.kill()
    parent.wait()
    parent.stdout.close()
    until = time.monotonic() + 30.0
    while any(_lives(child) for child in children) and time.monotonic() < until:
        time.sleep(0.05)
    assert not any(_lives(child) for child in children)


def _lives(process: int) -> bool:
    """Whether a process runs; one that has ended and is not yet reaped does not."""
    try:
        with open(f"/proc/{process}/stat", encoding="ascii") as file:  # noqa: PTH123
            return file.read().rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False
