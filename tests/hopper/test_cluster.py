"""The sweep on a Dask cluster of two worker processes, one of which is killed while it works."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from batch.clusters import cluster, wait_until
from synth.cli import main

PROJECT = """\
kind: hopper-design
motors: {use: ["N20 HP *"]}
lengths: {least: 60 mm, most: 180 mm, step: 0.1 mm}
model: A
objectives: [clearance]
intervals: front
"""


@pytest.mark.slow  # like ``batch/test_cluster``
def test_a_killed_worker_loses_no_design_and_changes_no_byte(tmp_path: Path) -> None:
    (tmp_path / "a.yaml").write_text(PROJECT)
    command = [sys.executable, "-m", "synth", "-q", "hopper", "--no-cad", str(tmp_path / "a.yaml"), "--out"]
    kept = tmp_path / ".far.sweep"

    def chunks() -> int:
        return len(list(kept.glob("chunk_*.npy")))

    with cluster(tmp_path) as made:
        running = subprocess.Popen(
            [*command, str(tmp_path / "far"), "--scheduler", made.address], stderr=subprocess.PIPE, text=True
        )
        wait_until(lambda: chunks() >= 2 or running.poll() is not None, 120)
        made.kill_worker()
        at_the_kill = chunks()
        assert running.communicate(timeout=300)[1] == ""
        assert running.returncode == 0
    assert 2 <= at_the_kill < 8  # of 14 412 designs: it died half-way
    assert not kept.exists()
    subprocess.run([*command, str(tmp_path / "near")], check=True, timeout=300)
    for name in ("designs.csv", "hopper.json", "jump.csv", "report.html"):
        assert (tmp_path / "far" / name).read_bytes() == (tmp_path / "near" / name).read_bytes(), name


@pytest.mark.parametrize("words", [["--truth"], ["motor.yaml"]])
def test_only_a_sweep_goes_to_a_cluster(
    words: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("motor.yaml").write_text("kind: hopper-motor\n")
    assert main(["-q", "hopper", *words, "--scheduler", "tcp://127.0.0.1:1", "--out", "out"]) == 2
    assert "--scheduler: applies to the sweep of a hopper-design" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["motor.yaml"]
