"""DeepLabCut's CSV, written by pandas as DeepLabCut writes it: joint angles of a leg whose angles are known."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray

from motion.importers.simulated_leg import PARTS, RATE, angles, leg, pixels, points
from synth.errors import UserError
from synth.files.import_mapping import Mapping
from synth.motion.importers.convert import ImportedRecording, import_file

Array = NDArray[np.float64]
SCORER = "DLC_resnet50_ratSep1shuffle1_200000"
MAPPING = Mapping(points=PARTS, frame_rate=RATE)


def written(
    path: Path, places: dict[str, Array], likelihood: dict[str, Array] | None = None, animal: str | None = None
) -> Path:
    """As ``analyze_videos(save_as_csv=True)``: a table with column levels, by pandas' ``to_csv``."""
    columns: list[tuple[str, ...]] = []
    data: list[Array] = []
    for part, xy in places.items():
        certain = np.full(len(xy), 0.999)
        for coordinate, values in zip(
            ("x", "y", "likelihood"), (*xy.T, (likelihood or {}).get(part, certain)), strict=True
        ):
            levels = (SCORER, part, coordinate) if animal is None else (SCORER, *part.split("/", 1), coordinate)
            columns.append(levels)
            data.append(values)
    names = ["scorer", "bodyparts", "coords"]
    names = names if animal is None else ["scorer", "individuals", "bodyparts", "coords"]
    table = pd.DataFrame(np.column_stack(data), columns=pd.MultiIndex.from_tuples(columns, names=names))
    table.to_csv(path)
    return path


def parts(places: Array) -> dict[str, Array]:
    return {part: places[:, k] for k, part in enumerate(PARTS)}


def imported(path: Path, mapping: Mapping = MAPPING, **options: object) -> ImportedRecording:
    return import_file(path, leg(), mapping, name=path.name, cut="keep", **options)  # type: ignore[arg-type]


def test_angles_are_recovered_unchanged(tmp_path: Path) -> None:
    time, measured = angles()
    found = imported(written(tmp_path / "a.csv", parts(pixels(points(measured)))))
    assert found.format == "deeplabcut"
    np.testing.assert_allclose(found.time, time, atol=1e-12)
    np.testing.assert_allclose(np.degrees(found.angles), measured, atol=1e-9)
    assert found.tracked is not None
    assert found.tracked.scale == pytest.approx(1e-3)
    assert found.notes == (found.release.sentence, found.notes[-1]) if found.release else False


@pytest.mark.parametrize(("mirror", "roll"), [(True, 0.0), (False, 12.0), (True, -7.0), (True, 10.0)])
def test_the_other_side_and_a_turned_camera(tmp_path: Path, mirror: bool, roll: float) -> None:
    """The picture from the other side, turned counter-clockwise by ``roll`` as one sees it."""
    _, measured = angles()
    places = points(measured) * [-1 if mirror else 1, 1]
    cosine, sine = np.cos(np.radians(roll)), np.sin(np.radians(roll))
    turned = places @ np.array([[cosine, sine], [-sine, cosine]])  # counter-clockwise by `roll`
    mapping = Mapping(points=PARTS, frame_rate=RATE, mirror=mirror, roll=np.radians(roll))
    found = imported(written(tmp_path / "a.csv", parts(pixels(turned))), mapping)
    np.testing.assert_allclose(np.degrees(found.angles), measured, atol=1e-9)


def test_filmed_from_the_wrong_side_is_noticed(tmp_path: Path) -> None:
    _, measured = angles()
    places = points(measured) * [-1, 1]
    found = imported(written(tmp_path / "a.csv", parts(pixels(places))))
    assert any(
        note.startswith("knee: 100% of the samples lie outside its range [60, 175] deg; with the other sign")
        for note in found.notes
    )


