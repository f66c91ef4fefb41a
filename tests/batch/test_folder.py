"""``synth fit`` on a folder: names, bad projects, the summary, and a run that is killed."""

from __future__ import annotations

import csv
import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from batch.clusters import wait_until
from batch.legs import folder_of_legs, same_bytes
from synth.batch import one_fit
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
    with pytest.raises(UserError, match="contains no project that can be fitted"):
        find_projects(tmp_path / "c")


KEYS = "leg: x.leg.yaml\ntrials: [a.csv]\n"
TEXTS = {
    "good.yaml": "kind: fit\n",
    "large.yaml": "kind: Fit\n",
    "typed.yaml": "kind: fti\n",
    "empty.yaml": f"kind:\n{KEYS}",
    "foreign.yaml": "kind: Deployment\nspec: {}\n",
    "keys.yaml": f"kind: motion\n{KEYS}",
    "number.yaml": f"kind: 3\n{KEYS}",
    "gap.yaml": "kind: Gap\n",
    "design.yaml": "kind: leg-desing\n",
    "bare.yaml": "source: {}\ntarget: x.leg.yaml\n",
}


@pytest.mark.parametrize(
    ("kind", "refused"),
    [
        ("fit", ["bare", "empty", "keys", "large", "number", "typed"]),
        ("gap", ["empty", "gap", "keys", "number"]),
        ("leg-design", ["bare", "design"]),
    ],
)
def test_a_project_whose_kind_is_misspelt_is_counted_and_named(tmp_path: Path, kind: str, refused: list[str]) -> None:
    for name, text in TEXTS.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "good.yaml").write_text(f"kind: {kind}\n")
    found = find_projects(tmp_path, kind)
    assert [item.name for item in found if not item.problems] == ["good"]
    assert [item.name for item in found if item.problems] == refused
    said = {item.name: str(item.problems[0].text) for item in found if item.problems}
    if kind == "fit":
        assert said["large"] == "'Fit' is no kind of file; did you mean fit?"
        assert said["bare"].endswith('write "kind: leg-design" as the first line')


def test_a_folder_run_fails_by_the_name_of_a_project_with_a_misspelt_kind(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    legs = folder_of_legs(tmp_path / "legs", 2)
    project = legs / "leg_01" / "fit.yaml"
    project.write_text(project.read_text().replace("kind: fit", "kind: Fit"))
    assert main(["fit", str(legs), "--dry-run", "--out", str(tmp_path / "out")]) == 2
    assert f"{project}:1: kind: 'Fit' is no kind of file; did you mean fit?" in capsys.readouterr().err


def names_of(folder: Path, *files: str) -> list[str]:
    """The names that projects in these files get."""
    for name in files:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text("kind: fit\n")
    return [item.name for item in find_projects(folder)]


def test_no_two_projects_share_a_name_and_none_lies_in_another_s_results(tmp_path: Path) -> None:
    assert names_of(tmp_path / "1", "a.yaml", "a.yml") == ["a.yaml", "a.yml"]
    assert names_of(tmp_path / "2", "a.yaml", "a/report.html.yaml") == ["a.yaml", "a/report.html"]
    assert names_of(tmp_path / "3", "a/fit.yaml", "a.yaml") == ["a.yaml", "a/fit"]
    assert names_of(tmp_path / "4", "a/fit.yaml", "a/fit.yml", "a.yaml.yaml") == ["a.yaml", "a/fit.yaml", "a/fit.yml"]
    assert names_of(tmp_path / "5", "a.yaml", "a.yml", "a.yaml.yml") == ["a.yaml", "a.yaml.yml", "a.yml"]


def test_projects_of_one_stem_and_names_that_are_no_text_stop_no_other(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    legs = folder_of_legs(tmp_path / "legs", 1)
    shutil.copy(legs / "leg_00" / "fit.yaml", legs / "leg_00" / "fit.yml")
    shutil.copy(legs / "leg_00" / "fit.yaml", legs / "leg_00" / os.fsdecode(b"b\xff.yaml"))
    (legs / "leg_00" / "fit").mkdir()
    (legs / "leg_00" / "fit" / "report.html.yaml").write_text("kind: fit\n")
    assert main(["fit", str(legs), "--out", str(tmp_path / "out"), "--quiet"]) == 2
    table, said = capsys.readouterr()
    rows = [line.split()[:2] for line in table.splitlines()[2:]]  # quiet prints just the table
    assert [name for name, state in rows if state == "failed"] == ["leg_00/b\\xff", "leg_00/fit/report.html"]
    assert {name for name, state in rows if state == "fitted"} == {"leg_00/fit.yaml", "leg_00/fit.yml"}
    assert said.startswith("synth: 2 of 4 projects could not be fitted:\n")
    assert "is not UTF-8 text; rename" in said
    fits = json.loads((tmp_path / "out" / "fits.json").read_text())
    assert [leg["name"] for leg in fits["legs"]] == ["leg_00/fit.yaml", "leg_00/fit.yml"]
    assert [item["name"] for item in fits["failed"]] == ["leg_00/b\\xff", "leg_00/fit/report.html"]
    assert (tmp_path / "out" / "legs" / "leg_00" / "fit.yml" / "report.html").is_file()


def test_a_fault_in_reading_one_project_stops_no_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    legs = folder_of_legs(tmp_path / "legs", 2)
    read = one_fit.read_fit_project

    def faulty(path: Path, **rest: Any) -> Any:
        if "leg_00" in str(path):
            raise ZeroDivisionError("a fault of ours")
        return read(path, **rest)

    monkeypatch.setattr(one_fit, "read_fit_project", faulty)
    assert main(["fit", str(legs), "--out", str(tmp_path / "out"), "--quiet"]) == 70
    assert "a fault of ours" in capsys.readouterr().err
    fits = json.loads((tmp_path / "out" / "fits.json").read_text())
    assert [leg["name"] for leg in fits["legs"]] == ["leg_01"]
    assert [item["crash"] for item in fits["failed"]] == [True]


def test_a_bad_project_stops_no_other_and_is_corrected_without_fitting_the_rest_again(
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


@pytest.mark.slow  # ``make kill`` kills folders too
def test_a_killed_run_leaves_no_process_and_resumes_to_the_same_bytes(tmp_path: Path) -> None:
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
    # A project whose recording has changed is fitted again; the others are not.
    trial = legs / "leg_05" / "trials" / "00.csv"
    trial.write_text(trial.read_text().rstrip("\n") + "\n")
    subprocess.run([*command, str(tmp_path / "killed")], check=True, timeout=300)
    assert not kept.exists()
    assert main(["-q", "fit", str(legs), "--workers", "1", "--out", str(tmp_path / "whole")]) == 0
    same_bytes(tmp_path / "killed", tmp_path / "whole")
