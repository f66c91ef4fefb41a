"""Robot logs: joints by name, from MCAP files and ROS bags: angles, commands, efforts, voltages and currents.

States are ``sensor_msgs/JointState``, ``control_msgs/JointTrajectoryControllerState`` (which also has the commands) or
``control_msgs/DynamicJointState``. Commands may also come on a topic of their own: joint states, or numbers without
names (``std_msgs/Float64MultiArray``, ``Float64``), whose joints the project names.

MCAP is read by ``mcap``; its messages may be CDR (ROS 2), ROS 1's own or JSON. Bags of ROS 1 (``.bag``) and ROS 2
(``.db3``, in the folder with its ``metadata.yaml``) are read by ``rosbags``, which needs no ROS. The clock is the
message's own stamp, or if zero the time of its logging.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.import_mapping import CommandTopic, Mapping
from synth.files.log_clock import LARGE
from synth.files.validate import near
from synth.motion.importers.child import read_in_child
from synth.motion.importers.foreign_data import Channels, name_list
from synth.motion.importers.registry import loader
from synth.motion.importers.stamp_steps import without_steps
from synth.remarks import decisive

MCAP = b"\x89MCAP0\r\n"
ROS1 = b"#ROSBAG V2.0"
SQLITE = b"SQLite format 3\x00"
READER = Path(__file__).with_name("ros_messages.py")
KEYS = frozenset({"topic", "commands"})
COMMANDING = re.compile(r"command|cmd|desired|target|goal|reference", re.IGNORECASE)  # topics of commands
UNITS = {"position": "rad", "command": "rad", "effort": "N*m", "voltage": "V", "current": "A"}
PATHS = "trajectory_msgs/JointTrajectory"


@dataclass(frozen=True)
class Topic:
    """One topic.

    ``stamp`` and ``logged`` (n,) s after the log's ``begin``; ``values`` of each quantity (n, n_joint), nan where
    missing.
    """

    name: str
    kind: str
    joints: tuple[str, ...]
    stamp: Array
    logged: Array
    values: dict[str, Array]

    @property
    def stamped(self) -> bool:
        """Whether every message has a time stamp."""
        return bool(np.isfinite(self.stamp).all())

    @property
    def named(self) -> bool:
        """Whether the messages name the joints."""
        return not self.kind.startswith("std_msgs/")

    @property
    def says_command(self) -> bool:
        """Whether the topic's name is that of commands."""
        return bool(COMMANDING.search(self.name.rpartition("/")[2]))

    def time(self, delay: float) -> Array:
        """Times (n,) s on the clock of the stamps; logging times are ``delay`` s later."""
        return np.where(np.isfinite(self.stamp), self.stamp, self.logged - delay)


def is_mcap(start: bytes, path: Path) -> bool:
    """Whether a file begins with MCAP's mark."""
    return start.startswith(MCAP)


def is_bag(start: bytes, path: Path) -> bool:
    """Whether a file is a ROS 1 bag, or the data base of a ROS 2 bag."""
    return start.startswith(ROS1) or (start.startswith(SQLITE) and (path.parent / "metadata.yaml").is_file())


@loader("mcap", "MCAP", is_mcap, "channels", keys=KEYS, needs=("mcap", "robot-logs"), own_clock=True)
def read_mcap(path: Path, mapping: Mapping, name: str) -> Channels:
    """Joint positions by name, rad, with the log's other quantities of them."""
    return _channels(_content(path, name, "MCAP", mcap=True), mapping, name)


@loader("rosbag", "ROS bag", is_bag, "channels", keys=KEYS, needs=("rosbags", "robot-logs"), own_clock=True)
def read_bag(path: Path, mapping: Mapping, name: str) -> Channels:
    """Joint positions by name, rad, with the log's other quantities of them."""
    return _channels(_content(path, name, "ROS bag", mcap=False), mapping, name)


def _content(path: Path, name: str, title: str, *, mcap: bool) -> dict[str, Any]:
    code = READER.read_text(encoding="utf-8") + f"\narrays = joint_arrays(path, mcap={mcap})\n"
    return read_in_child(code, path, name, title)


