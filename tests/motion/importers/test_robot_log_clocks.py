"""Stamps of a robot's log: a window on its own clock, and publishers of different joints that share a stamp."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from motion.importers.simulated_leg import NAMES, leg
from synth.errors import UserError
from synth.files.import_project import Mapping
from synth.motion.importers.convert import ImportedRecording, import_file

COUNT, STEP = 80, 5_000_000  # messages, ns
UNIX = 1_700_000_000 * 10**9 + 123_456_789  # ns
ANGLES = np.column_stack([100 + 0.1 * np.arange(COUNT), 110 - 0.2 * np.arange(COUNT), 140 + 0.05 * np.arange(COUNT)])
Message = tuple[int, tuple[int, ...], NDArray[np.float64]]  # stamp in ns, joints, their angles in deg


def log_file(path: Path, messages: Iterable[Message]) -> Path:
    """An MCAP log of joint states as JSON."""
    writer = pytest.importorskip("mcap.writer").Writer
    with path.open("wb") as stream:
        log = writer(stream)
        log.start()
        schema = log.register_schema("sensor_msgs/msg/JointState", "jsonschema", b"{}")
        channel = log.register_channel("/joint_states", "json", schema)
        for stamp, joints, values in messages:
            head = {"stamp": {"sec": stamp // 10**9, "nanosec": stamp % 10**9}}
            content = {"header": head, "name": [NAMES[j] for j in joints], "position": np.radians(values).tolist()}
            log.add_message(channel, log_time=stamp + 10**6, publish_time=0, data=json.dumps(content).encode())
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


def test_a_message_that_repeats_joint_and_stamp_is_left_out(tmp_path: Path) -> None:
    messages = whole(UNIX)
    again = (messages[10][0], (0, 1, 2), ANGLES[10] + 5.0)
    found = read(log_file(tmp_path / "a.mcap", [*messages[:11], again, *messages[11:]]))
    np.testing.assert_allclose(np.degrees(found.angles), ANGLES, atol=1e-9)
    assert "1 messages repeat a stamp and are left out" in found.notes
