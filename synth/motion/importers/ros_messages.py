"""Joint messages of a robot's log as arrays.

``from_ros`` passes the text of this module to a separate process (see ``child``), so it imports nothing of synth. Types
that neither the file nor ``rosbags`` defines are listed as unread.
"""

import json
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy

# Name of a type without "msg" -> whether its messages name the joints.
KINDS = {
    "sensor_msgs/JointState": True,
    "control_msgs/JointTrajectoryControllerState": True,
    "control_msgs/DynamicJointState": True,
    "std_msgs/Float64MultiArray": False,
    "std_msgs/Float64": False,
    "trajectory_msgs/JointTrajectory": True,
}
JOINT_STATE = "sensor_msgs/JointState"
INTERFACES = ("position", "effort", "voltage", "current")  # of a DynamicJointState
Message = tuple[str, str, int, Any]  # topic, type, time of logging in ns, content
SECOND = 1_000_000_000  # ns
MCAP_END = b"\x89MCAP0\r\n"  # last bytes of a whole file, as its first ones


def short(kind: str) -> str:
    """A type's name as in ``KINDS``: "sensor_msgs/msg/JointState" -> "sensor_msgs/JointState"."""
    plain = kind.replace("/msg/", "/")
    return JOINT_STATE if plain == "JointState" else plain


def part(content: Any, *names: str) -> Any:
    """The first of some fields that exists and is not empty, of a message or of a JSON object; None if none is."""
    for name in names:
        value = content.get(name) if isinstance(content, dict) else getattr(content, name, None)
        if value is not None and (not hasattr(value, "__len__") or len(value)):
            return value
    return None


def stamp_of(content: Any) -> int:
    """The time stamp of the message, ns; 0 if it has none."""
    stamp = part(part(content, "header") or {}, "stamp") or {}
    return SECOND * int(part(stamp, "sec") or 0) + int(part(stamp, "nanosec", "nsec") or 0)


def numbers(kind: str, content: Any) -> tuple[list[str], dict[str, list[float]]]:
    """Names of the joints, and the values of each quantity in the same order."""
    if kind == JOINT_STATE:
        return list(part(content, "name") or []), _present_values(
            position=part(content, "position"), effort=part(content, "effort")
        )
    names = list(part(content, "joint_names") or [])
    if kind.endswith("ControllerState"):
        measured, wanted = part(content, "feedback", "actual"), part(content, "reference", "desired")
        if part(measured, "positions") is None:  # newer fields exist in addition to the older ones and may be empty
            measured, wanted = part(content, "actual") or measured, part(content, "desired") or wanted
        position, effort = part(measured, "positions"), part(measured, "effort")
        return names, _present_values(position=position, effort=effort, command=part(wanted, "positions"))
    if kind.endswith("DynamicJointState"):
        found: dict[str, list[float]] = {}
        for k, own in enumerate(part(content, "interface_values") or []):
            values = part(own, "values")
            for quantity, value in zip(
                part(own, "interface_names") or [], [] if values is None else values, strict=False
            ):
                if quantity in INTERFACES:
                    found.setdefault(quantity, [numpy.nan] * len(names))[k] = float(value)
        return names, found
    data = part(content, "data")
    return [], {} if data is None else _present_values(command=data if hasattr(data, "__len__") else [data])


def _present_values(**values: Any) -> dict[str, list[float]]:
    return {name: [float(value) for value in given] for name, given in values.items() if given is not None}


def has_no_end(path: str) -> bool:
    """Whether an MCAP file lacks its last record and its end: its recorder was killed, or a copy was cut off."""
    with open(path, "rb") as stream:  # noqa: PTH123 - a child's text is plain
        stream.seek(-min(len(MCAP_END), stream.seek(0, 2)), 2)
        return stream.read() != MCAP_END


def mcap_records(path: str) -> Iterator[tuple[Any, Any, Any]]:
    """Schema, channel and message of an MCAP file in the order of logging; of one without an end what is whole."""
    from mcap.exceptions import EndOfFile
    from mcap.reader import NonSeekingReader, make_reader

    with open(path, "rb") as stream:  # noqa: PTH123 - a child's text is plain
        if not has_no_end(path):
            yield from make_reader(stream).iter_messages()
            return
        found = []
        try:
            for each in NonSeekingReader(stream).iter_messages(log_time_order=False):
                found.append(each)
        except (EndOfFile, struct.error):  # in the bytes of a record, or in those of its length
            pass
        yield from sorted(found, key=lambda each: each[2].log_time)


