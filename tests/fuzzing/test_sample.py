"""A sample of ``make fuzz-files``: every kind of project as it is, and a few dozen damaged ones of a fixed seed."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def fuzz(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    """Run the fuzzer in a process of its own: it forks, which pytest's threads would not like."""
    environment = os.environ | {"PYTHONPATH": f"{ROOT}{os.pathsep}{ROOT / 'tests'}", "SYNTH_THREADS": "1"}
    command = [sys.executable, "-m", "fuzzing", "--workers", "1", "--to", str(folder), *words]
    return subprocess.run(command, env=environment, cwd=ROOT, capture_output=True, text=True, timeout=600)


def test_every_project_runs_through_as_it_is(tmp_path: Path) -> None:
    done = fuzz(tmp_path, "--undamaged")
    assert done.returncode == 0, done.stdout + done.stderr
    assert "REFUSED      0" in done.stdout


@pytest.mark.parametrize("seed", [1, 2])
def test_damaged_projects_are_refused_in_one_message_or_run_through(tmp_path: Path, seed: int) -> None:
    done = fuzz(tmp_path, "--seed", str(seed), "--count", "30", "--quick")
    assert done.returncode == 0, done.stdout + done.stderr
