"""Dense recordings are averaged in groups: stated noise is of one reading, and averaging is no doubt."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from diagnosis.simulated_releases import ONE, recorded
from synth.diagnosis.check.finding import finding_of_remark, merge_alike
from synth.diagnosis.check.run import check
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import scene_of
from synth.files.gap_project import GapProject, Tolerance, read_gap_project
from synth.files.leg_file import write_leg
from synth.fit.recordings import recordings, sentences_on_reading
from synth.fit.sensor_noise import estimate_sensor
from synth.rehearsal.case_files import write_case
from synth.rehearsal.plants import Planted
from synth.rehearsal.users_rig import users_rig

NOISE = np.radians(0.08)
DENSE = tuple(recorded(ONE, away=np.array([[0.5], [-0.4]]), time=np.arange(20_001) * 1e-4, noise=NOISE, held_out=0))
MADE = recordings(ONE, DENSE, ())
GROUP = MADE[0].averaged[0]


def test_of_means_it_is_less() -> None:
    """0.08 deg of each reading was 0.08 deg of each mean of seven."""
    assert GROUP > 2
    read = estimate_sensor(MADE)
    assert read.stated(("knee",), {"knee": NOISE}).noise[0] == pytest.approx(NOISE / np.sqrt(GROUP))
    assert read.noise[0] == pytest.approx(NOISE / np.sqrt(GROUP), rel=0.1)
    (scene, _), (other, _) = (scene_of(ONE, DENSE, Tolerance(), 0, each) for each in ({"knee": NOISE}, None))
    assert scene.bench.noise[0] == pytest.approx(other.bench.noise[0], rel=0.1)
    sparse = recordings(ONE, recorded(ONE, away=np.array([[0.5]]), noise=NOISE, held_out=0), ())
    assert estimate_sensor(sparse).stated(("knee",), {"knee": NOISE}).noise[0] == NOISE


def test_the_middle_reading_of_a_group_has_its_own() -> None:
    """It stands for a group of coarse counts."""
    count = np.radians(0.5)
    coarse = [replace(t, angles=np.round(t.angles / count) * count) for t in DENSE]
    made = recordings(ONE, coarse, ())
    assert all(each.averaged == (1,) for each in made)
    assert estimate_sensor(made).stated(("knee",), {"knee": NOISE}).noise[0] == NOISE


def test_a_rehearsal_scatters_the_means_as_much(tmp_path: Path) -> None:
    (tmp_path / "gap.yaml").write_text("kind: gap\nleg: my.leg.yaml\ntrials: [a.csv]\nnoise: {knee: 0.08 deg}\n")
    write_leg(ONE, tmp_path / "my.leg.yaml")
    own = GapProject(tmp_path / "gap.yaml", ONE.name, ONE, DENSE, Tolerance(), 0, (), (), noise={"knee": NOISE})
    rig = users_rig(own)
    assert rig.noise[0] == pytest.approx(NOISE / np.sqrt(GROUP))
    (tmp_path / "case").mkdir()
    readings = tuple(ONE.to_measured(each.rotation) for each in MADE)
    case = read_gap_project(write_case(own, rig, Planted(readings, {}), tmp_path / "case"))
    assert case.noise["knee"] == pytest.approx(rig.noise[0])


def test_averaging_is_a_note_once_and_no_doubt() -> None:
    """Of two faultless recordings it was two doubts, among the eight findings that are shown."""
    texts = sentences_on_reading(MADE)
    found = merge_alike([finding_of_remark(text, [each.name for each in DENSE]) for text in texts])
    assert [(each.level, each.recording) for each in found] == [("note", f"{DENSE[0].name} and 1 more")]
    assert found[0].text.startswith("20001 samples over 2 s are more than the motion needs")
    assert finding_of_remark("3 of 5 trials", ["3"]).as_json()["level"] == "doubt"
    checked = check(GapProject(Path("gap.yaml"), ONE.name, ONE, DENSE, Tolerance(), 0, (), ()))
    assert not [each for each in checked.findings if each.level == "doubt" and "averaged" in each.text]