def test_unlikely_points_are_masked_and_reported(tmp_path: Path) -> None:
    _, measured = angles()
    certainty = np.full(len(measured), 0.95)
    certainty[40:52], certainty[100] = 0.2, 0.59
    places = parts(pixels(points(measured)))
    places["ankle"][40:52] += 300.0
    found = imported(written(tmp_path / "a.csv", places, {"ankle": certainty}))
    missing = np.isnan(found.angles)
    assert not missing[:, 0].any()
    np.testing.assert_array_equal(np.flatnonzero(missing[:, 1]), [*range(40, 52), 100])
    np.testing.assert_array_equal(missing[:, 1], missing[:, 2])
    np.testing.assert_allclose(np.degrees(found.angles[~missing[:, 1]]), measured[~missing[:, 1]], atol=1e-9)
    assert "the likelihood of 13 points (all body parts) is below 0.6: taken as missing" in found.notes
    assert (
        "knee: 13 of 300 samples are missing and not filled; the longest gap is 65 ms, from 0.195 s on" in found.notes
    )
    stricter = imported(tmp_path / "a.csv", Mapping(points=PARTS, frame_rate=RATE, likelihood=0.1))
    assert not np.isnan(stricter.angles[100]).any()


def test_exchanged_left_and_right_are_restored(tmp_path: Path) -> None:
    _, measured = angles()
    near_side = pixels(points(measured))
    far_side = pixels(points(measured[::-1]), corner=(700.0, 90.0))
    places = {f"{part}_L": near_side[:, k].copy() for k, part in enumerate(PARTS)}
    places |= {f"{part}_R": far_side[:, k].copy() for k, part in enumerate(PARTS)}
    for part, frames in (("knee", range(60, 75)), ("toe", range(200, 203))):
        one, other = places[f"{part}_L"], places[f"{part}_R"]
        one[frames], other[frames] = other[frames].copy(), one[frames].copy()
    mapping = Mapping(points=tuple(f"{part}_L" for part in PARTS), frame_rate=RATE)
    found = imported(written(tmp_path / "a.csv", places), mapping)
    np.testing.assert_allclose(np.degrees(found.angles), measured, atol=1e-9)
    assert "knee_L: left and right are exchanged in 15 frames (1 stretches); restored" in found.notes
    assert "toe_L: left and right are exchanged in 3 frames (1 stretches); restored" in found.notes


def test_a_misplaced_point_shows_by_the_length_of_its_links(tmp_path: Path) -> None:
    _, measured = angles()
    places = pixels(points(measured))
    places[150:160, 1], places[150:160, 2] = places[150:160, 2].copy(), places[150:160, 1].copy()  # knee, ankle
    found = imported(written(tmp_path / "a.csv", parts(places)))
    assert np.isnan(found.angles[150:160, 1:]).all()
    assert any("link below the hip is more than 20% too long or short in 10 frames" in note for note in found.notes)
    kept = np.r_[0:150, 160:300]
    np.testing.assert_allclose(np.degrees(found.angles[kept]), measured[kept], atol=1e-9)


def test_points_in_the_wrong_order_are_questioned(tmp_path: Path) -> None:
    _, measured = angles()
    path = written(tmp_path / "a.csv", parts(pixels(points(measured))))
    found = imported(path, Mapping(points=("hip", "ankle", "knee", "toe"), frame_rate=RATE))
    assert any("than in the leg file (relative to the whole leg): are the points in order?" in n for n in found.notes)


def test_one_animal_of_several(tmp_path: Path) -> None:
    _, measured = angles()
    places = {f"rat1/{part}": xy for part, xy in parts(pixels(points(measured))).items()}
    places |= {f"rat2/{part}": xy + 50 for part, xy in parts(pixels(points(measured[::-1]))).items()}
    path = written(tmp_path / "a.csv", places, animal="yes")
    mapping = Mapping(points=PARTS, frame_rate=RATE, individual="rat1")
    np.testing.assert_allclose(np.degrees(imported(path, mapping).angles), measured, atol=1e-9)
    with pytest.raises(UserError, match="contains 2 animals; choose one: individual: rat1, or one of rat2"):
        imported(path)
    with pytest.raises(UserError, match='no individual "rat3"; did you mean rat'):
        imported(path, Mapping(points=PARTS, frame_rate=RATE, individual="rat3"))


