"""Formats read by content: each on a file that its own library wrote, joint angles of a leg that are known.

DeepLabCut's HDF5 by pandas and PyTables, SLEAP's by sleap-io, NWB's by pynwb with ndx-pose, MCAP by mcap, bags by
rosbags; Anipose's CSV and TRC as text by their makers' descriptions.
"""

from __future__ import annotations

import json
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from numpy.typing import NDArray

from motion.importers.simulated_leg import NAMES, PARTS, RATE, angles, leg, pixels, points
from synth.cli import main
from synth.errors import UserError
from synth.files.import_mapping import Mapping
from synth.files.import_project import Formats, bag_file
from synth.files.leg_file import write_leg
from synth.motion.importers.convert import ImportedRecording, import_file
from synth.motion.importers.plain_pickle import plain_values
from synth.motion.importers.registry import formats, recognise

Array = NDArray[np.float64]
FLAT = Mapping(points=PARTS, frame_rate=RATE)
TIME, MEASURED = angles()
SPACE_TURN = 0.4  # rad, by which the plane of motion is turned about the vertical


def imported(path: Path, mapping: Mapping) -> ImportedRecording:
    return import_file(path, leg(), mapping, name=path.name, cut="keep")


def as_they_went_in(found: ImportedRecording, form: str, within: float = 1e-6) -> None:
    assert found.format == form
    np.testing.assert_allclose(np.degrees(found.angles), MEASURED, atol=within)
    np.testing.assert_allclose(found.time - found.time[0], TIME, atol=1e-6)


def in_space(up: int) -> Array:
    """(n, 4, 3) m: the leg's plane turned about the vertical, whose axis has that index."""
    flat = points(MEASURED)
    right = flat[..., 0]
    level = [right * np.cos(SPACE_TURN), right * np.sin(SPACE_TURN)]
    return np.stack([flat[..., 1] if k == up else level.pop(0) for k in range(3)], axis=-1)


def deeplabcut_h5(path: Path, individual: bool = False) -> Path:
    """As DeepLabCut does: ``to_hdf(..., key="df_with_missing", format="table", mode="w")``."""
    pytest.importorskip("tables")
    places = pixels(points(MEASURED))
    head = ("scorer", "animal") if individual else ("scorer",)
    columns = [(*head, part, word) for part in PARTS for word in ("x", "y", "likelihood")]
    data = np.concatenate([np.column_stack([places[:, k], np.full(len(places), 0.99)]) for k in range(4)], axis=1)
    names = ["scorer", *(["individuals"] if individual else []), "bodyparts", "coords"]
    table = pd.DataFrame(data, columns=pd.MultiIndex.from_tuples(columns, names=names))
    with _quiet():
        table.to_hdf(path, key="df_with_missing", format="table", mode="w")
    return path


@contextmanager
def _quiet() -> Iterator[None]:
    """Without the libraries' own warnings, of names and of the future."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        yield


@pytest.mark.parametrize("individual", [False, True])
def test_deeplabcut_s_hdf5(tmp_path: Path, individual: bool) -> None:
    path = deeplabcut_h5(tmp_path / "videoDLC.h5", individual)
    as_they_went_in(imported(path, FLAT), "deeplabcut-h5")


def sleap_labels():  # type: ignore[no-untyped-def]
    sio = pytest.importorskip("sleap_io")
    skeleton = sio.Skeleton(nodes=[sio.Node(part) for part in PARTS])
    video, track = sio.Video(filename="rat.mp4", open_backend=False), sio.Track("rat")
    frames = []
    for k, place in enumerate(pixels(points(MEASURED))):
        found = sio.PredictedInstance.from_numpy(
            place, skeleton=skeleton, point_scores=np.full(4, 0.9), score=0.9, track=track
        )
        frames.append(sio.LabeledFrame(video=video, frame_idx=k, instances=[found]))
    return sio.Labels(labeled_frames=frames, videos=[video], skeletons=[skeleton], tracks=[track])


def test_sleap_s_own_file(tmp_path: Path) -> None:
    sleap_labels().save(str(tmp_path / "a.slp"))
    as_they_went_in(imported(tmp_path / "a.slp", FLAT), "sleap", 5e-5)  # it holds 4-byte floats


def test_sleap_s_analysis_file(tmp_path: Path) -> None:
    """As SLEAP's export describes it: tracks (n_track, 2, n_node, n_frame), names as bytes."""
    h5py = pytest.importorskip("h5py")
    places = pixels(points(MEASURED))
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["tracks"] = places.transpose(2, 1, 0)[None]
        file["node_names"] = [part.encode() for part in PARTS]
        file["track_names"] = [b"rat"]
        file["track_occupancy"] = np.ones((1, len(places)), dtype=np.uint8)
    as_they_went_in(imported(tmp_path / "a.h5", FLAT), "sleap-analysis")


