"""Folders of small fit projects, and outputs compared file by file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from robustness.random_legs import Recorder, random_case
from synth.files.leg_file import write_leg
from synth.files.output import write_csv

RECORDER = Recorder(noise=0.1, counts=8192, rate=150.0, trials=2)


def folder_of_legs(folder: Path, count: int, recorder: Recorder = RECORDER) -> Path:
    """So many legs of three links, a project each: ``leg_00/fit.yaml``."""
    for number in range(count):
        case = random_case(1000 + number, recorder, links=3)
        place = folder / f"leg_{number:02d}"
        (place / "trials").mkdir(parents=True)
        write_leg(case.bare, place / "limb.leg.yaml")
        (place / "fit.yaml").write_text("kind: fit\nleg: limb.leg.yaml\ntrials: [trials/*.csv]\n")
        for index, trial in enumerate(case.trials):
            columns = {"time [s]": trial.time}
            for j, name in enumerate(case.leg.joint_names):
                columns[f"{name} [deg]"] = np.degrees(trial.angles[:, j])
            write_csv(place / "trials" / f"{index:02d}.csv", columns)
    return folder


def same_bytes(one: Path, other: Path) -> list[str]:
    """The files of both folders, which must be the same, to the byte."""
    names = [sorted(p.relative_to(f).as_posix() for p in f.rglob("*") if p.is_file()) for f in (one, other)]
    assert names[0] == names[1]
    for name in names[0]:
        assert (one / name).read_bytes() == (other / name).read_bytes(), name
    return names[0]