@pytest.mark.parametrize(
    ("mapping", "message"),
    [
        (Mapping(points=PARTS), r"has no clock: state the camera's frame rate, frame_rate: 250 Hz"),
        (
            Mapping(frame_rate=RATE),
            r"points: \[hip, knee, ankle, tip\] \(--points\); the file has hip, knee, ank",
        ),
        (Mapping(points=PARTS[:3], frame_rate=RATE), r"points: 3 points are named; robot has 3 joints and needs 4"),
        (Mapping(points=("hip", "kne", "ankle", "toe"), frame_rate=RATE), r'no point "kne"; did you mean knee\?'),
        (Mapping(points=("hip", "knee", "knee", "toe"), frame_rate=RATE), r"a point is listed twice"),
        (Mapping(points=PARTS, frame_rate=RATE, plane=("x", "z")), r"plane: does not apply to a file of format deep"),
        (Mapping(points=PARTS, frame_rate=RATE, individual="a"), r'no individual "a"; the file has one animal'),
    ],
)
def test_mistakes_of_the_mapping(tmp_path: Path, mapping: Mapping, message: str) -> None:
    path = written(tmp_path / "a.csv", parts(pixels(points(angles()[1]))))
    with pytest.raises(UserError, match=message):
        imported(path, mapping)


def test_manual_labels_and_hdf5_are_refused_with_the_way_to_convert_them(tmp_path: Path) -> None:
    places = parts(pixels(points(angles()[1])))
    written(tmp_path / "a.csv", places)
    table = pd.read_csv(tmp_path / "a.csv", header=[0, 1, 2], index_col=0)
    by_hand = table.drop(columns="likelihood", level="coords")
    by_hand.to_csv(tmp_path / "CollectedData_me.csv")
    with pytest.raises(UserError, match="no likelihood: these are manual training labels"):
        imported(tmp_path / "CollectedData_me.csv")
    table.index = [f"labeled-data/v/img{k}.png" for k in table.index]
    table.to_csv(tmp_path / "images.csv")
    with pytest.raises(UserError, match=r'images.csv:4: "labeled-data/v/img0.png" is not a frame\'s number'):
        imported(tmp_path / "images.csv")
    (tmp_path / "a.h5").write_bytes(b"\x89HDF\r\n\x1a\n")
    with pytest.raises(UserError, match="HDF5 of an unknown program"):
        imported(tmp_path / "a.h5")


def test_lightning_pose_s_smoother_adds_columns(tmp_path: Path) -> None:
    """As ensemble Kalman smoothing (eks) writes its table: medians and variances beside x, y, likelihood."""
    time, measured = angles()
    columns, data = [], []
    for k, part in enumerate(PARTS):
        x, y = pixels(points(measured))[:, k].T
        more = {"x_ens_median": x + 30.0, "y_ens_median": y - 30.0, "x_ens_var": 0.1 * np.ones_like(x)}
        for coordinate, values in {"x": x, "y": y, "likelihood": np.full_like(x, 0.99), **more}.items():
            columns.append(("ensemble-kalman_tracker", part, coordinate))
            data.append(values)
    names = ["scorer", "bodyparts", "coords"]
    pd.DataFrame(np.column_stack(data), columns=pd.MultiIndex.from_tuples(columns, names=names)).to_csv(
        tmp_path / "a.csv"
    )
    found = imported(tmp_path / "a.csv")
    np.testing.assert_allclose(found.time, time, atol=1e-12)
    np.testing.assert_allclose(np.degrees(found.angles), measured, atol=1e-9)
