"""Robot logs: joint states (``sensor_msgs/JointState``) by name, from MCAP files and ROS bags.

MCAP is read by ``mcap``; its messages may be CDR (ROS 2), ROS 1's own or JSON. Bags of ROS 1 (``.bag``) and ROS 2
(``.db3``, in the folder with its ``metadata.yaml``) are read by ``rosbags``, which needs no ROS. The clock is the
message's own stamp, or if zero the time of its logging.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from synth.errors import Problem, UserError
from synth.files.import_project import Mapping
from synth.files.validate import near
from synth.motion.importers.child import read_in_child
from synth.motion.importers.foreign_data import Channels, listed
from synth.motion.importers.registry import loader

MCAP = b"\x89MCAP0\r\n"
ROS1 = b"#ROSBAG V2.0"
SQLITE = b"SQLite format 3\x00"

# Collects (topic, time, names, positions) of every joint state; turned into arrays at the end.
_COLLECT = """
found = []
def add(topic, log_time, stamp, names, positions):
    found.append((topic, stamp if stamp else log_time * 1e-9, tuple(map(str, names)), [float(p) for p in positions]))
def packed():
    topics = sorted({item[0] for item in found})
    arrays = {"topics": numpy.array(topics, dtype=str)}
    for k, topic in enumerate(topics):
        own = [item for item in found if item[0] == topic]
        names = list(dict.fromkeys(name for item in own for name in item[2]))
        place = {name: i for i, name in enumerate(names)}
        values = numpy.full((len(own), len(names)), numpy.nan)
        for row, (_, _, given, positions) in enumerate(own):
            for name, position in zip(given, positions):
                values[row, place[name]] = position
        arrays[f"names{k}"] = numpy.array(names, dtype=str)
        arrays[f"time{k}"] = numpy.array([item[1] for item in own], dtype=float)
        arrays[f"values{k}"] = values
    return arrays
"""
_MCAP = """
import json
from mcap.reader import make_reader
def store(kind):
    from rosbags.typesys import Stores, get_typestore
    return get_typestore(Stores.ROS1_NOETIC if kind == "ros1" else Stores.ROS2_HUMBLE)
stores = {}
with open(path, "rb") as stream:
    for schema, channel, message in make_reader(stream).iter_messages():
        if schema is None or schema.name.replace("/msg/", "/") not in ("sensor_msgs/JointState", "JointState"):
            continue
        if channel.message_encoding == "json":
            said = json.loads(message.data)
            stamp = said.get("header", {}).get("stamp", {})
            seconds = stamp.get("sec", 0) + 1e-9 * stamp.get("nanosec", stamp.get("nsec", 0))
            add(channel.topic, message.log_time, seconds, said["name"], said["position"])
            continue
        if channel.message_encoding not in ("cdr", "ros1"):
            raise ValueError(f"{channel.topic} is encoded as {channel.message_encoding}; cdr, ros1, json are read")
        kind = channel.message_encoding
        types = stores.setdefault(kind, store(kind))
        read = types.deserialize_ros1 if kind == "ros1" else types.deserialize_cdr
        said = read(message.data, "sensor_msgs/msg/JointState")
        stamp = said.header.stamp.sec + 1e-9 * said.header.stamp.nanosec
        add(channel.topic, message.log_time, stamp, said.name, said.position)
arrays = packed()
"""
_BAG = """
from pathlib import Path
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore
place = Path(path)
place = place if place.suffix == ".bag" else place.parent
with AnyReader([place], default_typestore=get_typestore(Stores.ROS2_HUMBLE)) as reader:
    wanted = [item for item in reader.connections if item.msgtype == "sensor_msgs/msg/JointState"]
    for connection, time, data in reader.messages(connections=wanted):
        said = reader.deserialize(data, connection.msgtype)
        stamp = said.header.stamp.sec + 1e-9 * said.header.stamp.nanosec
        add(connection.topic, time, stamp, said.name, said.position)
arrays = packed()
"""


def is_mcap(start: bytes, path: Path) -> bool:
    """Whether a file begins with MCAP's mark."""
    return start.startswith(MCAP)


def is_bag(start: bytes, path: Path) -> bool:
    """Whether a file is a ROS 1 bag, or the data base of a ROS 2 bag."""
    return start.startswith(ROS1) or (start.startswith(SQLITE) and (path.parent / "metadata.yaml").is_file())


@loader("mcap", "MCAP", is_mcap, "channels", keys=frozenset({"topic"}), needs=("mcap", "robot-logs"), own_clock=True)
def read_mcap(path: Path, mapping: Mapping, name: str) -> Channels:
    """Joint positions by name, rad."""
    return _channels(read_in_child(_COLLECT + _MCAP, path, name, "MCAP"), mapping, name)


@loader(
    "rosbag", "ROS bag", is_bag, "channels", keys=frozenset({"topic"}), needs=("rosbags", "robot-logs"), own_clock=True
)
def read_bag(path: Path, mapping: Mapping, name: str) -> Channels:
    """Joint positions by name, rad."""
    return _channels(read_in_child(_COLLECT + _BAG, path, name, "ROS bag"), mapping, name)


def _channels(content: dict[str, Any], mapping: Mapping, name: str) -> Channels:
    """The joint states of one topic, in the order of their stamps, the clock from zero."""
    topics = [str(topic) for topic in content["topics"]]
    if not topics:
        raise UserError(Problem("contains no joint states (sensor_msgs/JointState)", name))
    if mapping.topic is not None and mapping.topic not in topics:
        raise UserError(Problem(f'there are no joint states on "{mapping.topic}"{near(mapping.topic, topics)}', name))
    if mapping.topic is None and len(topics) > 1:
        text = f"has joint states on {listed(topics)}; choose one in a project: topic: {topics[0]}"
        raise UserError(Problem(text, name))
    k = topics.index(mapping.topic) if mapping.topic is not None else 0
    time = np.asarray(content[f"time{k}"])
    order = np.argsort(time, kind="stable")
    kept = order[np.concatenate([[True], np.diff(time[order]) > 0.0])]
    notes = [f"joint states of {topics[k]}; the clock begins at {time[kept[0]]:.6f} s, set to 0"]
    if len(kept) < len(time):
        notes.append(f"{len(time) - len(kept)} messages repeat a stamp and are left out")
    names = tuple(str(joint) for joint in content[f"names{k}"])
    values = np.asarray(content[f"values{k}"])[kept]
    return Channels(name, names, ("rad",) * len(names), values, time[kept] - time[kept[0]], tuple(notes))
