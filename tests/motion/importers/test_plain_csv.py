"""CSV of other loggers, written by pandas: names, units, separators, decimal commas; what is found in the angles."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from motion.importers.simulated_leg import angles, leg
from synth.errors import UserError
from synth.files.import_mapping import JointColumn, Mapping
from synth.motion.importers.convert import ImportedRecording, import_file
from synth.motion.importers.foreign_data import indices_of_name, other_side
from synth.motion.importers.plain_csv import read_plain_csv

PLAIN = Mapping()


def imported(path: Path, mapping: Mapping = PLAIN, **options: object) -> ImportedRecording:
    options = {"cut": "keep"} | options
    return import_file(path, leg(), mapping, name=path.name, **options)  # type: ignore[arg-type]


def table(*titles: str) -> pd.DataFrame:
    time, measured = angles()
    return pd.DataFrame(np.column_stack([time, measured]), columns=list(titles))


def test_our_own_header_needs_no_mapping(tmp_path: Path) -> None:
    table("time [s]", "hip [deg]", "knee [deg]", "ankle [deg]").to_csv(tmp_path / "a.csv", index=False)
    np.testing.assert_allclose(np.degrees(imported(tmp_path / "a.csv").angles), angles()[1], atol=1e-9)


def test_other_names_units_separator_decimal_comma_and_comments(tmp_path: Path) -> None:
    data = table("Time (ms)", "Hip_Angle (°)", "knee potentiometer", "Ankle (L)")
    data["Time (ms)"] *= 1e3
    data["knee potentiometer"] = np.radians(180.0 - data["knee potentiometer"])
    data["remark"] = "ok"
    text = "# logger 7\n% 3 channels\n" + data.to_csv(index=False, sep=";", decimal=",")
    (tmp_path / "a.csv").write_bytes(text.encode("cp1252"))
    columns = {
        "hip": JointColumn("hip angle"),
        "knee": JointColumn("knee potentiometer", unit="rad", zero=0.0, sign=-1),
        "ankle": JointColumn("Ankle (L)", unit="deg"),
    }
    found = imported(tmp_path / "a.csv", Mapping(joints=columns))
    np.testing.assert_allclose(np.degrees(found.angles), angles()[1], atol=1e-9)
    np.testing.assert_allclose(found.time, angles()[0], atol=1e-12)


@pytest.mark.parametrize("quoted", [True, False])
@pytest.mark.parametrize("separator", [";", "\t"])
def test_decimal_commas_and_commas_in_names(tmp_path: Path, separator: str, quoted: bool) -> None:
    """MATLAB's names and a spreadsheet's separators: the commas are as many as the separators, or more."""
    data = table("t", "theta(:,1)", "theta(:,2)", "theta(:,3)")
    text = data.to_csv(index=False, sep=separator, decimal=",")
    header, _, rest = text.partition("\n")
    assert '"' not in header
    if quoted:
        header = separator.join(f'"{name}"' for name in header.split(separator))
    (tmp_path / "a.csv").write_text(f"{header}\n{rest}")
    columns = {name: JointColumn(f"theta(:,{k})", unit="deg") for k, name in enumerate(("hip", "knee", "ankle"), 1)}
    found = imported(tmp_path / "a.csv", Mapping(joints=columns, time="t", time_unit="s"))
    np.testing.assert_allclose(np.degrees(found.angles), angles()[1], atol=1e-9)


def test_quoted_decimal_commas_between_commas_are_refused(tmp_path: Path) -> None:
    data = table("time [s]", "hip [deg]", "knee [deg]", "ankle [deg]").map("{:.6f}".format)
    data = data.map(lambda cell: cell.replace(".", ","))
    data["place, pair"] = "leg 1,2"  # a remark may have commas
    (tmp_path / "a.csv").write_text(data.to_csv(index=False))
    with pytest.raises(UserError) as caught:
        imported(tmp_path / "a.csv")
    assert len(caught.value.problems) == 4
    text = '"0,000000" is a number with a comma; write 0.000000, or semicolons between columns'
    assert text in str(caught.value)


def spreadsheet(clock: str, decimal: str) -> str:
    """Three samples from 2 s on, a clock in ms in that form, and an angle of 12.3 deg."""
    times = [clock.format(2000 + 5 * k).replace(",", "." if decimal == "," else ",") for k in range(3)]
    return "time [ms];hip [deg]\n" + "".join(f"{time};12{decimal}3\n" for time in times)


@pytest.mark.parametrize("decimal", [",", "."])
def test_a_spreadsheet_s_thousands_are_no_decimals(tmp_path: Path, decimal: str) -> None:
    """A clock of 2.000, 2.005, ... ms beside angles of 12,3 ran 1000 times too fast."""
    file = tmp_path / "a.csv"
    file.write_text(spreadsheet("{:,d}", decimal))
    mark = "." if decimal == "," else ","
    said = f'"2{mark}000" has a "{mark}" where "12{decimal}3" has a "{decimal}": write 2000 if it separates thousands'
    with pytest.raises(UserError) as caught:
        read_plain_csv(file, PLAIN, "a.csv")
    assert said in str(caught.value)
    file.write_text(spreadsheet("{:d}", decimal))
    assert read_plain_csv(file, PLAIN, "a.csv").values[:, 0].tolist() == [2000.0, 2005.0, 2010.0]
    file.write_text("time [s];hip [deg]\n0.995;12,3\n1.000;12,3\n1.005;12,3\n")  # as a logger and a sheet write
    assert read_plain_csv(file, PLAIN, "a.csv").values[:, 0].tolist() == [0.995, 1.0, 1.005]


def test_a_known_torque_and_velocities_are_kept_and_other_numbers_named(tmp_path: Path) -> None:
    """Of joints without a drive, in the leg's sense and the table's units; a velocity that is none is left out."""
    time, measured = angles()
    data = table("time [s]", "hip [deg]", "knee [deg]", "ankle [deg]")
    rate = np.radians(np.gradient(measured, time, axis=0))
    data["knee torque [N*mm]"] = 500.0
    data["hip velocity [rad/s]"], data["knee velocity [rad/s]"] = rate[:, 0], -rate[:, 1]
    data["toe"], data["note"] = 1.0, "x"
    data.to_csv(tmp_path / "a.csv", index=False)
    found = imported(tmp_path / "a.csv")
    given = {each.title: each.value for each in found.inputs}
    assert list(given) == ["knee torque [N*m]", "hip velocity [deg/s]"]
    np.testing.assert_allclose(given["knee torque [N*m]"], 0.5)
    np.testing.assert_allclose(given["hip velocity [deg/s]"], np.degrees(rate[:, 0]), atol=1e-9)
    assert "knee torque: from knee torque" in found.notes
    assert "not used: toe" in found.notes
    assert any(n.startswith("knee velocity: knee velocity is left out: it has the opposite sign") for n in found.notes)
    assert any("as if the known torque (knee torque) did not act" in note for note in found.notes)
    turned = imported(tmp_path / "a.csv", Mapping(joints={"knee": JointColumn("knee", zero=np.pi, sign=-1)}))
    assert turned.inputs[0].value[0] == pytest.approx(-0.5)
    with pytest.raises(UserError, match="a known torque acts"):
        imported(tmp_path / "a.csv", cut="free")
    data.rename(columns={"knee torque [N*mm]": "knee torque"}).to_csv(tmp_path / "a.csv", index=False)
    with pytest.raises(UserError, match='does not state the unit of "knee torque"'):
        imported(tmp_path / "a.csv")


def test_a_recording_that_a_torque_drives_is_kept_whole(tmp_path: Path) -> None:
    """Of a joint without a ``drive``, for which the leg file need state none: a release was sought, and the rest cut.

    Of a real pendulum's log (torque_limited_simple_pendulum, ``sysid``) 84 of 585 samples were left out.
    """
    time, _ = angles()
    data = table("time [s]", "hip [deg]", "knee [deg]", "ankle [deg]")
    data["knee torque [N*m]"] = np.sin(3.0 * time)
    data.to_csv(tmp_path / "a.csv", index=False)
    driven = imported(tmp_path / "a.csv")
    assert len(driven.time) == len(time)
    assert driven.release is None
    assert "kept whole: it is driven by a known torque (knee torque)" in driven.notes
    data["knee torque [N*m]"] = 1e-4 * np.random.default_rng(0).standard_normal(len(time))  # a sensor, no drive
    data.to_csv(tmp_path / "a.csv", index=False)
    assert imported(tmp_path / "a.csv").release is not None


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-be"])
def test_a_table_in_utf_16_is_recognised(tmp_path: Path, encoding: str) -> None:
    """As a spreadsheet saves "Unicode text": a byte order mark, tabs."""
    text = table("time [s]", "hip [°]", "knee [deg]", "ankle [deg]").to_csv(index=False, sep="\t")
    mark = b"\xfe\xff" if encoding == "utf-16-be" else b""
    (tmp_path / "a.txt").write_bytes(mark + text.encode(encoding))
    found = imported(tmp_path / "a.txt")
    assert found.format == "csv"
    np.testing.assert_allclose(np.degrees(found.angles), angles()[1], atol=1e-9)


@pytest.mark.parametrize("separator", [",", "\t"])
def test_numpys_header_is_a_comment(tmp_path: Path, separator: str) -> None:
    """``savetxt`` writes ``# `` before each line of its header, of which the last names the columns."""
    time, measured = angles()
    header = "logger 7\n" + separator.join(("time [s]", "hip [deg]", "knee [deg]", "ankle [deg]"))
    np.savetxt(tmp_path / "a.csv", np.column_stack([time, measured]), delimiter=separator, header=header)
    np.testing.assert_allclose(np.degrees(imported(tmp_path / "a.csv").angles), measured, atol=1e-9)


