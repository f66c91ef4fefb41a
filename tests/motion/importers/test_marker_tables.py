"""Marker tables of Vicon Nexus, Qualisys and OptiTrack Motive, written in their layouts from a leg that is known.

Layouts: Vicon Nexus, *Export ASCII*; Qualisys, QTM user manual, *Motion data (.tsv)*; OptiTrack, *Data Export: CSV*,
format versions 1.2 to 1.25.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from motion.importers.simulated_leg import PARTS, RATE, angles, leg, points
from synth.errors import UserError
from synth.files.import_mapping import Mapping
from synth.motion.importers.convert import ImportedRecording, import_file

Array = NDArray[np.float64]
TIME, MEASURED = angles()
MAPPING = Mapping(points=PARTS)
GAP = slice(200, 220)  # frames in which the ankle's marker is hidden


def imported(path: Path, mapping: Mapping = MAPPING) -> ImportedRecording:
    return import_file(path, leg(), mapping, name=path.name, cut="keep")


def refusal(path: Path, mapping: Mapping = MAPPING) -> str:
    with pytest.raises(UserError) as caught:
        imported(path, mapping)
    return str(caught.value)


def check(found: ImportedRecording, form: str, gap: slice = slice(0, 0), time: Array = TIME) -> None:
    """The angles went in as they are; hip sees no ankle, so only knee and ankle are missing in the gap."""
    expected = MEASURED.copy()
    expected[gap, 1:] = np.nan
    assert found.format == form
    np.testing.assert_allclose(np.degrees(found.angles), expected, atol=2e-3)  # of coordinates to a micrometre
    np.testing.assert_allclose(found.time - found.time[0], time, atol=1e-5)


def space(up: int, unit: float = 1e3) -> Array:
    """(n, 4, 3) in ``1 / unit`` m: the leg hangs at 0.9 m, its plane 0.12 m beside the origin."""
    flat = points(MEASURED)
    found = np.full((len(flat), len(PARTS), 3), 0.12)
    found[..., 0], found[..., up] = flat[..., 0] + 0.3, flat[..., 1] + 0.9
    return unit * found


def cells(row: Array, hidden: str | None = None, k: int | None = None) -> list[str]:
    """A frame's coordinates; ``hidden`` stands for each of the point ``k``."""
    return [f"{value:.4f}" if i != k or hidden is None else hidden for i, each in enumerate(row) for value in each]


def vicon(path: Path, before: Sequence[str] = (), separator: str = ",", first: int = 1) -> Path:
    lines = [*before, "Trajectories", f"{RATE:g}", ",," + ",,,".join(f"Rat:{part}" for part in PARTS)]
    lines += ["Frame,Sub Frame," + ",".join(["X,Y,Z"] * 4), ",," + ",".join(["mm"] * 12)]
    for k, row in enumerate(space(2)):
        hidden = "" if GAP.start <= k < GAP.stop else None
        lines.append(",".join([str(first + k), "0", *cells(row, hidden, 2)]))
    text = "\r\n".join([*lines, ""]) + "\r\n"
    path.write_bytes((text if separator == "," else text.replace(",", separator).replace(".", ",")).encode("utf-8-sig"))
    return path


EVENTS = ["Events", "200", "Subject,Context,Name,Time (s),Description", "Rat,Left,Foot Strike,0.97,", ""]
DEVICES = ["Devices", "1000", ",,Plate - Force,,", "Frame,Sub Frame,Fx,Fy,Fz", ",,N,N,N", "1,0,1,2,3", "1,1,1,2,3", ""]
MODEL = ["Model Outputs", "200", ",,Rat:HipAngles,,", "Frame,Sub Frame,X,Y,Z", ",,deg,deg,deg", "1,0,9,0,0", ""]


@pytest.mark.parametrize("before", [[], DEVICES, [*EVENTS, *DEVICES, *MODEL]])
@pytest.mark.parametrize("separator", [",", ";"])
def test_vicon_trajectories(tmp_path: Path, before: list[str], separator: str) -> None:
    check(imported(vicon(tmp_path / "a.csv", before, separator)), "vicon", GAP)


