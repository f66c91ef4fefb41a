"""A sample of ``make kill``, and that it detects faults."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from kills import rounds
from kills.rounds import Case, hashes, killed, prepared

PROC = pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="processes are told by /proc")


@PROC
def test_killed_runs_lose_nothing_and_leave_nothing(tmp_path: Path) -> None:
    draw = random.Random(11)
    with prepared(["folder"], tmp_path / "work", legs=2) as (case,):
        done = [killed(case, draw) for _ in range(2)]
    assert [item.faults for item in done] == [()] * 2
    assert not all(item.ended for item in done)


CARELESS = """
import pathlib, subprocess, sys, time
out = pathlib.Path("out"); out.mkdir(exist_ok=True)
subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)"], stderr=subprocess.DEVNULL)
(out / "half").write_text("1"); pathlib.Path("litter").write_text(""); time.sleep(1)
"""


@PROC
def test_a_program_that_leaves_files_is_detected(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rounds, "PATIENCE", 0.2)
    (tmp_path / "synth").mkdir()
    (tmp_path / "synth" / "__init__.py").write_text("")
    (tmp_path / "synth" / "__main__.py").write_text(CARELESS)
    case = Case("careless", tmp_path, [], {"SYNTH_CACHE": str(tmp_path / "cache"), "PYTHONPATH": str(tmp_path)},
                {"half": "another"}, 1.0)  # fmt: skip
    draw = random.Random(1)
    monkeypatch.setattr(draw, "uniform", lambda least, most: 0.9)
    monkeypatch.setattr(draw, "random", lambda: 0.9)
    found = " ".join(killed(case, draw).faults)
    for words in ("lives on", "neither the earlier result nor the new one", "other bytes", "litter: "):
        assert words in found
    assert hashes(tmp_path / "out").keys() == {"half"}