def test_a_commented_row_of_units_under_commented_names(tmp_path: Path) -> None:
    time, measured = angles()
    table_ = np.column_stack([time, measured])
    np.savetxt(tmp_path / "a.csv", table_, delimiter=",", header="t,hip,knee,ankle\ns,deg,deg,deg", comments="% ")
    np.testing.assert_allclose(np.degrees(imported(tmp_path / "a.csv").angles), measured, atol=1e-9)


@pytest.mark.parametrize("clock", ["%time", "time"])
def test_rostopics_echo_with_its_clock_in_ns(tmp_path: Path, clock: str) -> None:
    """``rostopic echo -b x.bag -p``: the header's first name is ``%time``, the epoch in ns."""
    time, measured = angles()
    rows = [f"{1_700_000_000_123_456_768 + round(t * 1e9)},base,{','.join(map(str, np.radians(row)))}\n"
            for t, row in zip(time, measured, strict=True)]  # fmt: skip
    header = "%time,field.header.frame_id,field.position0,field.position1,field.position2\n"
    (tmp_path / "a.csv").write_text(header + "".join(rows))
    columns = {name: JointColumn(f"field.position{k}", unit="rad") for k, name in enumerate(("hip", "knee", "ankle"))}
    found = imported(tmp_path / "a.csv", Mapping(joints=columns, time=clock, time_unit="ns"))
    np.testing.assert_allclose(np.degrees(found.angles), measured, atol=1e-9)
    np.testing.assert_allclose(found.time, time, atol=1e-12)