def _topics(content: dict[str, Any]) -> dict[str, Topic]:
    found = {}
    for i, (name, kind) in enumerate(zip(content["topics"], content["kinds"], strict=True)):
        values = {str(q): np.asarray(content[f"{q}{i}"]) for q in content[f"quantities{i}"]}
        joints = tuple(str(joint) for joint in content[f"names{i}"])
        found[str(name)] = Topic(str(name), str(kind), joints, content[f"stamp{i}"], content[f"logged{i}"], values)
    return found


def _channels(content: dict[str, Any], mapping: Mapping, name: str) -> Channels:
    """Joint states of one topic in the order of their stamps, and commands of other topics, on the log's own clock.

    A large clock (``log_clock``) counts from the first state, which ``begins`` tells.
    """
    topics = _topics(content)
    unread = dict(zip(map(str, content["unread"]), map(str, content["why"]), strict=True))
    cut = bool(content["cut"])
    if cut and not topics:
        raise UserError(Problem("is cut off before its first joint state; copy or record it again", name))
    states = _states(topics, unread, mapping.topic, name)
    notes = [f"joint states of {states.name}", *([_without_end(states)] if cut else [])]
    states = replace(states, stamp=without_steps(states.stamp, states.logged, notes, states.name))
    with_stamp = np.isfinite(states.stamp)
    delay = float(np.median((states.logged - states.stamp)[with_stamp])) if with_stamp.any() else 0.0
    names, units, columns = list(states.joints), ["rad"] * len(states.joints), [states.values["position"]]
    for quantity in states.values:
        if quantity != "position":
            names += [f"{joint} {quantity}" for joint in states.joints]
            units += [UNITS[quantity]] * len(states.joints)
            columns.append(states.values[quantity])
    time, values = _one_row_a_stamp(states.time(delay), np.hstack(columns), notes)
    # A log's whole seconds are kept apart: a double of Unix seconds holds no ns.
    whole = float(content["begin"])
    large = abs(whole + time[0]) >= LARGE
    shift, begins = (-float(time[0]), whole + float(time[0])) if large else (whole, 0.0)
    others = _commands(topics, states, mapping.commands, name)
    inputs = []
    for topic, joints in others:
        late = "" if topic.stamped else f", at the time of logging less {1e3 * delay:.3g} ms, by which states are late"
        notes.append(f"commands of {topic.name}{late}")
        given = topic.values["command" if "command" in topic.values else "position"]
        steady = replace(topic, stamp=without_steps(topic.stamp, topic.logged, notes, topic.name))
        own, commands = _one_row_a_stamp(steady.time(delay), given, notes)
        titles = tuple(f"{joint} command" for joint in joints)
        inputs.append(Channels(topic.name, titles, ("rad",) * len(titles), commands, own + shift))
    hint = "" if others else _hint(topics, states, unread)
    return Channels(
        name, tuple(names), tuple(units), values, time + shift, tuple(notes), inputs=tuple(inputs), hint=hint,
        begins=begins,
    )  # fmt: skip


def _without_end(states: Topic) -> str:
    """The note on a log whose last part was not written, or not copied."""
    return decisive(
        "the file has no end: its recorder was killed, or the copy is cut off. "
        + _messages(len(states.logged), f"of {states.name} are whole and are read"),
        "Compare its size with that of the original; what was logged last, up to a chunk, is not in it.",
    )


def _one_row_a_stamp(time: Array, values: Array, notes: list[str]) -> tuple[Array, Array]:
    """Times (m,) s that increase, and values (m, k), of messages (n,) and (n, k); ``notes`` are added to.

    Messages of one stamp are one row: publishers of other joints may share it. What a message repeats is left out.
    """
    order = np.argsort(time, kind="stable")
    time, values = time[order], values[order]
    first = np.concatenate([[True], np.diff(time) > 0.0])
    row, merged, joined, other = np.cumsum(first) - 1, values[first], 0, 0
    for k in np.flatnonzero(~first):
        before, now = merged[row[k]], np.isfinite(values[k])
        new, known = np.isnan(before) & now, np.isfinite(before) & now
        other += not new.any() and bool(np.any(before[known] != values[k][known]))
        merged[row[k], new] = values[k, new]
        joined += bool(new.any())
    repeated = int((~first).sum()) - joined
    if joined:
        notes.append(_messages(joined, "have the stamp of another that holds other joints, and are joined with it"))
    if other:
        of = _messages(other, "repeat the stamp of another with other values, and are left out")
        remedy = "Look whether two programs publish there, or whether the stamps are those of a slower loop."
        notes.append(decisive(of, remedy))
    if repeated > other:
        notes.append(_messages(repeated - other, "repeat a stamp and are left out"))
    return time[first], merged