def anipose(path: Path) -> Path:
    """As ``anipose triangulate`` writes its table."""
    space, columns = in_space(2), {}
    for k, part in enumerate(PARTS):
        for axis, values in zip("xyz", space[:, k].T, strict=True):
            columns[f"{part}_{axis}"] = values
        columns[f"{part}_error"], columns[f"{part}_ncams"] = np.full(len(space), 1.2), np.full(len(space), 3)
        columns[f"{part}_score"] = np.full(len(space), 0.95)
    columns |= {f"M_{i}{j}": np.full(len(space), float(i == j)) for i in range(3) for j in range(3)}
    columns["fnum"] = np.arange(len(space))
    pd.DataFrame(columns).to_csv(path, index=False)
    return path


def trc(path: Path) -> Path:
    """By OpenSim's description of marker files, y up, in mm."""
    space = 1e3 * in_space(1)
    lines = [
        "PathFileType\t4\t(X/Y/Z)\ta.trc",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames",
        f"{RATE:g}\t{RATE:g}\t{len(space)}\t{len(PARTS)}\tmm\t{RATE:g}\t1\t{len(space)}",
        "Frame#\tTime\t" + "\t".join(f"{part}\t\t" for part in PARTS),
        "\t\t" + "\t".join(f"X{k}\tY{k}\tZ{k}" for k in range(1, 5)),
        "",
    ]
    for k, frame in enumerate(space):
        lines.append("\t".join([str(k + 1), f"{TIME[k]:.6f}", *(f"{value:.9f}" for value in frame.ravel())]))
    path.write_text("\n".join(lines) + "\n")
    return path


def test_texts_in_utf_16_are_read_as_in_utf_8(tmp_path: Path) -> None:
    """As PowerShell's ``>`` writes them."""
    for name, made, mapping in (
        ("trc", trc(tmp_path / "a.trc"), Mapping(points=PARTS)),
        ("anipose", anipose(tmp_path / "a.csv"), Mapping(points=PARTS, frame_rate=RATE, plane=("fit", "z"))),
    ):
        plain = imported(made, mapping)
        made.write_bytes(made.read_bytes().decode().encode("utf-16"))
        found = imported(made, mapping)
        assert found.format == plain.format == name
        np.testing.assert_array_equal(found.angles, plain.angles)


def test_points_in_space_lie_in_the_plane_that_fits_best(tmp_path: Path) -> None:
    for found, form in (
        (imported(anipose(tmp_path / "a.csv"), FLAT), "anipose"),
        (imported(trc(tmp_path / "a.trc"), Mapping(points=PARTS)), "trc"),
    ):
        as_they_went_in(found, form, 1e-5)
        told = " ".join(found.notes)
        assert f"{np.cos(SPACE_TURN):+.3f} x" in told
        assert "RMS from it, 0.0% of the limb's length" in told


def test_the_residual_of_the_plane_is_the_scatter_across_it(tmp_path: Path) -> None:
    space = in_space(2)
    across = np.array([-np.sin(SPACE_TURN), np.cos(SPACE_TURN), 0.0])
    off = np.random.default_rng(3).normal(0.0, 0.004, space.shape[:2])
    table = pd.read_csv(anipose(tmp_path / "a.csv"))
    for k, part in enumerate(PARTS):
        for axis, values in zip("xyz", (space[:, k] + off[:, k, None] * across).T, strict=True):
            table[f"{part}_{axis}"] = values
    table.to_csv(tmp_path / "a.csv", index=False)
    found = imported(tmp_path / "a.csv", FLAT)
    (said,) = [note for note in found.notes if note.startswith("plane fitted")]
    assert float(said.partition("lie ")[2].split()[0]) == pytest.approx(0.004, rel=0.05)