def test_vicon_of_a_cropped_trial_begins_at_its_own_frame(tmp_path: Path) -> None:
    found = imported(vicon(tmp_path / "a.csv", first=801))
    assert found.time[0] == pytest.approx(801 / RATE)
    check(found, "vicon", GAP)


def test_vicon_without_trajectories_tells_what_there_is(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("\n".join([*DEVICES, *MODEL]) + "\n")
    assert "no section Trajectories but Devices, Model Outputs" in refusal(tmp_path / "a.csv")


def test_a_point_of_two_subjects_is_asked_for(tmp_path: Path) -> None:
    path = vicon(tmp_path / "a.csv")
    path.write_text(path.read_text().replace("Rat:toe", "Cat:hip"))
    assert "several points: Rat:hip, Cat:hip" in refusal(path, Mapping(points=("hip", "knee", "ankle", "Cat:hip")))


def qualisys(path: Path, columns: str = "", hidden: str = "", version: bool = False, extra: Sequence[str] = ()) -> Path:
    settings = [f"NO_OF_FRAMES\t{len(TIME)}", "NO_OF_CAMERAS\t8", "NO_OF_MARKERS\t4", f"FREQUENCY\t{RATE:g}",
                "NO_OF_ANALOG\t0", "ANALOG_FREQUENCY\t0", "DESCRIPTION\t--",
                "TIME_STAMP\t2023-05-03, 10:22:13.113\t5031.54", "DATA_INCLUDED\t3D", *extra,
                "MARKER_NAMES\t" + "\t".join(PARTS)]  # fmt: skip
    if version:
        settings = ["FILE_VERSION\t2.0.0", *settings, "TRAJECTORY_TYPES\t" + "\t".join(["Measured"] * 4)]
    if columns == "named":
        settings.append("\t".join(["Frame", "Time", *(f"{part} {axis}" for part in PARTS for axis in "XYZ")]))
    lines = []
    for k, row in enumerate(space(2)):
        before = [] if not columns else [str(k + 1), f"{TIME[k]:.5f}"]
        lines.append("\t".join([*before, *cells(row, hidden if GAP.start <= k < GAP.stop else None, 2)]))
    path.write_text("\r\n".join([*settings, *lines]) + "\r\n")
    return path


EVENT = "EVENT\tFoot down\t194\t0.97000"


@pytest.mark.parametrize("hidden", ["", "0.000", "NULL", "NaN"])
@pytest.mark.parametrize(("columns", "version"), [("", False), ("frame", False), ("named", True)])
def test_qualisys(tmp_path: Path, columns: str, version: bool, hidden: str) -> None:
    found = imported(qualisys(tmp_path / "a.tsv", columns, hidden, version, [EVENT, EVENT]))
    check(found, "qualisys", GAP)
    assert any("20 points at 0, 0, 0" in note for note in found.notes) == (hidden == "0.000")


def test_qualisys_of_another_kind_or_cut_off_is_refused(tmp_path: Path) -> None:
    path = qualisys(tmp_path / "a.tsv")
    whole = path.read_text()
    for change, told in (
        (whole.replace("INCLUDED\t3D", "INCLUDED\t2D"), "no 3D positions"),
        (whole.replace("MARKERS\t4", "MARKERS\t5"), "states 5 markers but names 4"),
        (whole[: len(whole) // 2].rpartition("\n")[0] + "\n", "cut off"),
        (whole.replace("FREQUENCY\t200", "FREQUENCY\t"), "FREQUENCY"),
    ):
        path.write_text(change)
        assert told in refusal(path)


def test_qualisys_with_two_clocks_is_refused(tmp_path: Path) -> None:
    path = qualisys(tmp_path / "a.tsv", "frame")
    path.write_text(path.read_text().replace("FREQUENCY\t200", "FREQUENCY\t100"))
    assert "two clocks: its times have 200 rows a second, and its header says 100 Hz" in refusal(path)


def motive(path: Path, version: str, unit: str = "Millimeters", notes: str = "", bodies: bool = False) -> Path:
    """``bodies`` : with a rigid body by quaternions, its expected markers and errors, before the measured ones."""
    scale = {"Millimeters": 1e3, "Meters": 1.0}[unit]
    types, names, quantities, axes = ([] for _ in range(4))
    if bodies:
        for kind, name, what, letters in (
            ("Rigid Body", "Shank", "Rotation", "XYZW"), ("Rigid Body", "Shank", "Position", "XYZ"),
            ("Rigid Body", "Shank", "Mean Marker Error", [""]),
            ("Rigid Body Marker", "Shank:ankle", "Position", "XYZ"),
            ("Rigid Body Marker", "Shank:ankle", "Marker Quality", [""]),
        ):  # fmt: skip
            for axis in letters:
                types, names = [*types, kind], [*names, name]
                quantities, axes = [*quantities, what], [*axes, axis]
    before = len(types)
    for part in PARTS:
        types, names = [*types, *["Marker"] * 3], [*names, *[f"Shank:{part}"] * 3]
        quantities, axes = [*quantities, *["Position"] * 3], [*axes, *"XYZ"]
    code = [""] if version >= "1.24" else []  # a column TimeCode
    head = f"Format Version,{version},Take Name,Take 1,Take Notes,{notes},Capture Frame Rate,{RATE:f},"
    head += f"Export Frame Rate,{RATE:f},Capture Start Frame,4000,Total Exported Frames,{len(TIME)},"
    head += f"Rotation Type,Quaternion,Length Units,{unit},Coordinate Space,Global"
    rows = [["", "Type", *code, *types], ["", "Name", *code, *names], ["", "ID", *code, *names]]
    rows += [["", "Parent", *code, *types]] if version >= "1.25" else []
    rows += [["", "", *code, *quantities], ["Frame", "Time (Seconds)", *(["TimeCode"] if code else []), *axes]]
    for k, row in enumerate(space(1, scale)):
        hidden = "" if GAP.start <= k < GAP.stop else None
        start = [str(4000 + k), f"{20 + TIME[k]:.6f}", *(["15:26:46:12"] if code else [])]
        values = [f"{value:.6f}" if hidden is None or i != 2 else "" for i, each in enumerate(row) for value in each]
        rows.append([*start, *["0.5"] * before, *values])
    path.write_text("\n".join([head, "", *(",".join(row) for row in rows)]) + "\n")
    return path


@pytest.mark.parametrize("bodies", [False, True])
@pytest.mark.parametrize(("version", "unit"), [("1.2", "Meters"), ("1.23", "Millimeters"), ("1.25", "Millimeters")])
def test_motive(tmp_path: Path, version: str, unit: str, bodies: bool) -> None:
    found = imported(motive(tmp_path / "a.csv", version, unit, bodies=bodies))
    check(found, "motive", GAP)
    assert found.tracked is not None
    assert found.tracked.scale == pytest.approx({"Meters": 1.0, "Millimeters": 1e-3}[unit], rel=1e-5)
    assert any("1 expected positions" in note for note in found.notes) == bodies


def test_motive_s_notes_with_a_comma_shift_no_setting(tmp_path: Path) -> None:
    check(imported(motive(tmp_path / "a.csv", "1.23", notes="left leg, second try")), "motive", GAP)


def test_motive_without_measured_markers_is_refused(tmp_path: Path) -> None:
    path = motive(tmp_path / "a.csv", "1.23")
    path.write_text(path.read_text().replace(",Marker", ",Rigid Body Marker"))
    assert "export it with Markers on (4 expected positions" in refusal(path)


@pytest.mark.parametrize("write", [vicon, qualisys, lambda path: motive(path, "1.23")])
def test_a_cell_that_is_no_number_is_told_with_its_line(tmp_path: Path, write: Callable[[Path], Path]) -> None:
    path = write(tmp_path / "a.csv")
    lines = path.read_text(encoding="utf-8-sig").splitlines()
    separator = "\t" if "\t" in lines[-2] else ","
    lines[150] = separator.join([*lines[150].split(separator)[:-1], "12.3.4"])
    path.write_text("\n".join(lines) + "\n")
    assert '"12.3.4" is not a number' in refusal(path)
    assert "151" in refusal(path)