def echoed(path: Path, *, changed: bool = False) -> Path:
    """Joint states by ``rostopic echo -p``, in the order of the alphabet: ankle, hip, knee."""
    time, measured = angles()
    rows = []
    for k, (t, (hip, knee, ankle)) in enumerate(zip(time, np.radians(measured), strict=True)):
        joints = "hip,ankle,knee" if changed and k == 7 else "ankle,hip,knee"
        rows.append(f"{1_700_000_000_123_456_768 + round(t * 1e9)},{k},,{joints},{ankle},{hip},{knee},0,0,0\n")
    quantities = ",".join(f"field.{what}{k}" for what in ("name", "position", "effort") for k in range(3))
    path.write_text(f"%time,field.header.seq,field.header.frame_id,{quantities}\n" + "".join(rows))
    return path


def test_rostopics_echo_names_its_joints(tmp_path: Path) -> None:
    """Its columns were known by their place alone, and a project that took the limb's order got exchanged joints."""
    path = echoed(tmp_path / "a.csv")
    found = imported(path, Mapping())
    np.testing.assert_allclose(np.degrees(found.angles), angles()[1], atol=1e-9)
    np.testing.assert_allclose(found.time, angles()[0], atol=1e-12)
    places = {"hip": 1, "knee": 2, "ankle": 0}
    right = {name: JointColumn(f"field.position{k}", unit="rad") for name, k in places.items()}
    np.testing.assert_allclose(imported(path, Mapping(joints=right)).angles, found.angles)
    wrong = {"hip": JointColumn("field.position0", unit="rad")}
    with pytest.raises(UserError, match=r'hip: the file says that "field.position0" is the angle of ankle; write'):
        imported(path, Mapping(joints=wrong))