def test_nwb_pose(tmp_path: Path) -> None:
    pynwb = pytest.importorskip("pynwb")
    pose = pytest.importorskip("ndx_pose")
    import datetime

    places = pixels(points(MEASURED))
    with _quiet():
        file = pynwb.NWBFile("s", "id", datetime.datetime(2026, 1, 1, tzinfo=datetime.UTC))
        series = [
            pose.PoseEstimationSeries(
                name=part, data=places[:, k], unit="pixels", reference_frame="upper left corner", timestamps=TIME,
                confidence=np.full(len(TIME), 0.9), confidence_definition="softmax",
            )
            for k, part in enumerate(PARTS)
        ]  # fmt: skip
        behavior = file.create_processing_module("behavior", "pose")
        skeleton = pose.Skeleton(name="leg", nodes=list(PARTS))
        behavior.add(pose.Skeletons(skeletons=[skeleton]))
        behavior.add(pose.PoseEstimation(name="PoseEstimation", pose_estimation_series=series, skeleton=skeleton))
        with pynwb.NWBHDF5IO(str(tmp_path / "a.nwb"), "w") as out:
            out.write(file)
    as_they_went_in(imported(tmp_path / "a.nwb", Mapping(points=PARTS)), "nwb-pose")


def states():  # type: ignore[no-untyped-def]
    """Stamp (sec, nanosec), names and positions of each joint state, the joints in another order each time."""
    order = [(0, 1, 2), (2, 0, 1)]
    for k, row in enumerate(np.radians(MEASURED)):
        stamp = round((1000.0 + TIME[k]) * 1e9)
        turn = order[k % 2]
        yield divmod(stamp, 10**9), [NAMES[j] for j in turn], [float(row[j]) for j in turn]


def joint_state(store, stamp, names, positions):  # type: ignore[no-untyped-def]
    types = store.types
    time = types["builtin_interfaces/msg/Time"](sec=stamp[0], nanosec=stamp[1])
    extra = {"seq": 0} if "seq" in types["std_msgs/msg/Header"].__dataclass_fields__ else {}
    header = types["std_msgs/msg/Header"](stamp=time, frame_id="", **extra)
    none = np.array([], dtype=np.float64)
    return types["sensor_msgs/msg/JointState"](
        header=header, name=names, position=np.array(positions), velocity=none, effort=none
    )


LOGGED = Mapping()


@pytest.mark.parametrize("encoding", ["json", "cdr"])
def test_mcap(tmp_path: Path, encoding: str) -> None:
    writer_of = pytest.importorskip("mcap.writer")
    rosbags = pytest.importorskip("rosbags.typesys")
    store = rosbags.get_typestore(rosbags.Stores.ROS2_HUMBLE)
    with (tmp_path / "a.mcap").open("wb") as stream:
        writer = writer_of.Writer(stream)
        writer.start()
        schema = writer.register_schema(
            "sensor_msgs/msg/JointState", "jsonschema" if encoding == "json" else "ros2msg", b"{}"
        )
        channel = writer.register_channel("/joint_states", encoding, schema)
        for stamp, names, positions in states():
            data = {"header": {"stamp": {"sec": stamp[0], "nanosec": stamp[1]}}, "name": names, "position": positions}
            said = json.dumps(data).encode()
            if encoding == "cdr":
                said = bytes(
                    store.serialize_cdr(joint_state(store, stamp, names, positions), "sensor_msgs/msg/JointState")
                )
            writer.add_message(channel, log_time=stamp[0] * 10**9 + stamp[1], publish_time=0, data=said)
        writer.finish()
    as_they_went_in(imported(tmp_path / "a.mcap", LOGGED), "mcap")
    with pytest.raises(UserError, match="no joint states on"):
        imported(tmp_path / "a.mcap", Mapping(topic="/others"))


