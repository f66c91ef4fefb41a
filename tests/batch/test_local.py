"""Tasks on this machine's cores: each ends as it does, and none takes another with it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from batch.tasks import task
from synth.batch.local import DIED, run_here
from synth.threads import VARIABLE, children_of_one_thread, core_count, thread_count


def test_mistakes_faults_and_dead_processes_stop_no_other_task(tmp_path: Path) -> None:
    words = ["a", "mistake", "b", "kill", "fault", f"kill once {tmp_path / 'mark'}", "c"]
    ended = dict(run_here(task, ((str(number), each) for number, each in enumerate(words)), 2))
    assert len(ended) == len(words)
    assert [ended[key].value for key in "026"] == ["A", "B", "C"]
    assert str(ended["1"].problems[0]) == "a.yaml:3: is wrong"
    assert [problem.text for problem in ended["3"].problems] == [DIED]
    assert ended["4"].crash.strip().endswith("ZeroDivisionError: ours")
    assert ended["5"].value == words[5].upper()  # tried again, alone, and done


def test_an_unlimited_list_of_tasks_is_read_on_demand() -> None:
    """Recordings of a thousand legs are not all held at once."""
    taken = 0

    def calls():  # type: ignore[no-untyped-def]
        nonlocal taken
        for number in range(1000):
            taken += 1
            yield str(number), "a"

    running = run_here(task, calls(), 1)
    assert next(running)[1].value == "A"
    assert taken <= 4
    running.close()


INTERRUPTED = """\
from batch.tasks import large
from synth.batch.local import run_here
if __name__ == "__main__":
    running = run_here(large, ((str(k), 3) for k in range(20)), 2)
    next(running)
    running.close()
"""


def test_a_run_that_stops_while_results_are_sent_ends(tmp_path: Path) -> None:
    """Its reader waited for ever for the rest of a result whose process had left; four of four times."""
    script = tmp_path / "interrupted.py"
    script.write_text(INTERRUPTED)
    paths = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    subprocess.run([sys.executable, str(script)], check=True, timeout=60.0, env=paths)


def test_a_process_among_many_has_one_thread_unless_the_user_says_otherwise() -> None:
    before = dict(os.environ)
    with children_of_one_thread():
        assert thread_count() == 1
    assert dict(os.environ) == before
    os.environ[VARIABLE] = "3"
    try:
        with children_of_one_thread():
            assert thread_count() == 3
        assert thread_count() == 3
    finally:
        del os.environ[VARIABLE]
    assert thread_count() == core_count()


RUN = """
import signal, sys
from batch.tasks import diagnose_for_long
from synth.batch.local import run_here
from synth.files.signals import terminated_as_exception
if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)
    with terminated_as_exception():
        print(*run_here(diagnose_for_long, [("one", sys.argv[1])], 1))
"""


@pytest.mark.skipif(not Path("/proc").exists(), reason="no list of processes here")
@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_run_leaves_no_diagnosis_and_no_temporary_folder(sent: signal.Signals, tmp_path: Path) -> None:
    program, temporary, note = tmp_path / "run.py", tmp_path / "temporary", tmp_path / "note.json"
    program.write_text(RUN)
    temporary.mkdir()
    words = [sys.executable, str(program), str(note)]
    environment = os.environ | {"TMPDIR": str(temporary), "PYTHONPATH": os.pathsep.join(sys.path)}
    process = subprocess.Popen(words, env=environment, stderr=subprocess.DEVNULL, start_new_session=True)
    assert _in_time(note.exists)
    diagnosis = json.loads(note.read_text())
    assert Path(diagnosis["folder"]).is_relative_to(temporary)
    process.send_signal(sent)
    assert process.wait(30) != 0
    assert _in_time(lambda: not Path(f"/proc/{diagnosis['process']}").exists())
    assert not list(temporary.iterdir())


def _in_time(holds: Callable[[], bool]) -> bool:
    until = time.monotonic() + 40.0
    while not holds() and time.monotonic() < until:
        time.sleep(0.05)
    return holds()