def test_rostopics_echo_whose_joints_change_places_is_refused(tmp_path: Path) -> None:
    with pytest.raises(
        UserError, match=r'a.csv:9: field.name0: is "hip" after "ankle": the columns are of other joints'
    ):
        imported(echoed(tmp_path / "a.csv", changed=True), Mapping())


def test_rows_of_separators_at_the_end_are_no_samples(tmp_path: Path) -> None:
    """As spreadsheets leave them."""
    text = table("time [s]", "hip [deg]", "knee [deg]", "ankle [deg]").to_csv(index=False)
    (tmp_path / "a.csv").write_text(text + ",,,\n,,,\n")
    np.testing.assert_allclose(np.degrees(imported(tmp_path / "a.csv").angles), angles()[1], atol=1e-9)


def test_a_row_of_units_under_the_names(tmp_path: Path) -> None:
    lines = table("t", "hip", "knee", "ankle").to_csv(index=False, sep="\t").splitlines()
    (tmp_path / "a.txt").write_text("\n".join([lines[0], "s\tdeg\tdeg\tdeg", *lines[1:]]))
    np.testing.assert_allclose(np.degrees(imported(tmp_path / "a.txt").angles), angles()[1], atol=1e-9)


def test_all_mistakes_of_a_file_are_reported_together(tmp_path: Path) -> None:
    table("clock", "Hip", "kn", "ankle (m/s)").to_csv(tmp_path / "a.csv", index=False)
    with pytest.raises(UserError) as caught:
        imported(tmp_path / "a.csv", Mapping(joints={"ankle": JointColumn("ankle (m/s)", unit="m/s")}))
    text = str(caught.value)
    assert 'hip: the file does not state the unit of "Hip"; write {column: Hip, unit: deg}' in text
    assert 'knee: there is no column "knee"; did you mean kn?' in text
    assert "ankle: [m/s] is the unit of a speed" in text
    assert "say which column is the clock, time: {column: NAME, unit: s}" in text


