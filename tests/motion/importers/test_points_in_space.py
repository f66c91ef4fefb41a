"""Points in space against a leg whose angles are known: walking aslant to the axes, up or down, the base tilted."""

from __future__ import annotations

from dataclasses import replace
from math import cos, hypot, radians, sin
from pathlib import Path

import numpy as np
import pytest

from motion.importers.simulated_leg import PARTS, RATE, angles, leg, points
from synth.arrays import Array
from synth.files.import_mapping import Mapping
from synth.files.import_project import ForeignFile, ImportProject
from synth.motion.importers import convert
from synth.motion.importers.foreign_data import Markers
from synth.motion.importers.import_result import read_files
from synth.motion.importers.points import track
from synth.motion.importers.registry import formats

TILT = 15.0  # deg, of the leg's base


def in_space(flat: Array, forward: tuple[float, float], height: float) -> Array:
    """Points (n, m, 2) of a picture put upright into space, its x along ``forward``, its z times ``height`` along z."""
    x, y = (part / hypot(*forward) for part in forward)
    return np.stack([0.7 + x * flat[..., 0], -1.3 + y * flat[..., 0], 0.4 + height * flat[..., 1]], axis=-1)


@pytest.mark.parametrize("up", ["z", "-z"])
@pytest.mark.parametrize("forward", [(-1.0, 3.0), (1.0, 3.0), (3.0, -1.0)])
def test_a_fitted_plane_gives_the_angles_of_a_leg_that_walks_aslant(forward: tuple[float, float], up: str) -> None:
    """To the right is where the nearest axis of space grows: along -x + 3y that is y, although x falls."""
    measured = angles()[1]
    height = -1.0 if up == "-z" else 1.0
    space = in_space(points(measured, TILT), forward, height)
    markers = Markers("a.trc", PARTS, space, np.arange(float(len(space))), RATE, "m")
    found = track(markers, replace(leg(), tilt=radians(TILT)), Mapping(points=PARTS, plane=("fit", up)))
    np.testing.assert_allclose(leg().to_measured(found.rotation), np.radians(measured), atol=1e-6)


def test_the_base_s_tilt_is_no_turn_of_the_first_joint() -> None:
    """A leg that hangs straight down from a base tilted by 15 deg: its hip, zero along the base, stands at -15 deg."""
    straight = np.array([[0.0, 0.0], [0.0, -0.3], [0.0, -0.6], [0.0, -0.8]])
    space = np.repeat(straight[None], 4, axis=0)
    markers = Markers("a.csv", PARTS, space, np.arange(4.0), RATE, "m")
    found = track(markers, replace(leg(), tilt=radians(TILT)), Mapping(points=PARTS))
    np.testing.assert_allclose(np.degrees(found.rotation), np.tile([-15.0, 0.0, 0.0], (4, 1)), atol=1e-9)


def test_files_of_a_diagonal_walkway_are_seen_from_one_side(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Headings of -44 and -46 deg have other nearest axes: every other file came out mirrored, without a word."""
    headings = {"a.csv": -44.0, "b.csv": -46.0, "c.csv": -43.5, "d.csv": -47.0, "e.csv": 20.0}
    measured = angles()[1]

    def read(path: Path, *_: object) -> Markers:
        way = radians(headings[path.name])
        space = in_space(points(measured), (cos(way), sin(way)), 1.0)
        return Markers(path.name, PARTS, space, np.arange(float(len(space))), RATE, "m")

    monkeypatch.setattr(convert, "recognise", lambda *_, **_points: replace(formats()["trc"], read=read))
    files = tuple(ForeignFile(tmp_path / name, name) for name in headings)
    mapping = Mapping(points=PARTS, plane=("fit", "z"))
    found = read_files(ImportProject("walk", leg(), files, "auto", mapping, "keep"))
    for trial in found:
        np.testing.assert_allclose(np.degrees(trial.imported.angles), measured, atol=1e-4)
    notes = {trial.source.name: " ".join(trial.imported.notes) for trial in found}
    assert [name for name in headings if "as in the other files" in notes[name]] == ["b.csv", "d.csv"]
    assert [name for name in headings if "if it was seen from the other side" in notes[name]] == ["e.csv"]