def mcap_messages(path: str, unread: dict[str, str]) -> Iterator[Message]:
    """Messages of types in ``KINDS`` from an MCAP file; unreadable topics go to ``unread`` with the reason."""
    stores: dict[str, Any] = {}
    for schema, channel, message in mcap_records(path):
        kind = "" if schema is None else short(schema.name)
        if schema is None or kind not in KINDS or channel.topic in unread:
            continue
        time, coding = message.log_time, channel.message_encoding
        if coding == "json":
            yield channel.topic, kind, time, json.loads(message.data)
            continue
        if coding not in ("cdr", "ros1"):
            raise ValueError(f"{channel.topic} is encoded as {coding}; cdr, ros1, json are read")
        name = kind.replace("/", "/msg/")
        if coding not in stores:
            stores[coding] = typestore(coding)
        store = stores[coding]
        if name not in store.fielddefs and not add_types(store, schema, name):
            unread[channel.topic] = f"{kind}: the file does not define this type as text"
            continue
        read = store.deserialize_ros1 if coding == "ros1" else store.deserialize_cdr
        yield channel.topic, kind, time, read(message.data, name)


def typestore(coding: str) -> Any:
    """The types that ``rosbags`` defines for this encoding."""
    from rosbags.typesys import Stores, get_typestore

    return get_typestore(Stores.ROS1_NOETIC if coding == "ros1" else Stores.ROS2_HUMBLE)


def add_types(store: Any, schema: Any, name: str) -> bool:
    """Add the types of the file's schema to ``store``; returns whether they include ``name``."""
    from rosbags.typesys import get_types_from_msg

    if schema.encoding not in ("ros2msg", "ros1msg"):
        return False
    types = get_types_from_msg(schema.data.decode(), name)
    store.register({key: value for key, value in types.items() if key not in store.fielddefs})
    return name in store.fielddefs


def bag_messages(path: str, unread: dict[str, str]) -> Iterator[Message]:
    """Messages of types in ``KINDS`` from a ROS 1 bag, or from a ROS 2 bag given by its data base; see above."""
    from rosbags.highlevel import AnyReader

    place = Path(path)
    place = place if place.suffix == ".bag" else place.parent
    with AnyReader([place], default_typestore=typestore("cdr")) as reader:
        wanted = [item for item in reader.connections if short(item.msgtype) in KINDS]
        for connection, time, data in reader.messages(connections=wanted):
            if connection.topic in unread:
                continue
            kind = short(connection.msgtype)
            try:
                content = reader.deserialize(data, connection.msgtype)
            except KeyError:
                unread[connection.topic] = f"{kind}: the bag does not define this type (bags from ROS 2 Iron on do)"
                continue
            yield connection.topic, kind, time, content


def joint_arrays(path: str, *, mcap: bool) -> dict[str, Any]:
    """All joint data of a log.

    Returns
    -------
    ``topics`` and ``kinds`` (k,), ``unread`` and ``why``; ``begin`` whole s, beside which a double holds no ns; ``cut``
    of an MCAP file without an end; for topic i ``names{i}`` (m,), ``stamp{i}`` and ``logged{i}`` (n,) s after the
    begin, and each quantity in ``quantities{i}`` as (n, m), nan if a message lacks it.
    """
    unread: dict[str, str] = {}
    rows: dict[str, list[Any]] = {}
    kinds: dict[str, str] = {}
    for topic, kind, time, content in (mcap_messages if mcap else bag_messages)(path, unread):
        kinds[topic] = kind
        rows.setdefault(topic, []).append((time, stamp_of(content), *numbers(kind, content)))
    topics = sorted(rows)
    arrays = {"topics": numpy.array(topics, dtype=str), "kinds": numpy.array([kinds[t] for t in topics], dtype=str)}
    arrays |= {"unread": numpy.array(list(unread), dtype=str), "why": numpy.array(list(unread.values()), dtype=str)}
    every = [row for topic in topics for row in rows[topic]]
    begin = min((row[1] for row in every if row[1]), default=min((row[0] for row in every), default=0)) // SECOND
    arrays["begin"] = numpy.array(begin)
    arrays["cut"] = numpy.array(mcap and has_no_end(path))
    for i, topic in enumerate(topics):
        arrays |= _topic_arrays(rows[topic], i, begin * SECOND)
    return arrays


def _topic_arrays(rows: list[Any], i: int, begin: int) -> dict[str, Any]:
    width = max(len(values) for _, _, _, found in rows for values in [[], *found.values()])
    named = any(names for _, _, names, _ in rows)
    seen = dict.fromkeys(str(name) for _, _, names, _ in rows for name in names)
    names = list(seen) if named else [str(k + 1) for k in range(width)]
    place = {name: k for k, name in enumerate(names)}
    quantities = list(dict.fromkeys(quantity for _, _, _, found in rows for quantity in found))
    made = {quantity: numpy.full((len(rows), len(names)), numpy.nan) for quantity in quantities}
    for row, (_, _, given, found) in enumerate(rows):
        for quantity, values in found.items():
            for name, value in zip(given or names, values, strict=False):
                made[quantity][row, place[str(name)]] = value
    return {
        f"names{i}": numpy.array(names, dtype=str),
        f"logged{i}": numpy.array([1e-9 * (row[0] - begin) for row in rows]),
        f"stamp{i}": numpy.array([1e-9 * (row[1] - begin) if row[1] else numpy.nan for row in rows]),
        f"quantities{i}": numpy.array(quantities, dtype=str),
        **{f"{quantity}{i}": values for quantity, values in made.items()},
    }