@pytest.mark.parametrize("version", [1, 2])
def test_ros_bags(tmp_path: Path, version: int) -> None:
    typesys = pytest.importorskip("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores.ROS1_NOETIC if version == 1 else typesys.Stores.ROS2_HUMBLE)
    kind = "sensor_msgs/msg/JointState"
    if version == 1:
        from rosbags.rosbag1 import Writer

        path = tmp_path / "a.bag"
        bag, serialize = Writer(path), store.serialize_ros1
    else:
        from rosbags.rosbag2 import StoragePlugin
        from rosbags.rosbag2 import Writer as Writer2

        bag, serialize = Writer2(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.SQLITE3), store.serialize_cdr
        path = tmp_path / "bag" / "bag.db3"
    with bag:
        connection = bag.add_connection("/joint_states", kind, typestore=store)
        for stamp, names, positions in states():
            message = joint_state(store, stamp, names, positions)
            bag.write(connection, stamp[0] * 10**9 + stamp[1], serialize(message, kind))
    as_they_went_in(imported(path, LOGGED), "rosbag")
    if version == 2:
        assert bag_file(tmp_path, "bag") == "bag/bag.db3"
        assert bag_file(tmp_path, "bag/bag.db3") == "bag/bag.db3"
        for name in ("x_0.mcap", "x_1.mcap"):
            (tmp_path / "split").mkdir(exist_ok=True)
            (tmp_path / "split" / name).touch()
        (tmp_path / "split" / "metadata.yaml").touch()
        with pytest.raises(UserError, match=r"several files; name each: x_0\.mcap, x_1\.mcap"):
            bag_file(tmp_path, "split")


def test_formats_are_recognised_by_content_and_not_by_extension(tmp_path: Path) -> None:
    for made in (anipose(tmp_path / "a.csv"), trc(tmp_path / "b.trc")):
        other = made.rename(made.with_suffix(".txt"))
        assert recognise(other, other.name).name in ("anipose", "trc")
    (tmp_path / "c.mot").write_text("time,hip\n0,1\n")
    assert recognise(tmp_path / "c.mot", "c.mot").name == "csv"
    (tmp_path / "d.csv").write_bytes(b"PK\x03\x04\0\0")
    with pytest.raises(UserError, match="spreadsheet"):
        recognise(tmp_path / "d.csv", "d.csv")


def test_the_list_of_formats_is_the_registry_s(capsys: pytest.CaptureFixture[str]) -> None:
    assert {"auto", *formats()} == set(Formats.__args__)  # type: ignore[attr-defined]
    assert main(["import", "--list"]) == 0
    shown = capsys.readouterr().out
    assert all(item.title in shown for item in formats().values())


def test_a_missing_package_is_one_message(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "a.mcap").write_bytes(b"\x89MCAP0\r\n" + bytes(100))
    monkeypatch.setattr("synth.motion.importers.registry.find_spec", lambda name: None)
    with pytest.raises(UserError, match=r"pip install limb-synth\[robot-logs\]"):
        imported(tmp_path / "a.mcap", LOGGED)


@pytest.mark.parametrize("protocol", [0, 1, 2, 4, 5])
def test_plain_values_of_a_pickle(protocol: int) -> None:
    import pickle

    value = [(1, [("scorer", "hip", "x"), ("scorer", "hip", "y"), ("s", 2, 3.5, None)])]
    assert plain_values(pickle.dumps(value, protocol)) == value


def test_a_pickle_that_would_run_something_is_refused() -> None:
    import pickle

    class Call:
        def __reduce__(self) -> object:
            return print, ("run",)

    for data in (pickle.dumps(Call()), b"cos\nsystem\n(S'true'\ntR.", b"(lp0\n", b"\x80\x04", b"h\x00."):
        with pytest.raises(ValueError, match=r"holds more|damaged|no end|before seeing STOP"):
            plain_values(data)


def test_an_import_is_a_fit_that_runs(tmp_path: Path) -> None:
    write_leg(leg(), tmp_path / "robot.leg.yaml")
    trc(tmp_path / "a.trc")
    words = [str(tmp_path / "a.trc"), "--leg", str(tmp_path / "robot.leg.yaml"), "--points", ",".join(PARTS)]
    assert main(["import", *words, "--out", str(tmp_path / "out"), "-q"]) == 0
    assert main(["fit", str(tmp_path / "out" / "fit.yaml"), "--out", str(tmp_path / "fit"), "--dry-run"]) == 0