def _messages(count: int, text: str) -> str:
    """What is said of messages, with the verbs of one where it is one."""
    for several, one in (("have", "has"), ("repeat", "repeats"), ("are", "is")) if count == 1 else ():
        text = re.sub(rf"\b{several}\b", one, text)
    return f"{count} message{'' if count == 1 else 's'} {text}"


def _states(topics: dict[str, Topic], unread: dict[str, str], wanted: str | None, name: str) -> Topic:
    """The topic with the measured angles."""
    able = {key: topic for key, topic in topics.items() if "position" in topic.values}
    if wanted is not None:
        if wanted in able:
            return able[wanted]
        why = f": {unread[wanted]}" if wanted in unread else near(wanted, list(able))
        raise UserError(Problem(f'there are no joint states on "{wanted}"{why}', name))
    if not able:
        also = "".join(f"; {topic}: {why}" for topic, why in unread.items())
        without = [topic.name for topic in topics.values() if topic.named and topic.values]
        empty = f"; those on {name_list(without)} have no positions" if without else ""
        raise UserError(Problem(f"contains no joint states (sensor_msgs/JointState) with positions{empty}{also}", name))
    for chosen in (able, {k: t for k, t in able.items() if not t.says_command or "command" in t.values}):
        if len(chosen) == 1:
            return next(iter(chosen.values()))
    both = [topic for topic in able.values() if "command" in topic.values]
    if len(both) == 1:
        return both[0]  # angles and commands in one message
    text = f"has joint states on {name_list(able)}; choose one in a project: topic: {next(iter(able))}"
    raise UserError(Problem(text, name))


def _commands(
    topics: dict[str, Topic], states: Topic, wanted: Sequence[CommandTopic], name: str
) -> list[tuple[Topic, tuple[str, ...]]]:
    """Topics of commands other than the states, each with its joints in the order of its values."""
    if not wanted:
        able = _named_commands(topics, states)
        return [] if "command" in states.values or len(able) != 1 else [(able[0], able[0].joints)]
    found, problems = [], []
    able_names = [key for key, topic in topics.items() if {"command", "position"} & set(topic.values)]
    for each in wanted:
        topic = topics.get(each.topic)
        if topic is None or each.topic not in able_names:
            problems.append(Problem(f'there are no commands on "{each.topic}"{near(each.topic, able_names)}', name))
        elif not topic.named and len(each.joints) != len(topic.joints):
            text = f"commands on {each.topic} have {len(topic.joints)} numbers and no names; name their joints in this "
            problems.append(Problem(f"{text}order: commands: {{topic: {each.topic}, joints: [...]}}", name))
        elif topic.named and each.joints:
            problems.append(Problem(f'commands on {each.topic} name their joints; leave "joints" out', name))
        else:
            found.append((topic, topic.joints if topic.named else each.joints))
    if problems:
        raise UserError(problems)
    return found


def _named_commands(topics: dict[str, Topic], states: Topic) -> list[Topic]:
    """Topics that can only be commands and that name their joints."""
    others = [topic for topic in topics.values() if topic.named and topic is not states]
    return [t for t in others if "command" in t.values or ("position" in t.values and t.says_command)]


def _hint(topics: dict[str, Topic], states: Topic, unread: dict[str, str]) -> str:
    """The message on the log's topics for a project that names no commands."""
    several = _named_commands(topics, states)
    found = []
    if len(several) > 1:
        found.append(f"commands are on {name_list(t.name for t in several)}: choose with commands: {several[0].name}")
    for topic in topics.values():
        if not topic.named and "command" in topic.values:
            count = len(topic.joints)
            text = f"{topic.name} has {count} numbers without joints' names: commands: {{topic: {topic.name}, joints: "
            found.append(f"{text}[{', '.join(states.joints[:count])}]}}")
        elif topic.kind == PATHS:
            text = f"{topic.name} has whole trajectories, between whose points the controller interpolates: log its "
            found.append(f"{text}state too (control_msgs/JointTrajectoryControllerState)")
    return "; ".join([*found, *(f"{topic}: {why}" for topic, why in unread.items())])