def test_jumps_by_whole_turns_are_removed_and_reported(tmp_path: Path) -> None:
    data = table("time [s]", "hip [deg]", "knee [deg]", "ankle [deg]")
    data["knee [deg]"] = (data["knee [deg]"] + 70.0 + 180.0) % 360.0 - 180.0  # wraps about 110 deg
    data["ankle [deg]"] -= 720.0
    data.loc[100:104, "knee [deg]"] = np.nan
    data.to_csv(tmp_path / "a.csv", index=False)
    columns = {"knee": JointColumn("knee", zero=np.radians(250.0), sign=1)}
    found = imported(tmp_path / "a.csv", Mapping(joints=columns))
    seen = np.isfinite(found.angles)
    np.testing.assert_allclose(np.degrees(found.angles[seen]), angles()[1][seen], atol=1e-9)
    assert any("jumps by a whole turn removed" in note and note.startswith("knee: ") for note in found.notes)
    assert "ankle: shifted by +720 deg to the leg file's convention" in found.notes


def test_exchanged_columns_are_restored(tmp_path: Path) -> None:
    data = table("time [s]", "hip [deg]", "left knee [deg]", "ankle [deg]")
    data["right knee [deg]"] = 150.0 + 5.0 * np.sin(9.0 * data["time [s]"])
    swap = slice(210, 229)
    left, right = data["left knee [deg]"].copy(), data["right knee [deg]"].copy()
    data.loc[swap, "left knee [deg]"], data.loc[swap, "right knee [deg]"] = right.loc[swap], left.loc[swap]
    data.to_csv(tmp_path / "a.csv", index=False)
    found = imported(tmp_path / "a.csv", Mapping(joints={"knee": JointColumn("left knee")}))
    np.testing.assert_allclose(np.degrees(found.angles), angles()[1], atol=1e-9)
    text = "knee (left knee): left and right are exchanged in 20 frames (1 stretches); restored"
    assert text in found.notes


def test_an_uneven_clock_loses_no_frames(tmp_path: Path) -> None:
    """A servo bus: each reading is late by up to two steps, none is lost."""
    data = table("time [s]", "hip [deg]", "knee [deg]", "ankle [deg]")
    steps = np.diff(data["time [s]"], prepend=0.0)
    steps[1:] = steps[1:] * np.random.default_rng(3).uniform(0.2, 2.4, len(steps) - 1)
    data["time [s]"] = np.cumsum(steps)
    data.to_csv(tmp_path / "a.csv", index=False)
    notes = imported(tmp_path / "a.csv").notes
    assert any(note.startswith("its clock is uneven: steps of 1") for note in notes)
    assert not any("lost" in note for note in notes)


def test_lost_frames_spikes_and_a_bad_clock(tmp_path: Path) -> None:
    data = table("time [s]", "hip [deg]", "knee [deg]", "ankle [deg]")
    data.loc[30, "hip [deg]"] += 30.0
    data.drop(index=range(50, 57)).to_csv(tmp_path / "a.csv", index=False)
    notes = imported(tmp_path / "a.csv").notes
    assert "7 frames are lost in 1 gap of the clock, after 0.245 s" in notes
    assert any(note.startswith("hip: 1 sample is an outlier (at 0.150 s)") for note in notes)
    data.loc[70, "time [s]"] = data.loc[69, "time [s]"]
    data.to_csv(tmp_path / "b.csv", index=False)
    with pytest.raises(UserError, match=r"time repeats at sample 71: 0.345 s, then 0.345 s"):
        imported(tmp_path / "b.csv")


def test_cut_at_the_release_keep_and_a_window_by_hand(tmp_path: Path) -> None:
    """Held for 0.5 s: sample 100."""
    data = table("time [s]", "hip [deg]", "knee [deg]", "ankle [deg]")
    data.iloc[:, 1:] += np.random.default_rng(0).normal(0, 0.05, (300, 3))
    data.to_csv(tmp_path / "a.csv", index=False)
    cut = imported(tmp_path / "a.csv", cut="cut")
    assert 0.49 < cut.time[0] < 0.52
    assert cut.total == 300
    assert any(note.startswith("cut at the release: ") and "of 300 samples" in note for note in cut.notes)
    kept = imported(tmp_path / "a.csv", cut="keep")
    assert len(kept.time) == 300
    assert kept.notes[-1] == "nothing was cut, as wished; a trial must start at or after the release"
    window = imported(tmp_path / "a.csv", window=(0.6, 1.0))
    assert (window.time[0], window.time[-1], window.release) == (0.6, 1.0, None)
    assert window.notes[-1] == "cut to the window given: 219 of 300 samples left out"
    with pytest.raises(UserError, match=r"the window 2 to 3 s holds 0 samples of the file's 0 to 1.495 s"):
        imported(tmp_path / "a.csv", window=(2.0, 3.0))


