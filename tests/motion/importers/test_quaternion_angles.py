"""Segments' angles from the quaternions of inertial sensors, mounted and turned in every way."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from motion.importers.simulated_leg import angles, leg
from synth.arrays import Array
from synth.errors import UserError
from synth.files.import_mapping import JointColumn, Mapping
from synth.files.import_project import read_import_project
from synth.files.leg_file import write_leg
from synth.motion.importers.convert import ImportedRecording, import_file
from synth.remarks import Remark

TIME, MEASURED = angles()
THIGH = MEASURED[:, 0] - 90.0  # deg from straight down, counter-clockwise; see ``simulated_leg.points``
SHANK = THIGH + MEASURED[:, 1] - 180.0
FOOT = SHANK - (MEASURED[:, 2] - 180.0)
SEGMENTS = {"hip": THIGH, "knee": SHANK, "ankle": FOOT}
TO_VIEWER, DOWN = np.array([0.0, -1.0, 0.0]), np.array([0.0, 0.0, -1.0])  # of the Earth: x to the right, z up


def sensor(angle: Array, mounted: Rotation, heading: float = 0.0) -> tuple[Array, Array, Array]:
    """Quaternions (n, 4) of a sensor on a link at ``angle`` (n,) deg; its own axis and the link's direction (3,).

    ``mounted`` : the sensor's axes in the hanging link's; ``heading`` deg, about the vertical.
    """
    turned = Rotation.from_euler("z", heading, degrees=True) * Rotation.from_rotvec(
        np.radians(angle)[:, None] * TO_VIEWER
    )
    quaternion = np.roll((turned * mounted).as_quat(), 1, axis=1)
    return quaternion, mounted.inv().apply(TO_VIEWER), mounted.inv().apply(DOWN)


def mountings() -> list[Rotation]:
    return list(Rotation.random(3, random_state=4))


def names(joint: str) -> tuple[str, ...]:
    return tuple(f"{joint}_q{part}" for part in "wxyz")


def written(path: Path, quaternions: dict[str, Array]) -> Path:
    header = ["time [s]", *(name for joint in quaternions for name in names(joint))]
    rows = np.column_stack([TIME, *quaternions.values()])
    lines = [",".join(header), *(",".join(f"{each:.9g}" for each in row) for row in rows)]
    path.write_text("\n".join(lines).replace("nan", "") + "\n")
    return path


def of(joint: str, axis: Array | None, down: Array, **more: object) -> JointColumn:
    made = JointColumn("quaternion", zero=0.0, segment=True, quaternion=names(joint), down=tuple(down))
    return replace(made, column=f"quaternion {joint}", axis=None if axis is None else tuple(axis), **more)


def imported(path: Path, **joints: JointColumn) -> ImportedRecording:
    return import_file(path, leg(), Mapping(joints=joints), name=path.name, cut="keep")


def test_sensors_mounted_at_random_and_headings_that_begin_anywhere(tmp_path: Path) -> None:
    """A heading that drifts is in no angle either; the sign of a quaternion has no meaning."""
    made = {joint: sensor(SEGMENTS[joint], mount, 70.0) for joint, mount in zip(SEGMENTS, mountings(), strict=True)}
    drift = Rotation.from_rotvec(np.radians(3.0) * TIME[:, None] * [0.0, 0.0, 1.0])
    drifting = drift * Rotation.from_quat(np.roll(made["knee"][0], -1, axis=1))
    columns = {joint: each[0] for joint, each in made.items()} | {"knee": np.roll(drifting.as_quat(), 1, axis=1)}
    columns["hip"] = columns["hip"] * np.where(np.arange(len(TIME)) % 7 == 0, -16384.0, 16384.0)[:, None]  # raw numbers
    found = imported(
        written(tmp_path / "a.csv", columns), **{joint: of(joint, *each[1:]) for joint, each in made.items()}
    )
    np.testing.assert_allclose(np.degrees(found.angles), MEASURED, atol=1e-4)
    said = [note for note in found.notes if note.startswith("hip: ")]
    assert "hip: from quaternion hip: 35.0 deg from straight down at first, 15.1 deg at the end" in said[0]
    assert ", 0.0 deg from the axis stated, and by 0.0 deg (RMS) about others" in said[1]
    assert not any("not used" in note for note in found.notes)


def test_quaternions_of_the_other_sense_get_the_way_to_write_them(tmp_path: Path) -> None:
    """Some filters give the Earth's axes in the sensor's: the conjugate."""
    made = {joint: sensor(SEGMENTS[joint], mount, 25.0) for joint, mount in zip(SEGMENTS, mountings(), strict=True)}
    path = written(tmp_path / "a.csv", {joint: each[0] * [1, -1, -1, -1] for joint, each in made.items()})
    joints = {joint: of(joint, *each[1:]) for joint, each in made.items()}
    doubts = [note for note in imported(path, **joints).notes if "its angle is wrong" in note]
    assert len(doubts) == 3
    assert isinstance(doubts[0], Remark)
    assert doubts[0].severity == "decide"
    assert doubts[0].remedy.endswith("sensor's, quaternion: [hip_qw, -hip_qx, -hip_qy, -hip_qz].")
    turned = {joint: replace(each, quaternion=(each.quaternion[0], *(f"-{n}" for n in each.quaternion[1:])))
              for joint, each in joints.items()}  # fmt: skip
    np.testing.assert_allclose(np.degrees(imported(path, **turned).angles), MEASURED, atol=1e-4)


def test_the_axis_that_the_file_shows_is_told(tmp_path: Path) -> None:
    rotations, axis, down = sensor(THIGH, Rotation.identity())
    path = written(tmp_path / "a.csv", {"hip": rotations, "knee": rotations, "ankle": rotations})
    with pytest.raises(UserError, match=r"hip: write the axis .* shows \[0.00, 1.00, 0.00\] or its negative"):
        imported(path, **{joint: of(joint, None, down) for joint in SEGMENTS})
    upright = {joint: of(joint, np.array([0.1, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])) for joint in SEGMENTS}
    with pytest.raises(UserError, match="hip: its axis is 80 deg from level: about a vertical one"):
        imported(path, **upright)
    assert axis == pytest.approx(TO_VIEWER)


def test_missing_quaternions_and_columns_that_are_none(tmp_path: Path) -> None:
    rotations, axis, down = sensor(THIGH, Rotation.identity())
    gap = rotations.copy()
    gap[50:53], gap[60] = 0.0, np.nan
    joints = {joint: of(joint, axis, down) for joint in SEGMENTS}
    path = written(tmp_path / "a.csv", {"hip": gap, "knee": rotations, "ankle": rotations})
    found = imported(path, **joints)
    assert "hip: 3 quaternions are 0 and count as missing" in found.notes
    assert np.flatnonzero(np.isnan(found.angles[:, 0])).tolist() == [50, 51, 52, 60]
    exchanged = joints | {"hip": replace(joints["hip"], quaternion=("hip_qx", "hip_qy", "hip_qz", "hip_qw"))}
    with pytest.raises(UserError, match=r"order w, x, y, z: quaternion: \[hip_qw, hip_qx, hip_qy, hip_qz\]"):
        imported(path, **exchanged)
    with pytest.raises(UserError, match="knee: its quaternion hip is another joint's already"):
        imported(path, **joints | {"knee": joints["hip"]})
    other = joints | {"hip": replace(joints["hip"], quaternion=("time", *names("hip")[1:]))}
    with pytest.raises(UserError, match="hip: time, hip_qx, hip_qy, hip_qz are no quaternion: its length is"):
        imported(path, **other)


def test_opensense_files_of_sensors_orientations(tmp_path: Path) -> None:
    """They were refused: "has cells of type Quaternion"."""
    made = {joint: sensor(SEGMENTS[joint], mount) for joint, mount in zip(SEGMENTS, mountings(), strict=True)}
    rows = [
        "\t".join([f"{t:.5f}", *(",".join(f"{each:.9f}" for each in made[joint][0][k]) for joint in SEGMENTS)])
        for k, t in enumerate(TIME)
    ]
    head = "DataRate=200.000000\nDataType=Quaternion\nversion=3\nOpenSimVersion=4.2\nendheader\n"
    path = tmp_path / "a.sto"
    path.write_text(head + "\n".join(["\t".join(["time", *(f"{joint}_imu" for joint in SEGMENTS)]), *rows, ""]))
    joints = {
        joint: replace(of(joint, *each[1:]), quaternion=tuple(f"{joint}_imu {part}" for part in "wxyz"))
        for joint, each in made.items()
    }
    np.testing.assert_allclose(np.degrees(imported(path, **joints).angles), MEASURED, atol=1e-4)
    path.write_text(path.read_text().replace(rows[5], rows[5].rpartition(",")[0]))
    with pytest.raises(UserError, match=r"a.sto:12: has 11 numbers in 3 cells, where each has 4"):
        imported(path, **joints)


def test_a_project_states_quaternions(tmp_path: Path) -> None:
    write_leg(leg(), tmp_path / "leg.yaml")
    (tmp_path / "a.csv").write_text("time [s],thigh [deg]\n0,1\n")
    file = tmp_path / "import.yaml"

    def read(hip: str) -> JointColumn:
        file.write_text(f"kind: import\nleg: leg.yaml\nfiles: [a.csv]\njoints:\n  hip: {{{hip}}}\n")
        return read_import_project(file).mapping.joints["hip"]

    made = read("quaternion: [q0, q1, q2, q3], axis: [0, 0, 1], down: [1, 0, 0], sign: -1")
    assert (made.quaternion, made.axis, made.down) == (("q0", "q1", "q2", "q3"), (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    assert made.convention(leg().joints[0]) == (0.0, -1)
    assert made.segment
    for hip, words in (
        ("unit: deg", r'joints.hip: needs "column", the name of its column, or of an inertial sensor "quaternion"'),
        ("column: a, axis: [0, 0, 1]", r"joints.hip.axis: is of a sensor's quaternion"),
        ("quaternion: [a, b, c, d]", r"joints.hip: needs the direction of this link .*: down: \[1, 0, 0\]"),
        ("quaternion: [a, b, c, d], down: [1, 0, 0], counts: 4096", r'joints.hip.counts: does not apply beside "quat'),
        ("quaternion: [a, b, c, d], down: [1, 0, 0], gear_ratio: 6", r"joints.hip.gear_ratio: does not apply beside"),
        ("quaternion: [a, b, c, d], down: [0, 0, 0]", r"joints.hip.down: is no direction; write three numbers"),
        ("quaternion: [a, b, c, d], down: [1, 0, 0], axis: [2, 1, 0]", r"joints.hip.down: is along the axis"),
        ("quaternion: [a, b, c], down: [1, 0, 0]", r"joints.hip.quaternion"),
    ):
        with pytest.raises(UserError, match=words):
            read(hip)
