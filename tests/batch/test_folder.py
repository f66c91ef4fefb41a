"""``synth fit`` on a folder: names, bad projects, the summary, and a run that is killed."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from batch.clusters import wait_until
from batch.legs import folder_of_legs, same_bytes
from synth.batch.folder import find_projects
from synth.cli import main
from synth.errors import UserError


def children(pid: int) -> list[int]:
    """Processes whose parent is this one."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[1]) == pid and fields[0] != "Z":
            found.append(int(stat.parent.name))
    return found


def test_projects_are_found_by_kind_and_named_by_their_place(tmp_path: Path) -> None:
    for name, text in {
        "a/fit.yaml": "kind: fit\n",
        "b/fit.yaml": "kind: fit\n",
        "b/other.yml": "kind: fit\n",
        "c/leg-design.yaml": "kind: leg-design\n",
        "c/x.leg.yaml": "kind: leg\n",
        "d/broken.yaml": "kind: [fit\n",
        ".hidden/fit.yaml": "kind: fit\n",
        "fit.yaml": "kind: fit\n",
    }.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    found = find_projects(tmp_path)
    assert [item.name for item in found] == ["a", "b/fit", "b/other", "d/broken", "fit"]
    assert [bool(item.problems) for item in found] == [False, False, False, True, False]
    with pytest.raises(UserError, match="holds no project that could be fitted"):
        find_projects(tmp_path / "c")


def test_a_bad_project_stops_no_other_and_is_mended_without_fitting_the_rest_again(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    legs = folder_of_legs(tmp_path / "legs", 3)
    project = legs / "leg_01" / "fit.yaml"
    good = project.read_text()
    project.write_text(good.replace("limb.leg.yaml", "lost.leg.yaml"))
    words = ["fit", str(legs), "--out", str(tmp_path / "out")]
    assert main([*words, "--dry-run"]) == 2
    assert f"{project}:2: leg:" in capsys.readouterr().err
    assert main([*words, "--quiet"]) == 2
    said = capsys.readouterr().err.splitlines()
    assert said[0] == "synth: 1 of 3 projects could not be fitted:"
    assert said[1].startswith(f"synth: leg_01: {project}:2: leg:")
    assert len(said) == 2
    with (tmp_path / "out" / "fits.csv").open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [(row["leg"], row["state"]) for row in rows] == [
        *[("leg_00", "fitted")] * 3, *[("leg_02", "fitted")] * 3, ("leg_01", "failed"),
    ]  # fmt: skip
    fit = json.loads((tmp_path / "out" / "legs" / "leg_02" / "fit.json").read_text())
    assert float(rows[4]["spring_rate [N*m/rad]"]) == fit["joints"]["knee"]["spring_rate"]["value"]
    page = (tmp_path / "out" / "report.html").read_text()
    assert "lost.leg.yaml" in page
    assert "legs/leg_00/report.html" in page

    project.write_text(good)
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / ".out.fits").glob("fit-*")}
    assert len(before) == 2
    assert main(words) == 0
    told = capsys.readouterr().out
    assert [word in told for word in ("leg_00: kept", "leg_01: fitted", "leg_02: kept")] == [True] * 3
    assert not (tmp_path / ".out.fits").exists()
    # One project by itself gives the very files.
    assert main(["--quiet", "fit", str(project), "--out", str(tmp_path / "alone")]) == 0
    (tmp_path / "alone" / ".synth-output").unlink()
    same_bytes(tmp_path / "alone", tmp_path / "out" / "legs" / "leg_01")


def test_a_killed_run_leaves_no_process_and_goes_on_to_the_same_bytes(tmp_path: Path) -> None:
    legs = folder_of_legs(tmp_path / "legs", 6)
    command = [sys.executable, "-m", "synth", "-q", "fit", str(legs), "--workers", "2", "--out"]
    kept = tmp_path / ".killed.fits"
    running = subprocess.Popen([*command, str(tmp_path / "killed")])
    wait_until(lambda: len(list(kept.glob("fit-*"))) >= 2 or running.poll() is not None, 120)
    workers = children(running.pid)
    os.kill(running.pid, signal.SIGKILL)
    running.wait()
    wait_until(lambda: not any(Path(f"/proc/{pid}").exists() for pid in workers), 60)
    before = {path.name: path.stat().st_mtime_ns for path in kept.glob("fit-*")}
    assert 2 <= len(before) < 6
    assert len(workers) >= 2
    # A project whose recording has changed since is fitted anew; the others are not.
    trial = legs / "leg_05" / "trials" / "00.csv"
    trial.write_text(trial.read_text().rstrip("\n") + "\n")
    subprocess.run([*command, str(tmp_path / "killed")], check=True, timeout=300)
    assert not kept.exists()
    assert main(["-q", "fit", str(legs), "--workers", "1", "--out", str(tmp_path / "whole")]) == 0
    same_bytes(tmp_path / "killed", tmp_path / "whole")