def test_a_joint_seen_only_before_the_release_is_refused(tmp_path: Path) -> None:
    data = table("time [s]", "hip [deg]", "knee [deg]", "ankle [deg]")
    data.loc[95:, "ankle [deg]"] = np.nan
    data.to_csv(tmp_path / "a.csv", index=False)
    with pytest.raises(UserError, match=r"too few samples of ankle remain from 0.[45]\d+ s; leave the file out"):
        imported(tmp_path / "a.csv", cut="cut")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", r"is empty"),
        (b"time [s],hip [deg]\n", r"has no rows below its header"),
        (b"0,1,2,3\n1,2,3,4\n", r":1: begins with numbers; its first line must name the columns"),
        (b"# a, b\n\n0,1,2\n1,2,3\n", r":3: begins with numbers, and the comment above does not name their 3 columns"),
        (b"# 1,2,3\n0,1,2\n1,2,3\n", r":2: begins with numbers, and the comment above does not name their 3 col"),
        (b"time [s],hip [deg],hip [rad]\n0,1,2\n", r'column "hip" is given twice'),
        (b"time [s],hip [deg]\n0,1\n1,x\n", r':3: hip \[deg\]: "x" is not a number; leave the cell empty'),
        (b"time [s],hip [deg]\n0,1\n1\n", r":3: has 1 cells where the header has 2 columns"),
        (b"PK\x03\x04abc", r"is a spreadsheet or an archive"),
    ],
)
def test_damaged_files(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(content)
    with pytest.raises(UserError, match=message):
        imported(path)


def test_unknown_files_name_the_known(tmp_path: Path) -> None:
    (tmp_path / "film.avi").write_bytes(b"RIFF\0\0\0\0AVI LIST" + bytes(99))
    with pytest.raises(UserError, match=r"film.avi: has an unknown format; known formats: anipose, c3d, csv"):
        imported(tmp_path / "film.avi")
    with pytest.raises(UserError, match=r"a.xlsx: does not exist"):
        imported(Path("a.xlsx"))


def test_names_of_the_other_side() -> None:
    names = ("knee_L", "knee_R", "LKnee", "RKnee", "left hip", "right hip", "ankle", "hip_flexion_l", "hip_flexion_r")
    pairs = {0: 1, 1: 0, 4: 5, 5: 4, 7: 8, 8: 7, 6: None}
    assert {k: other_side(names[k], names) for k in pairs} == pairs


def test_a_side_is_a_letter_before_or_after_the_name() -> None:
    """Vicon's RHIP and LHIP were no pair: a recording with exchanged limbs was cut at the exchange, without a word."""
    for names in (
        ("RHIP", "RKNE", "LHIP", "LKNE"),
        ("HipR", "KneR", "HipL", "KneL"),
        ("a:rHip", "a:rKn", "a:lHip", "a:lKn"),
    ):
        assert [other_side(name, names) for name in names] == [2, 3, 0, 1]
    assert other_side("rat", ("rat", "lat", "hip")) is None  # one pair alone may be two words
    assert other_side("left hip", ("left hip", "right hip", "hip")) == 1


PLOTJUGGLER = ("stamp", "/joint_states/hip/position", "/joint_states/hip/velocity", "/setpoint/hip", "/base/Knee")
OPENSIM = ("/jointset/hip/hip/value", "/jointset/hip/hip/speed", "/jointset/hip/hip_adduction/value")


@pytest.mark.parametrize(
    ("names", "wanted", "found"),
    [
        (PLOTJUGGLER, "hip", [1, 3]),
        (PLOTJUGGLER, "setpoint/hip", [3]),
        (PLOTJUGGLER, "/joint_states/hip", [1]),
        (PLOTJUGGLER, "/other/hip", []),
        (PLOTJUGGLER, "knee", [4]),
        (PLOTJUGGLER[:3], "hip", [1]),
        (OPENSIM, "hip", [0]),
        (OPENSIM, "hip_adduction", [2]),
        (("hip", "/setpoint/hip"), "Hip", [0]),
    ],
)
def test_a_name_at_the_end_of_a_path(names: tuple[str, ...], wanted: str, found: list[int]) -> None:
    assert indices_of_name(wanted, names) == found


def test_setpoints_are_not_taken_for_angles(tmp_path: Path) -> None:
    """A log of PlotJuggler, whose measured angles have `position` at the end of their path."""
    data = table("time [s]", "/js/hip/position [deg]", "/js/knee/position [deg]", "/js/ankle/position [deg]")
    data.to_csv(tmp_path / "a.csv", index=False)
    found = imported(tmp_path / "a.csv")
    np.testing.assert_allclose(np.degrees(found.angles), angles()[1], atol=1e-9)
    assert "hip: from /js/hip/position" in found.notes
    data["/setpoint/hip [deg]"] = 100.0
    data.to_csv(tmp_path / "b.csv", index=False)
    with pytest.raises(UserError, match='"hip" is the name of several columns: /js/hip/position, /setpoint/hip'):
        imported(tmp_path / "b.csv")


def test_text_stands_above_a_column_s_first_number_and_not_below(tmp_path: Path) -> None:
    data = table("time [s]", "hip [deg]", "knee [deg]", "ankle [deg]")
    data["note"] = ["started", "nan", "+nan", "ready"] + ["on"] * (len(data) - 4)
    data.to_csv(tmp_path / "a.csv", index=False)
    assert len(imported(tmp_path / "a.csv").time) == len(data)
    data.loc[4, "note"] = "7"
    data.to_csv(tmp_path / "a.csv", index=False)
    with pytest.raises(UserError, match=':7: note: "on" is not a number'):
        imported(tmp_path / "a.csv")


def test_a_column_of_text_is_not_searched_for_numbers_at_each_of_its_cells(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """80 000 rows with a column `running` took 9 s, four times as long as half of them."""
    rows, looked = 2000, [0]
    isnan = np.isnan

    def counted(values: object, *arguments: object, **named: object) -> object:
        looked[0] += np.size(values)  # type: ignore[arg-type]
        return isnan(values, *arguments, **named)  # type: ignore[call-overload]

    (tmp_path / "a.csv").write_text(
        "time [s],hip [deg],state\n" + "".join(f"{k},{k % 90},running\n" for k in range(rows))
    )
    monkeypatch.setattr(np, "isnan", counted)
    read_plain_csv(tmp_path / "a.csv", PLAIN, "a.csv")
    assert looked[0] <= 10 * rows


def test_joints_read_a_moment_apart_are_neither_lost_nor_missing(tmp_path: Path) -> None:
    """Steps of 0.1 and 4.9 ms from row to row were thousands of lost frames, and half of each joint was missing."""
    time, measured = angles()
    both = np.sort(np.r_[time, time + 1e-4])
    data = pd.DataFrame({"time [s]": both}).join(
        pd.DataFrame(np.repeat(measured, 2, axis=0), columns=["hip [deg]", "knee [deg]", "ankle [deg]"])
    )
    data.loc[::2, "ankle [deg]"] = np.nan
    data.loc[1::2, ["hip [deg]", "knee [deg]"]] = np.nan
    data.to_csv(tmp_path / "a.csv", index=False)
    found = imported(tmp_path / "a.csv", cut="keep")
    told = "its joints are sampled at different moments (hip 300, knee 300, ankle 300): each has its own clock"
    assert told in found.notes
    assert not any("lost" in note or "missing" in note for note in found.notes)
    data.loc[[100, 102], "knee [deg]"] = np.nan
    data.drop(index=range(200, 204)).to_csv(tmp_path / "b.csv", index=False)
    notes = "; ".join(imported(tmp_path / "b.csv", cut="keep").notes)
    assert "2 frames are lost in 1 gap of the clock, after 0.495 s" in notes
    assert "knee: 2 of 298 samples are missing and not filled; the longest gap is 15 ms, from 0.245 s on" in notes
    assert notes.count("missing") == 1


@pytest.mark.parametrize(
    "head",
    [
        "t [s] hip [deg] knee [deg] ankle [deg]",
        "time[s] hip(deg) knee(deg) ankle(deg)",
        "# a run\n# t [s] hip [deg] knee [deg] ankle [deg]",
        "t hip knee ankle\ns deg deg deg",
    ],
)
def test_columns_that_blanks_separate(tmp_path: Path, head: str) -> None:
    """As of numpy's savetxt without a delimiter: the message was that there is no column "hip" in "time hip knee"."""
    time, measured = angles()
    rows = [f"  {t:.5f}   {'  '.join(f'{value:.9f}' for value in row)}" for t, row in zip(time, measured, strict=True)]
    (tmp_path / "a.txt").write_text("\n".join([head, *rows, ""]))
    np.testing.assert_allclose(np.degrees(imported(tmp_path / "a.txt").angles), measured, atol=1e-9)


def test_a_line_above_the_header_gets_what_to_do(tmp_path: Path) -> None:
    text = table("time [s]", "hip [deg]", "knee [deg]", "ankle [deg]").to_csv(index=False)
    (tmp_path / "a.csv").write_text("Starting ...\n" + text)
    with pytest.raises(
        UserError, match=r'header has 1 columns \("Starting ..."\): remove the lines above the header, or'
    ):
        imported(tmp_path / "a.csv")


def test_rows_without_a_time_or_a_number_are_left_out(tmp_path: Path) -> None:
    """As in tables that pandas joined: "sample 51 has no time" stopped the import."""
    lines = table("time [s]", "hip [deg]", "knee [deg]", "ankle [deg]").to_csv(index=False).splitlines()
    (tmp_path / "a.csv").write_text("\n".join([*lines[:51], "NaN,NaN,NaN,NaN", ",,,", *lines[51:]]) + "\n")
    found = imported(tmp_path / "a.csv")
    np.testing.assert_allclose(np.degrees(found.angles), angles()[1], atol=1e-9)
    assert "2 rows have neither a time nor a number: left out" in found.notes
    (tmp_path / "a.csv").write_text("\n".join([*lines[:51], ",1,2,3", *lines[51:]]) + "\n")
    with pytest.raises(UserError, match="sample 51 has no time: write it, or remove that row"):
        imported(tmp_path / "a.csv")


def test_rows_of_other_columns_are_no_moments_of_the_joints(tmp_path: Path) -> None:
    """PlotJuggler's table of two topics: the joints, read together, were said to be sampled at different moments."""
    time, measured = angles()
    rows = []
    for k, (t, row) in enumerate(zip(time, measured, strict=True)):
        rows.append(f"{t:.5f},{','.join(map(str, row))},")
        rows += [f"{t + 0.001:.5f},,,,1"] if k % 5 == 0 else []
    (tmp_path / "a.csv").write_text("\n".join(["time [s],hip [deg],knee [deg],ankle [deg],/mode", *rows, ""]))
    found = imported(tmp_path / "a.csv")
    assert "60 of its rows are moments of other columns, without a sample of a joint" in found.notes
    assert not any("different moments" in note or "missing" in note for note in found.notes)
