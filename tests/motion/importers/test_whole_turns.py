"""Whole turns of imported readings: which jumps are removed, and which turn the recordings of a project are on."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from fit.simulated_legs import robot
from synth.files.import_mapping import Mapping
from synth.files.import_project import ForeignFile, ImportProject
from synth.files.recording import read_recording
from synth.motion.importers.convert import import_file
from synth.motion.importers.import_result import read_files
from synth.swing.leg_model import Leg

Array = NDArray[np.float64]
TIME = np.arange(300) / 100.0


def one_joint(span: tuple[float, float] | None) -> Leg:
    """The hip alone, its range in deg."""
    leg = robot()
    hip = leg.with_joints(hip={"range": None if span is None else tuple(np.radians(span))}).joints[0]
    return Leg("one", (hip,), leg.gravity, leg.tilt)


def write(path: Path, angle: Array, time: Array = TIME) -> ForeignFile:
    rows = "\n".join(f"{t:.4f},{a:.6f}" for t, a in zip(time, angle, strict=True))
    path.write_text(f"time [s],hip [deg]\n{rows}\n")
    return ForeignFile(path, path.name)


def starts(leg: Leg, *files: ForeignFile) -> list[float]:
    """The first angle of each recording, deg, as a project imports them."""
    trials = read_files(ImportProject("p", leg, files, "auto", Mapping(), "keep"))
    return [round(float(np.degrees(trial.imported.angles[0, 0])), 6) for trial in trials]


def swing(middle: float) -> Array:
    return middle + 40.0 * np.exp(-TIME) * np.cos(8.0 * TIME)


def test_readings_inside_the_stated_range_stay(tmp_path: Path) -> None:
    files = [write(tmp_path / f"{name}.csv", swing(middle)) for name, middle in (("a", 530.0), ("b", 550.0))]
    assert starts(one_joint((0.0, 720.0)), *files) == [570.0, 590.0]


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_recordings_of_a_project_go_to_one_turn(tmp_path: Path, order: tuple[int, int]) -> None:
    """Half a turn from the joint's zero reading of 90 deg, on either side of it."""
    leg = one_joint(None)
    assert np.degrees(leg.joints[0].zero) == 90.0
    files = [write(tmp_path / "a.csv", swing(265.0)), write(tmp_path / "b.csv", swing(275.0))]
    found = starts(leg, *(files[k] for k in order))
    assert abs(found[0] - found[1]) == pytest.approx(10.0)


def test_an_encoder_that_counts_from_another_turn_is_shifted(tmp_path: Path) -> None:
    files = [write(tmp_path / "a.csv", swing(100.0)), write(tmp_path / "b.csv", swing(820.0))]
    assert starts(one_joint((0.0, 180.0)), *files) == [140.0, 140.0]


def spinning() -> Array:
    """Some 20 deg a sample at first, slowing down, deg."""
    return 90.0 + 2592.0 * (1.0 - np.exp(-TIME / 1.2))


def test_a_joint_that_turns_on_keeps_its_turns_over_lost_samples(tmp_path: Path) -> None:
    """As the reader of trials has it."""
    kept = np.r_[0:30, 42:300]
    file = write(tmp_path / "a.csv", spinning()[kept], TIME[kept])
    leg = one_joint((-4000.0, 4000.0))
    found = import_file(file.path, leg, Mapping(), name="a.csv", cut="keep")
    np.testing.assert_allclose(found.angles, read_recording(file.path, leg).angles, atol=1e-12)
    np.testing.assert_allclose(np.degrees(found.angles[:, 0]), spinning()[kept], atol=1e-5)


def test_a_wrapped_joint_that_turns_on_is_continued(tmp_path: Path) -> None:
    wrapped = (spinning() + 180.0) % 360.0 - 180.0
    found = starts(one_joint((-4000.0, 4000.0)), write(tmp_path / "a.csv", wrapped))
    assert found == [90.0]


def test_angles_that_no_shift_mends_stay_as_the_file_has_them(tmp_path: Path) -> None:
    assert starts(one_joint(None), write(tmp_path / "a.csv", spinning())) == [90.0]
