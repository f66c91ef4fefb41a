"""Unseen releases: exact with the same leg in all; on the lab's recordings against a leg fitted to each release."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fit.simulated_legs import NAMES, Rig, release, robot
from synth.files.output import write_csv
from synth.validation.thesis_data import SEVEN, LabData, read_lab_data
from synth.validation.unseen_releases import unseen_table

LAB = Path(__file__).resolve().parents[3] / "shared" / "aarl"


def test_the_same_leg_in_all_releases_is_predicted_exactly(tmp_path: Path) -> None:
    leg, generator, rig = robot(), np.random.default_rng(0), Rig(noise=0.02, duration=1.2, rate=200.0)
    (tmp_path / "rat" / "releases").mkdir(parents=True)
    away = generator.choice([-1, 1], (12, 3)) * generator.uniform(12.0, 30.0, (12, 3))
    names = [*SEVEN, "IP_1", "GS_2", "ST_2", "VL_2", "BFa_2"]
    for name, start in zip(names, away, strict=True):
        trial = release(leg, start, generator, rig)
        columns = {"time [s]": trial.time}
        columns |= {f"{joint} [deg]": np.degrees(trial.angles[:, j]) for j, joint in enumerate(NAMES)}
        write_csv(tmp_path / "rat" / "releases" / f"{name}.csv", columns)
    table = unseen_table(LabData(tmp_path, leg, leg, leg, leg, {}, {}))
    assert table is not None
    for row in table.rows:
        for cell in row.cells[:3]:
            assert isinstance(cell, str)
            assert int(cell.removesuffix(" %")) <= 3
    (tmp_path / "rat" / "releases" / "BFa_2.csv").unlink()
    assert unseen_table(LabData(tmp_path, leg, leg, leg, leg, {}, {})) is None


@pytest.mark.skipif(not LAB.is_dir(), reason="the lab's recordings (../shared/aarl) are not here")
def test_the_leg_of_the_seven_predicts_the_others_as_well_as_their_own_legs() -> None:
    table = unseen_table(read_lab_data(LAB))
    assert table is not None
    assert "ST2_4" in table.differences[0]
    shares = {row.label: [int(str(cell).removesuffix(" %")) for cell in row.cells] for row in table.rows}
    for name in ("frequency", "damping ratio"):
        first, free, own, repeats = shares[name]
        assert free < first
        assert free <= 1.2 * own + 1
        assert repeats < own
