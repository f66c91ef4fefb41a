"""Stamps of a robot's log: a window on its own clock, and publishers of different joints that share a stamp."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from motion.importers.simulated_leg import NAMES, leg
from synth.errors import UserError
from synth.files.import_mapping import Mapping
from synth.motion.importers.convert import ImportedRecording, import_file
from synth.remarks import Remark

COUNT, STEP = 80, 5_000_000  # messages, ns
UNIX = 1_700_000_000 * 10**9 + 123_456_789  # ns
ANGLES = np.column_stack([100 + 0.1 * np.arange(COUNT), 110 - 0.2 * np.arange(COUNT), 140 + 0.05 * np.arange(COUNT)])
Message = tuple[int, tuple[int, ...], NDArray[np.float64]]  # stamp in ns, joints, their angles in deg


def log_file(
    path: Path, messages: Iterable[Message], logged: Sequence[int] | None = None, chunk: int = 1_000_000
) -> Path:
    """An MCAP log of joint states as JSON; ``logged``: times in ns, else 1 ms after the stamps; ``chunk`` : bytes."""
    writer = pytest.importorskip("mcap.writer").Writer
    with path.open("wb") as stream:
        log = writer(stream, chunk_size=chunk)
        log.start()
        schema = log.register_schema("sensor_msgs/msg/JointState", "jsonschema", b"{}")
        channel = log.register_channel("/joint_states", "json", schema)
        for k, (stamp, joints, values) in enumerate(messages):
            head = {"stamp": {"sec": stamp // 10**9, "nanosec": stamp % 10**9}}
            content = {"header": head, "name": [NAMES[j] for j in joints], "position": np.radians(values).tolist()}
            log.add_message(
                channel,
                log_time=logged[k] if logged else stamp + 10**6,
                publish_time=0,
                data=json.dumps(content).encode(),
            )
        log.finish()
    return path


def read(path: Path, window: tuple[float, float] | None = None) -> ImportedRecording:
    return import_file(path, leg(), Mapping(), name=path.name, cut="keep", window=window)


def whole(first: int) -> list[Message]:
    return [(first + STEP * k, (0, 1, 2), row) for k, row in enumerate(ANGLES)]


@pytest.mark.parametrize("first", [500_000_000, UNIX])
def test_a_window_counts_on_the_stamps(tmp_path: Path, first: int) -> None:
    path, begin = log_file(tmp_path / "a.mcap", whole(first)), 1e-9 * first
    found = read(path, (begin + 0.1, begin + 0.3))
    np.testing.assert_allclose(np.degrees(found.angles), ANGLES[20:61], atol=1e-9)
    kept = begin if first < UNIX else 0.0  # a small clock is kept as it is, a large one counts from its first sample
    np.testing.assert_allclose(found.time, kept + 0.005 * np.arange(20, 61), rtol=0.0, atol=1e-9)
    with pytest.raises(UserError, match=r"0 to 0\.2 s holds 0 samples of the file's (0\.5|1700000000\.1\d*) to"):
        read(path, (0.0, 0.2))


def test_messages_of_one_stamp_with_other_joints_are_one_sample(tmp_path: Path) -> None:
    both = [[(t, (0, 1), row[:2]), (t, (2,), row[2:])] for t, _, row in whole(UNIX)]
    found = read(log_file(tmp_path / "a.mcap", [message for pair in both for message in pair]))
    np.testing.assert_allclose(np.degrees(found.angles), ANGLES, atol=1e-9)
    np.testing.assert_allclose(found.time, 0.005 * np.arange(COUNT), rtol=0.0, atol=1e-12)
    told = f"{COUNT} messages have the stamp of another that holds other joints, and are joined with it"
    assert told in found.notes
    assert not any("repeat" in note for note in found.notes)


@pytest.mark.parametrize(
    ("other", "told"), [(0.0, "repeats a stamp and"), (5.0, "repeats the stamp of another with other values, and")]
)
def test_a_message_that_repeats_joint_and_stamp_is_left_out(tmp_path: Path, other: float, told: str) -> None:
    messages = whole(UNIX)
    again = (messages[10][0], (0, 1, 2), ANGLES[10] + other)
    found = read(log_file(tmp_path / "a.mcap", [*messages[:11], again, *messages[11:]]))
    np.testing.assert_allclose(np.degrees(found.angles), ANGLES, atol=1e-9)
    assert f"1 message {told} is left out" in found.notes


@pytest.mark.parametrize("share", [0.3, 0.6, 0.99])
def test_a_log_whose_recorder_was_killed_is_read_as_far_as_it_is_whole(tmp_path: Path, share: float) -> None:
    """Its index at the end is missing, and its last chunk ends anywhere: "damaged, export it again" was the answer."""
    path = log_file(tmp_path / "a.mcap", whole(UNIX), chunk=1000)
    data = path.read_bytes()
    path.write_bytes(data[: int(share * len(data))])
    found = read(path)
    count = len(found.time)
    np.testing.assert_allclose(np.degrees(found.angles), ANGLES[:count], atol=1e-9)
    assert share * COUNT / 2 < count <= COUNT
    (told,) = [note for note in found.notes if "the file has no end" in note]
    assert f"{count} messages of /joint_states are whole and are read" in told
    assert isinstance(told, Remark)
    assert told.severity == "decide"


def test_a_log_that_is_cut_before_its_first_message_is_refused(tmp_path: Path) -> None:
    path = log_file(tmp_path / "a.mcap", whole(UNIX))
    path.write_bytes(path.read_bytes()[:-2000])
    with pytest.raises(UserError, match=r"a\.mcap: is cut off before its first joint state"):
        read(path)


@pytest.mark.parametrize("size", [100 * STEP, 50 * STEP + 1_300_000, -70 * STEP])
def test_a_step_of_the_clock_is_taken_out(tmp_path: Path, size: int) -> None:
    """Sorted by their stamps the two stretches were shuffled into one another, or a gap was read that was not there."""
    logged = [t + 10**6 + 300_000 * (k % 2) for k, (t, _, _) in enumerate(whole(UNIX))]
    stamped = [(t - size * (k >= 37), joints, row) for k, (t, joints, row) in enumerate(whole(UNIX))]
    found = read(log_file(tmp_path / "a.mcap", stamped, logged))
    np.testing.assert_allclose(np.degrees(found.angles), ANGLES, atol=1e-9)
    np.testing.assert_allclose(found.time, 0.005 * np.arange(COUNT), rtol=0.0, atol=4e-4)
    (told,) = [note for note in found.notes if "the clock that stamps" in note]
    way, far = re.findall(r"at 0.185 s (back|ahead) by ([.\d]+) s", told)[0]
    assert way == ("back" if size > 0 else "ahead")
    assert float(far) == pytest.approx(1e-9 * abs(size), abs=4e-4)


def test_late_messages_and_pauses_are_no_steps(tmp_path: Path) -> None:
    """A message that is published 30 ms late, messages that wait 60 ms for the network, and a pause of 0.2 s."""
    stamped = [(t + 40 * STEP * (k >= 60), joints, row) for k, (t, joints, row) in enumerate(whole(UNIX))]
    logged = [t + 10**6 for t, _, _ in stamped]
    logged[20] += 6 * STEP
    logged[30:42] = [max(each, stamped[42][0] + 1000 * k) for k, each in enumerate(logged[30:42])]
    found = read(log_file(tmp_path / "a.mcap", stamped, logged))
    np.testing.assert_allclose(found.time, 1e-9 * np.array([t - UNIX for t, _, _ in stamped]), rtol=0.0, atol=1e-9)
    assert not [note for note in found.notes if "the clock that stamps" in note]


def test_a_stamp_with_other_values_is_told_as_such(tmp_path: Path) -> None:
    stamped = [(t - STEP * (k % 2), joints, row) for k, (t, joints, row) in enumerate(whole(UNIX))]
    found = read(log_file(tmp_path / "a.mcap", stamped))
    assert [
        note for note in found.notes if note.startswith("40 messages repeat the stamp of another with other values")
    ]
