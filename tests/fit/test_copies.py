"""A recording saved under two names is one measurement, and no check of itself."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from synth.cli import main
from synth.files.leg_file import write_leg
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

LEG = Leg("one link", (Joint("knee", Link(0.2, 0.4, 0.1, 1.5e-3), spring=Spring(1.2, 0.0), damper=Damper(0.04)),))
TIMES = np.arange(0.0, 1.2, 0.004)


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """Two releases and a copy of the first, some samples later and with fewer digits."""
    write_leg(LEG, tmp_path / "leg.leg.yaml")
    noise, head = np.random.default_rng(0), "time [s],knee [deg]"
    for name, start in (("a", 0.4), ("b", -0.3)):
        seen = np.degrees(simulate(LEG, [start], [0.0], TIMES)) + 0.03 * noise.normal(size=(len(TIMES), 1))
        table = np.c_[TIMES, seen]
        np.savetxt(tmp_path / f"{name}.csv", table, delimiter=",", header=head, comments="", fmt="%.8g")
        if name == "a":
            np.savetxt(tmp_path / "copy.csv", table[3:], delimiter=",", header=head, comments="", fmt="%.5g")
    return tmp_path


def fitted(folder: Path, trials: str, name: str) -> dict[str, Any]:
    (folder / "fit.yaml").write_text(f"kind: fit\nleg: leg.leg.yaml\ntrials: {trials}\n")
    assert main(["fit", str(folder / "fit.yaml"), "--out", str(folder / name), "-q"]) == 0
    found: dict[str, Any] = json.loads((folder / name / "fit.json").read_text())
    return found


def test_a_copy_adds_nothing_and_is_named(project: Path) -> None:
    alone, twice = fitted(project, "[a.csv, b.csv]", "alone"), fitted(project, "[a.csv, b.csv, copy.csv]", "twice")
    assert twice["joints"] == alone["joints"]
    assert [trial["file"] for trial in twice["trials"]] == ["a.csv", "b.csv"]
    assert any("copy.csv holds the same samples as a.csv and is left out" in text for text in twice["warnings"])
    assert not any("same samples" in text for text in alone["warnings"])


def test_a_held_out_copy_is_refused(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (project / "fit.yaml").write_text(
        "kind: fit\nleg: leg.leg.yaml\ntrials: [{file: copy.csv, held_out: true}, a.csv, b.csv]\n"
    )
    assert main(["fit", str(project / "fit.yaml"), "--out", str(project / "out")]) == 2
    said = capsys.readouterr().err
    assert "copy.csv is held out, but holds the same samples as a.csv, which is fitted" in said
    assert not (project / "out").exists()


def test_two_held_out_copies_are_scored_once(project: Path) -> None:
    trials = "[b.csv, {file: a.csv, held_out: true}, {file: copy.csv, held_out: true}]"
    found = fitted(project, trials, "out")
    assert [trial["file"] for trial in found["trials"]] == ["b.csv", "a.csv"]
    assert any("copy.csv holds the same samples as a.csv" in text for text in found["warnings"])
