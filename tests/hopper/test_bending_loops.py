"""A link's bending rate from pairs of loading and unloading.

``LOOP`` : a laminate link, every third pair from 0 to 39 deg and back of
``spring/characterization-v2/results_20mm_1slope1.csv`` of github.com/iicfcii/laminate-leg, rounded.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from synth.files.bending_pairs import read_bending
from synth.files.hopper_project import read_hopper_project

EXAMPLE = Path(__file__).resolve().parents[2] / "synth" / "examples" / "hopper" / "hopper.yaml"
LOOP = """deflection [deg],torque [N*mm]
0.00,-0.01
-5.28,-18.30
-10.56,-35.35
-15.84,-50.78
-21.12,-61.28
-26.40,-77.00
-31.68,-91.77
-36.96,-108.24
-35.20,-56.77
-29.92,-41.00
-24.64,-25.97
-19.36,-13.67
-14.08,-0.30
-8.80,13.55
-3.52,26.63
"""


def test_a_link_that_is_loaded_and_unloaded_has_one_rate(tmp_path: Path) -> None:
    """It was "no straight line"; each way alone gives 0.162 and 0.149 N*m/rad."""
    (tmp_path / "pairs.csv").write_text(LOOP)
    found = read_bending(tmp_path / "pairs.csv", "pairs.csv")
    assert found.rate == pytest.approx(0.156, rel=0.02)
    assert found.loop == pytest.approx(0.044, rel=0.1)
    text = EXAMPLE.read_text().replace("beam_rate: 14.0224 N*m/rad", "bending: pairs.csv")
    (tmp_path / "hopper.yaml").write_text(text)
    told = [d.reason for d in read_hopper_project(tmp_path / "hopper.yaml").defaults if d.key == "laminate.beam_rate"]
    assert "between loading and unloading" in told[0]


def test_noise_of_both_ways_is_no_loop(tmp_path: Path) -> None:
    degrees = np.concatenate([np.linspace(0.0, 6.0, 10), np.linspace(6.0, 0.0, 10)])
    for seed in range(20):
        noise = np.random.default_rng(seed).standard_normal((2, 20))
        pairs = np.column_stack([degrees + 0.1 * noise[0], 12.0 * np.radians(degrees) + 0.02 * noise[1]])
        rows = [f"{x},{y}" for x, y in pairs.tolist()]
        (tmp_path / "pairs.csv").write_text("\n".join(["deflection [deg],torque [N*m]", *rows]) + "\n")
        assert read_bending(tmp_path / "pairs.csv", "pairs.csv").loop == 0.0
