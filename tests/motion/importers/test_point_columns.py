"""CSV with a point's coordinates in columns: spreadsheets, DLTdv, scripts around pose estimators."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motion.importers.simulated_leg import PARTS, RATE, angles, leg, pixels, points
from synth.arrays import Array
from synth.errors import UserError
from synth.files.import_mapping import Mapping
from synth.motion.importers.convert import ImportedRecording, import_file
from synth.swing.leg_model import Joint, Leg, Link

TIME, MEASURED = angles()
PLACES = points(MEASURED)  # m, z up
DOWN = pixels(PLACES)


def table(head: list[str], values: Array, separator: str = ",") -> str:
    rows = [separator.join("" if np.isnan(each) else f"{each:.9g}" for each in row) for row in values]
    return "\n".join([separator.join(head), *rows]) + "\n"


def with_time(places: Array) -> Array:
    return np.column_stack([TIME, places.reshape(len(TIME), -1)])


def imported(path: Path, text: str, **keys: Any) -> ImportedRecording:
    path.write_text(text)
    mapping = Mapping(**({"points": PARTS, "plane": ("x", "y")} | keys))
    return import_file(path, leg(), mapping, name=path.name, cut="keep")


@pytest.mark.parametrize(
    "title",
    ["{}_x", "{}.x", "{} X", "{}/x", "{}X", "x_{}", "X {}", "{}_x [mm]", "{} x (cm)"],
)
def test_usual_names_of_columns(tmp_path: Path, title: str) -> None:
    heads = [title.replace("{}", part) for part in PARTS]
    vertical = title.replace("x", "y").replace("X", "Y")
    both = [each for x, part in zip(heads, PARTS, strict=True) for each in (x, vertical.replace("{}", part))]
    found = imported(tmp_path / "a.csv", table(["time [s]", *both], with_time(PLACES)))
    assert found.format == "csv-points"
    np.testing.assert_allclose(found.time, TIME, atol=1e-12)
    np.testing.assert_allclose(np.degrees(found.angles), MEASURED, atol=1e-5)


def test_numbered_columns_and_rows_as_frames(tmp_path: Path) -> None:
    numbers = [str(k + 1) for k in range(len(PARTS))]
    head = [f"{axis}{k}" for k in numbers for axis in "xy"]
    found = imported(tmp_path / "a.csv", table(head, DOWN.reshape(len(TIME), -1)),
                     points=tuple(numbers), frame_rate=RATE, plane=("x", "-y"))  # fmt: skip
    np.testing.assert_allclose(found.time, TIME, atol=1e-12)
    np.testing.assert_allclose(np.degrees(found.angles), MEASURED, atol=1e-4)


@pytest.mark.parametrize(
    "rows",
    [
        (",hip,,knee,,ankle,,toe,", "time [s],x,y,x,y,x,y,x,y"),
        ("time [s],hip,hip,knee,knee,ankle,ankle,toe,toe", ",X,Y,X,Y,X,Y,X,Y"),
        (",hip,,knee,,ankle,,toe,", "time,x,y,x,y,x,y,x,y", "s,mm,mm,mm,mm,mm,mm,mm,mm"),
        ("sep=,", "t [s],hip,,knee,,ankle,,toe,", ",x,y,x,y,x,y,x,y"),
    ],
)
def test_names_in_a_row_above_x_and_y(tmp_path: Path, rows: tuple[str, ...]) -> None:
    numbers = table([], with_time(PLACES)).lstrip("\n")
    found = imported(tmp_path / "a.csv", "\n".join([*rows, numbers]))
    np.testing.assert_allclose(found.time, TIME, atol=1e-12)
    np.testing.assert_allclose(np.degrees(found.angles), MEASURED, atol=1e-5)


def test_dltdv_in_space_with_its_gaps(tmp_path: Path) -> None:
    # DLTdv8's xyzpts.csv: pt1_X, pt1_Y, pt1_Z, NaN where a point was not digitised, a row a frame
    space = np.stack([PLACES[..., 0], np.full(PLACES.shape[:2], 0.3), PLACES[..., 1]], axis=-1)
    head = [f"pt{k + 1}_{axis}" for k in range(len(PARTS)) for axis in "XYZ"]
    text = table(head, space.reshape(len(TIME), -1)).split("\n")
    text[40] = ",".join(["NaN"] * 3 + text[40].split(",")[3:])  # sample 39
    names = tuple(f"pt{k + 1}" for k in range(len(PARTS)))
    found = imported(tmp_path / "xyzpts.csv", "\n".join(text), points=names, frame_rate=RATE, plane=("x", "z"))
    expected = MEASURED.copy()
    expected[39, :2] = np.nan
    np.testing.assert_allclose(np.degrees(found.angles), expected, atol=1e-5)
    with pytest.raises(UserError, match=r"points are in space: give the axes .* \[fit, z\]"):
        imported(tmp_path / "xyzpts.csv", "\n".join(text), points=names, frame_rate=RATE, plane=None)


def test_points_below_the_likelihood_are_missing(tmp_path: Path) -> None:
    sure = np.where(np.arange(len(TIME)) == 50, 0.2, 0.9)
    columns = np.column_stack([np.column_stack([DOWN[:, k], sure]) for k in range(len(PARTS))])
    head = ["frame", *(f"{part}_{word}" for part in PARTS for word in ("x", "y", "visibility"))]
    text = table(head, np.column_stack([np.arange(len(TIME)), columns]))
    given = {"frame_rate": RATE, "plane": ("x", "-y"), "likelihood": 0.5}
    found = imported(tmp_path / "a.csv", text, **given)
    expected = MEASURED.copy()
    expected[50] = np.nan
    np.testing.assert_allclose(np.degrees(found.angles), expected, atol=1e-4)
    assert any("the visibility of" in note and "taken as missing" in note for note in found.notes)
    with pytest.raises(UserError, match="has no likelihood of all its points"):
        imported(tmp_path / "b.csv", table(["t [s]", *(f"{p}_{a}" for p in PARTS for a in "xy")], with_time(DOWN)),
                 plane=("x", "-y"), likelihood=0.5)  # fmt: skip


def test_a_clock_of_another_name_in_a_table_with_semicolons(tmp_path: Path) -> None:
    head = ["stamp", *(f"{part}_{axis}" for part in PARTS for axis in "xy")]
    values = with_time(PLACES)
    values[:, 0] *= 1e3
    text = table(head, values, ";").replace(".", ",")
    found = imported(tmp_path / "a.csv", text, time="stamp", time_unit="ms")
    np.testing.assert_allclose(found.time, TIME, atol=1e-9)
    np.testing.assert_allclose(np.degrees(found.angles), MEASURED, atol=1e-5)


HEAD = ["time [s]", *(f"{part}_{axis}" for part in PARTS for axis in "xy")]


@pytest.mark.parametrize(
    ("head", "keys", "message"),
    [
        (HEAD, {"plane": None}, r"say which way y counts: plane: \[x, y\] upward .* \[x, -y\] downward"),
        (HEAD, {"points": ("hip", "knee", "ankle", "hoof")}, 'there is no point "hoof"'),
        (["time [s]", *(f"{part} {word}" for part in PARTS for word in ("angle", "rate"))], {},
         "has no x and y of a point in its columns"),
        ([*HEAD[:-2], f"{PARTS[-1]}_x [mm]", f"{PARTS[-1]}_y [mm]"], {}, "its points are in different units: none, mm"),
        (["clock", *HEAD[1:]], {}, "say which column is the clock"),
    ],
)  # fmt: skip
def test_what_is_missing_is_told(tmp_path: Path, head: list[str], keys: dict[str, Any], message: str) -> None:
    with pytest.raises(UserError, match=message):
        imported(tmp_path / "a.csv", table(head, with_time(PLACES)), **keys)


def test_angles_named_like_points_stay_angles(tmp_path: Path) -> None:
    # Visual3D names the three angles of a joint X, Y and Z: without points they are what they were.
    joints = leg().joint_names
    head = ["time [s]", *(f"{joint}{axis} [deg]" for joint in joints for axis in "XYZ")]
    turned = np.repeat(MEASURED, 3, axis=1)
    path = tmp_path / "a.csv"
    path.write_text(table(head, np.column_stack([TIME, turned])))
    with pytest.raises(UserError) as raised:
        import_file(path, leg(), Mapping(), name="a.csv", cut="keep")
    assert "there is no column" in str(raised.value)


def test_an_import_that_names_no_points_is_told_of_them(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text(table(HEAD, with_time(PLACES)))
    with pytest.raises(UserError) as raised:
        import_file(path, leg(), Mapping(), name="a.csv", cut="keep")
    assert f"its columns hold points ({', '.join(PARTS)})" in str(raised.value)
    assert "(--points)" in str(raised.value)


def test_fractions_of_a_pictures_sides_are_told(tmp_path: Path) -> None:
    head = ["time [s]", *(f"{part}_{axis}" for part in PARTS for axis in "xy")]
    low, wide = np.nanmin(DOWN, axis=(0, 1)), np.nanmax(DOWN, axis=(0, 1))
    for size, told in (([1280.0, 720.0], True), ([1.0, 1.0], False)):
        places = (DOWN - low) / (wide - low) * [640.0, 360.0] / size
        found = imported(tmp_path / "a.csv", table(head, with_time(places)), plane=("x", "-y"))
        assert any("fractions of the picture" in note for note in found.notes) == told


# The first samples of ``report2/8047.txt`` of github.com/jiarui-wen/PHY180-Pendulum-Project: a bob in Tracker's
# coordinates, in m from the pivot, rounded.
BOB = """0 0.41439 -1.4155
0.033333 0.41161 -1.4153
0.066667 0.40592 -1.4162
0.1 0.39751 -1.4188
0.13333 0.38699 -1.4215
0.16667 0.37256 -1.4246
0.2 0.35514 -1.4292
0.23333 0.33581 -1.4331
0.26667 0.31319 -1.4376
0.3 0.28807 -1.4414
0.33333 0.26072 -1.446
0.36667 0.23319 -1.4506
0.4 0.2032 -1.4548"""


@pytest.mark.parametrize(
    ("heads", "point"),
    [(["t [s]\tx\ty"], "point"), (["mass_A\t\t", "t [s]\tx\ty"], "mass_A"), (["A", "t [s]\tx\ty"], "A")],
)
def test_a_bob_alone_hangs_from_the_origin(tmp_path: Path, heads: list[str], point: str) -> None:
    """As Tracker exports one mass: there was no point that one could name for the pivot."""
    path = tmp_path / "8047.txt"
    path.write_text("\n".join([*heads, BOB.replace(" ", "\t")]) + "\n")
    pivot = Leg("bob", (Joint("pivot", Link(1.475, 0.2, 1.47, 1e-4)),))
    found = import_file(path, pivot, Mapping(points=("origin", point), plane=("x", "y")), name="8047.txt", cut="keep")
    bob = np.array(BOB.split(), float).reshape(-1, 3)
    np.testing.assert_allclose(found.time, bob[:, 0], atol=1e-12)
    np.testing.assert_allclose(found.angles[:, 0], np.arctan2(bob[:, 1], -bob[:, 2]), atol=1e-9)
    with pytest.raises(UserError, match=rf"write points: \[origin, {point}\]"):
        import_file(path, pivot, Mapping(), name="8047.txt", cut="keep")
