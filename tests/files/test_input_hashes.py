"""What a result depends on: every file that was read, also those that a leg or a jump design names."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from synth.files.gap_project import read_gap_project
from synth.files.hopper_gap_project import read_hopper_gap_project
from synth.files.input_hashes import input_hashes
from synth.files.leg_file import read_leg
from synth.files.projects import read_fit_project, read_leg_project

EXAMPLES = Path(__file__).resolve().parents[2] / "synth" / "examples"
LINK = "link: {length: 200 mm, mass: 0.7 kg, com: 90 mm, inertia: 3e-3 kg*m^2}"
PARTS = "spring: {rate: 3 N*m/rad, free_angle: 120 deg}, damper: {curve: curve.csv}"
LEG = f"kind: leg\nname: one\njoints:\n  - {{name: hip, zero: 90 deg, sign: +1, {LINK}, {PARTS}}}\n"
TRIALS = "time [s],hip [deg]\n" + "".join(f"{i / 100},{90 + i}\n" for i in range(12))
PROJECTS: dict[str, tuple[Callable[[Path], Any], str]] = {
    "fit": (read_fit_project, "kind: fit\nleg: legs/one.leg.yaml\ntrials: [a.csv]\n"),
    "gap": (read_gap_project, "kind: gap\nleg: legs/one.leg.yaml\ntrials: [a.csv]\n"),
    "leg": (
        read_leg_project,
        "kind: leg-design\nsource: {leg: legs/one.leg.yaml, trials: [a.csv]}\ntarget: legs/one.leg.yaml\n",
    ),
}


def write_curve(folder: Path, torque: float) -> None:
    (folder / "legs" / "curve.csv").write_text(f"speed [rad/s],torque [N*m]\n1,{torque}\n")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "legs").mkdir()
    (tmp_path / "legs" / "one.leg.yaml").write_text(LEG)
    (tmp_path / "a.csv").write_text(TRIALS)
    write_curve(tmp_path, 0.01)
    return tmp_path


@pytest.mark.parametrize("kind", PROJECTS)
def test_a_leg_s_damper_curve_is_an_input(kind: str, folder: Path) -> None:
    read, text = PROJECTS[kind]
    (folder / "project.yaml").write_text(text)
    before = input_hashes(read(folder / "project.yaml"))
    write_curve(folder, 0.05)
    after = input_hashes(read(folder / "project.yaml"))
    assert set(before) == {"project.yaml", "legs/one.leg.yaml", "legs/curve.csv", "a.csv"}
    assert {name for name in before if before[name] != after[name]} == {"legs/curve.csv"}


def test_a_leg_tells_which_files_it_opened(folder: Path) -> None:
    opened: list[Path] = []
    read_leg(folder / "legs" / "one.leg.yaml", opened=opened.append)
    assert opened == [folder / "legs" / "curve.csv"]


def test_files_that_a_jump_design_names_are_inputs_of_its_diagnosis(tmp_path: Path) -> None:
    shutil.copytree(EXAMPLES / "hopper", tmp_path / "project")
    design = tmp_path / "project" / "hopper.yaml"
    text = design.read_text().replace(", beam_rate: 14.0224 N*m/rad", ", bending: bend.csv")
    design.write_text(text)

    def hashes(rate: float) -> dict[str, str]:
        rows = "".join(f"{d},{d * rate}\n" for d in (1, 2, 3, 4))
        (design.parent / "bend.csv").write_text(f"deflection [deg],torque [N*m]\n{rows}")
        return input_hashes(read_hopper_gap_project(design.parent / "gap.yaml"))

    before, after = hashes(0.2), hashes(0.4)
    assert {name for name in before if before[name] != after[name]} == {"bend.csv"}
