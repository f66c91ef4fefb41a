"""A sample of ``make fuzz-files``: every kind of project as it is, and a few dozen damaged ones of a fixed seed."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from fuzzing.forked import _contents, _judged

ROOT = Path(__file__).resolve().parents[2]


def fuzz(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Run the fuzzer in a separate process, because it forks and pytest has threads."""
    environment = os.environ | {"PYTHONPATH": f"{ROOT}{os.pathsep}{ROOT / 'tests'}", "SYNTH_THREADS": "1"}
    command = [sys.executable, "-m", "fuzzing", "--workers", "1", "--to", str(folder), *words]
    return subprocess.run(command, env=environment, cwd=ROOT, capture_output=True, text=True, timeout=600)


@pytest.mark.slow  # each kind of project has its own tests of the command
def test_every_project_runs_through_as_it_is(tmp_path: Path) -> None:
    done = fuzz(tmp_path, "--undamaged", "--quick")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "REFUSED      0" in done.stdout


def test_damaged_projects_are_refused_in_one_message_or_run_through(tmp_path: Path) -> None:
    done = fuzz(tmp_path, "--seed", "1", "--count", "40", "--quick")
    assert done.returncode == 0, done.stdout + done.stderr


def judged(box: Path, status: int, said: str, *, litter: str = "", result: str = "") -> str:
    """The tag of a case that ended so."""
    folder = box / "project"
    folder.mkdir(parents=True)
    (folder / "fit.yaml").write_text("kind: fit\n")
    before = _contents(box, folder / "out")
    (box / "stderr").write_text(said)
    if litter:
        (box / litter).write_text("x")
    if result:
        (folder / "out").mkdir()
        (folder / "out" / "fit.json").write_text(result)
    return _judged(status, box, folder, before, ["fit", "fit.yaml", "--out", "out"], 1e8)[0]


def test_each_kind_of_failure_is_recognised(tmp_path: Path) -> None:
    refused = "synth: fit.yaml:1: leg: is missing\n"
    assert judged(tmp_path / "a", 2, refused) == "REFUSED"
    assert judged(tmp_path / "b", 0, "", result="{}") == "DONE"
    assert judged(tmp_path / "c", 1, "") == "CRASHED"
    assert judged(tmp_path / "o", 1, "synth: cannot be had: no wire is thick enough\n") == "DONE"
    assert judged(tmp_path / "p", 3, "synth: x\n") == "CRASHED"
    assert judged(tmp_path / "d", 2, refused + "Traceback (most recent call last):\n") == "CRASHED"
    assert judged(tmp_path / "e", -99, "") == "HUNG"
    assert judged(tmp_path / "f", -11, "") == "DIED"
    assert judged(tmp_path / "g", 2, refused, litter="outside.txt") == "WROTE"
    assert judged(tmp_path / "h", 0, "", litter="project/.out.partial-x", result="{}") == "WROTE"
    assert judged(tmp_path / "i", 2, refused, result="{}") == "HALF"
    assert judged(tmp_path / "j", 0, "", result='{"value": NaN}') == "HALF"
    assert judged(tmp_path / "k", 2, "") == "SAID"
    assert judged(tmp_path / "l", 2, "something else\n") == "SAID"
    assert judged(tmp_path / "m", 0, "RuntimeWarning: overflow\n", result="{}") == "SAID"
