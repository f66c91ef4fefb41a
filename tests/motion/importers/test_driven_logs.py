"""Logs of driven legs: commands, currents, torques and supply from CSV, JSON, MCAP and bags, each to the same trial."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from synth.cli import main
from synth.errors import UserError
from synth.files.gap_project import read_gap_project
from synth.files.leg_file import read_leg
from synth.files.recording import Recorded, read_recording

Array = NDArray[np.float64]
TIME = 100.0 + 0.01 * np.arange(60)
ANGLES = np.column_stack([0.4 * np.sin(9.0 * TIME), 0.3 * np.cos(7.0 * TIME)])  # rad, of the robot's own joints
COMMANDS = np.column_stack([0.4 * np.sin(9.0 * TIME + 0.2), 0.3 * np.cos(7.0 * TIME + 0.2)])
JOINTS = ("hip_joint", "knee_joint")
MOTOR = "motor: {resistance: 3 ohm, torque_constant: 0.4 N*m/A}"
SERVO = f"{{kind: servo, gain: 2 1/rad, supply: 12 V, {MOTOR}}}"
LEG = """kind: leg
name: robot leg
joints:
  - {{name: hip, zero: 10 deg, sign: -1, link: {{length: 0.1 m, mass: 0.3 kg, com: 0.05 m, inertia: 1e-3 kg*m^2}},
     drive: {drive}}}
  - {{name: knee, zero: 0 deg, sign: +1, link: {{length: 0.1 m, mass: 0.2 kg, com: 0.05 m, inertia: 1e-3 kg*m^2}},
     drive: {drive}}}
"""
PROJECT = """kind: import
leg: robot.leg.yaml
files: [{file}]
joints: {{hip: {{column: hip_joint{hip}}}, knee: {{column: knee_joint{knee}}}}}
"""
# control_msgs as of ROS 2 Jazzy, the fields that matter here; a file's own definition tells which it has.
CONTROLLER_STATE = """std_msgs/Header header
string[] joint_names
trajectory_msgs/JointTrajectoryPoint reference
trajectory_msgs/JointTrajectoryPoint feedback
"""
DYNAMIC_STATE = """std_msgs/Header header
string[] joint_names
control_msgs/InterfaceValue[] interface_values
================================================================================
MSG: control_msgs/InterfaceValue
string[] interface_names
float64[] values
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "robot.leg.yaml").write_text(LEG.format(drive=SERVO))
    return tmp_path


def project(folder: Path, file: str, *, hip: str = "", knee: str = "", more: str = "") -> Path:
    path = folder / "import.yaml"
    path.write_text(PROJECT.format(file=file, hip=hip, knee=knee) + more)
    return path


def imported(folder: Path, file: str, **words: str) -> tuple[Recorded, list[str], list[str]]:
    """The trial as ``synth gap`` reads it, the titles of its columns, and the import's messages."""
    assert main(["--quiet", "import", str(project(folder, file, **words)), "--out", str(folder / "out")]) == 0
    found = read_gap_project(folder / "out" / "gap.yaml")
    assert found.leg.joints[0].drive is not None
    path = next((folder / "out" / "trials").iterdir())
    notes = json.loads((folder / "out" / "import.json").read_text())["trials"][0]["notes"]
    return read_recording(path, found.leg), path.read_text().partition("\n")[0].split(","), notes


def as_logged(found: Recorded, within: float = 1e-9) -> None:
    """Angles as they were, commands held from each sample to the next."""
    np.testing.assert_allclose(found.angles, ANGLES, atol=within)
    assert found.signals is not None
    assert found.signals.held == (0, 1)
    np.testing.assert_allclose(in_sense(found), COMMANDS, atol=within)


def in_sense(found: Recorded) -> Array:
    """(n, 2) rad, the commands in the measured sense, at the rows of the table."""
    assert found.signals is not None
    at = np.searchsorted(found.signals.time, found.time - 1e-9)
    return np.asarray(found.signals.command[at])


def log_csv(folder: Path, header: str, *columns: Array) -> None:
    table = np.column_stack([TIME - TIME[0], *columns])
    np.savetxt(folder / "log.csv", table, "%.12g", ",", header=header, comments="")


def test_commands_of_a_csv_are_found_by_their_names(folder: Path) -> None:
    header = "time [s],hip_joint [rad],knee_joint [rad],hip_joint_goal_position [rad],cmd_knee [rad],"
    header += "supply [V],knee current [mA]"
    log_csv(folder, header, ANGLES, COMMANDS, np.full(60, 11.5), np.full(60, 250.0))
    found, titles, notes = imported(folder, "log.csv")
    as_logged(found)
    assert titles == ["time [s]", "hip [deg]", "knee [deg]", "hip command [deg]", "knee command [deg]", "supply [V]"]
    assert found.signals is not None
    np.testing.assert_allclose(found.signals.supply, 11.5)
    assert "hip command: from hip_joint_goal_position" in notes
    assert not any("release" in note for note in notes)


def test_commands_by_columns_that_the_project_names(folder: Path) -> None:
    """Another sign and zero of the log hold for the command too; a window cuts both."""
    log_csv(folder, "t,a,b,c,d,hold,u", np.degrees(ANGLES), np.degrees(COMMANDS), np.ones(60), np.full(60, 7400.0))
    text = "kind: import\nleg: robot.leg.yaml\nfiles: [{file: log.csv, window: [0.1 s, 0.4 s]}]\n"
    text += "time: {column: t, unit: s}\nsupply: {column: u, unit: mV}\njoints:\n"
    text += "  hip: {column: a, unit: deg, sign: +1, zero: 0 deg, command: c, enabled: hold}\n"
    text += "  knee: {column: b, unit: deg, command: {column: d, unit: deg}}\n"
    (folder / "import.yaml").write_text(text)
    assert main(["--quiet", "import", str(folder / "import.yaml"), "--out", str(folder / "out")]) == 0
    found = read_recording(folder / "out" / "trials" / "log.csv", read_leg(folder / "robot.leg.yaml"))
    assert len(found.time) == 31
    np.testing.assert_allclose(found.angles[:, 0], np.radians(10.0) - ANGLES[10:41, 0], atol=1e-9)
    assert found.signals is not None
    np.testing.assert_allclose(found.signals.supply[:, 1], 7.4)
    np.testing.assert_allclose(in_sense(found)[:, 0], np.radians(10.0) - COMMANDS[10:41, 0], atol=1e-9)


def test_current_and_torque_of_a_torque_drive(folder: Path) -> None:
    drive = "{kind: torque, motor: {torque_constant: 0.1 N*m/A, gear_ratio: 6}}"
    (folder / "robot.leg.yaml").write_text(LEG.format(drive=drive))
    header = "time [s],hip_joint [rad],knee_joint [rad],hip_joint current [mA],knee_joint effort [N*m]"
    log_csv(folder, header, ANGLES, np.full(60, 500.0), np.full(60, 0.7))
    found, titles, _ = imported(folder, "log.csv", hip=", sign: -1")
    assert titles[3:] == ["hip current [A]", "knee torque [N*m]"]
    assert found.torques is not None
    np.testing.assert_allclose(found.torques, [[0.3, 0.7]] * 60)


@pytest.mark.parametrize("effort", [0.7, 0.0])
def test_efforts_of_a_drive_whose_torque_is_known_as_such(folder: Path, effort: float) -> None:
    """They were "not used", and the motion was told to be free of external torques."""
    (folder / "robot.leg.yaml").write_text(LEG.format(drive="{kind: torque}"))
    values = effort * np.sin(5.0 * TIME)
    log_csv(folder, "time [s],hip_joint [rad],knee_joint [rad],knee_joint effort [N*m]", ANGLES, values)
    assert main(["-q", "import", str(project(folder, "log.csv", hip=", sign: -1")), "--out", str(folder / "out")]) == 0
    assert (folder / "out" / "fit.yaml").exists()  # no motor or servo to diagnose
    notes = " ".join(json.loads((folder / "out" / "import.json").read_text())["trials"][0]["notes"])
    found = read_recording(folder / "out" / "trials" / "log.csv", read_leg(folder / "robot.leg.yaml"))
    assert "knee torque: from knee_joint effort" in notes
    assert "no torque of the drive of hip in the file: taken as free there" in notes
    assert ("no external torque after that" in notes) == (effort == 0.0)
    assert found.torques is not None
    np.testing.assert_allclose(found.torques[:, 1], values[-len(found.time) :])


def test_a_voltage_has_the_sign_of_the_angle(folder: Path) -> None:
    (folder / "robot.leg.yaml").write_text(LEG.format(drive=f"{{kind: voltage, {MOTOR}}}"))
    header = "time [s],hip_joint [rad],knee_joint [rad],hip_joint voltage [V],knee_joint voltage [V]"
    log_csv(folder, header, ANGLES, np.full((60, 2), 5.0))
    found, titles, _ = imported(folder, "log.csv", hip=", sign: +1")  # the leg's own is -1: measured is the other way
    assert titles[3:] == ["hip voltage [V]", "knee voltage [V]"]
    assert found.signals is not None
    np.testing.assert_allclose(found.signals.supply, [[5.0, 5.0]] * 60)  # in the sense of q: -1 of -5 V


def test_json_of_a_servo_bench(folder: Path) -> None:
    """The form of BAM's logs: settings of the run, and a record per sample."""
    entries = [
        {
            "timestamp": t - 100.0,
            "position": float(a),
            "goal_position": float(c),
            "input_volts": 7.3,
            "torque_enable": True,
        }
        for t, (a, _), (c, _) in zip(TIME, ANGLES, COMMANDS, strict=True)
    ]
    (folder / "log.json").write_text(json.dumps({"kp": 400, "motor": "xl330", "entries": entries}))
    leg = LEG.format(drive=SERVO).partition("  - {name: knee")[0].replace("-1", "+1").replace("10 deg", "0 deg")
    (folder / "robot.leg.yaml").write_text(leg)
    text = "kind: import\nleg: robot.leg.yaml\nfiles: [log.json]\nsupply: {column: input_volts, unit: V}\n"
    text += "time: {column: timestamp, unit: s}\n"
    text += "joints: {hip: {column: position, unit: rad, command: goal_position, enabled: torque_enable}}\n"
    (folder / "import.yaml").write_text(text)
    assert main(["--quiet", "import", str(folder / "import.yaml"), "--out", str(folder / "out")]) == 0
    found = read_recording(folder / "out" / "trials" / "log.csv", read_leg(folder / "robot.leg.yaml"))
    np.testing.assert_allclose(found.angles[:, 0], ANGLES[:, 0], atol=1e-9)
    assert found.signals is not None
    np.testing.assert_allclose(found.signals.enabled, 1.0)
    (notes,) = [trial["notes"] for trial in json.loads((folder / "out" / "import.json").read_text())["trials"]]
    assert any("kp 400, motor xl330" in note for note in notes)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[{]", "damaged JSON"),
        ('{"a": [{"t": 1}], "b": [{"t": 2}]}', "several lists of records: a, b"),
        ('{"t": [1, 2], "x": [1]}', "lists of different lengths"),
        ('{"t": 1}', "has no list"),
        ('[{"t": "x"}, {"t": "y"}]', "no records with numbers"),
    ],
)
def test_json_without_a_log(folder: Path, text: str, words: str) -> None:
    (folder / "log.json").write_text(text)
    with pytest.raises(UserError, match=words):
        _read(folder, "json")


def _read(folder: Path, form: str) -> None:
    from synth.files.import_project import read_import_project
    from synth.motion.importers.import_result import read_files

    read_files(read_import_project(project(folder, "log.json", more=f"format: {form}\n")))


def log_mcap(path: Path, messages: Sequence[tuple[str, str, str, float, dict[str, Any]]]) -> None:
    """Topic, type, definition, time of logging and content (JSON's form, in CDR where the definition says so)."""
    writer_of = pytest.importorskip("mcap.writer")
    with path.open("wb") as stream:
        writer = writer_of.Writer(stream)
        writer.start()
        channels: dict[str, int] = {}
        for topic, kind, definition, logged, content in messages:
            if topic not in channels:
                coding = "ros2msg" if definition else "jsonschema"
                schema = writer.register_schema(kind, coding, definition.encode() or b"{}")
                channels[topic] = writer.register_channel(topic, "cdr" if definition else "json", schema)
            data = _cdr(kind, definition, content) if definition else json.dumps(content).encode()
            writer.add_message(channels[topic], log_time=round(logged * 1e9), publish_time=0, data=data)
        writer.finish()


def _cdr(kind: str, definition: str, content: dict[str, Any]) -> bytes:
    typesys = pytest.importorskip("rosbags.typesys")
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    types = typesys.get_types_from_msg(definition, kind)
    store.register({key: value for key, value in types.items() if key not in store.fielddefs})
    return bytes(store.serialize_cdr(_message(store, kind, content), kind))


def _message(store: Any, kind: str, content: dict[str, Any]) -> Any:
    """A message of a type: fields that are left out are empty."""
    made: dict[str, Any] = {}
    for field, (node, what) in store.fielddefs[kind][1]:
        value = content.get(field)
        inner = what if node.name == "NAME" else what[0][1] if node.name in ("SEQUENCE", "ARRAY") else None
        if node.name == "NAME":
            made[field] = _message(store, inner, value or {})
        elif node.name == "BASE":
            made[field] = value if value is not None else ("" if what[0] == "string" else 0)
        elif isinstance(inner, str):
            made[field] = [_message(store, inner, each) for each in value or []]
        else:
            made[field] = list(value or []) if inner[0] == "string" else np.array(value or [], dtype=np.float64)
    return store.types[kind](**made)


def stamp(time: float) -> dict[str, Any]:
    seconds, nano = divmod(round(time * 1e9), 10**9)
    return {"stamp": {"sec": seconds, "nanosec": nano}}


@pytest.mark.parametrize("definition", ["", CONTROLLER_STATE])
def test_the_state_of_a_trajectory_controller(folder: Path, definition: str) -> None:
    """It has angles and commands in one message; joint states beside it are not needed."""
    kind = "control_msgs/msg/JointTrajectoryControllerState"
    messages: list[Any] = []
    for k, time in enumerate(TIME):
        point, wanted = {"positions": list(ANGLES[k])}, {"positions": list(COMMANDS[k])}
        said = {"header": stamp(time), "joint_names": list(JOINTS), "feedback": point, "reference": wanted}
        messages.append(("/leg/controller_state", kind, definition, time + 0.002, said))
        joint = {"header": stamp(time), "name": list(JOINTS), "position": list(ANGLES[k]), "effort": [0.1, 0.2]}
        messages.append(("/joint_states", "sensor_msgs/msg/JointState", "", time + 0.001, joint))
    log_mcap(folder / "log.mcap", messages)
    found, titles, notes = imported(folder, "log.mcap")
    as_logged(found)
    assert titles[3:] == ["hip command [deg]", "knee command [deg]"]
    assert any(note.startswith("joint states of /leg/controller_state") for note in notes)


def test_commands_on_a_topic_of_their_own(folder: Path) -> None:
    """They have another clock, no stamps and no names: the delay of logging is taken from the states."""
    messages: list[Any] = []
    for k, time in enumerate(TIME):
        said = {"header": stamp(time), "name": list(JOINTS), "position": list(ANGLES[k])}
        messages.append(("/joint_states", "sensor_msgs/msg/JointState", "", time + 0.004, said))
    for k, time in enumerate(TIME - 0.003):  # what was commanded 3 ms before each state
        command = {"data": [float(COMMANDS[k, 1]), float(COMMANDS[k, 0])]}
        messages.append(("/forward/commands", "std_msgs/msg/Float64MultiArray", "", time + 0.004, command))
    log_mcap(folder / "log.mcap", messages)
    more = "commands: {topic: /forward/commands, joints: [knee_joint, hip_joint]}\n"
    found, _, notes = imported(folder, "log.mcap", more=more)
    assert any("at the time of logging less 4 ms" in note for note in notes)
    assert len(found.time) == 119  # each state and each command is a row; the first command is held at the first state
    assert found.signals is not None
    at_states = in_sense(found)[np.isfinite(found.angles[:, 0])]
    np.testing.assert_allclose(at_states, COMMANDS, atol=1e-6)  # each held since 3 ms before its state
    with pytest.raises(UserError, match="have 2 numbers and no names"):
        imported_only(folder, "commands: /forward/commands\n")
    with pytest.raises(UserError, match=r"commands: \{topic: /forward/commands, joints: \[hip_joint, knee_joint\]\}"):
        imported_only(folder, "")
    with pytest.raises(UserError, match=r'no commands on "/forward/command"; did you mean /forward/commands'):
        imported_only(folder, "commands: /forward/command\n")


def imported_only(folder: Path, more: str) -> None:
    from synth.files.import_project import read_import_project
    from synth.motion.importers.import_result import read_files

    read_files(read_import_project(project(folder, "log.mcap", more=more)))


def test_joint_states_as_commands_and_unreadable_topics(folder: Path) -> None:
    messages: list[Any] = []
    for k, time in enumerate(TIME):
        for topic, values in (("/joint_states", ANGLES), ("/joint_commands", COMMANDS)):
            said = {"header": stamp(time), "name": list(JOINTS), "position": list(values[k])}
            messages.append((topic, "sensor_msgs/msg/JointState", "", time, said))
    log_mcap(folder / "log.mcap", messages)
    found, _, notes = imported(folder, "log.mcap")
    as_logged(found)
    assert "commands of /joint_commands" in notes
    path = {"joint_names": list(JOINTS), "points": []}
    only = [m for m in messages if m[0] == "/joint_states"]
    log_mcap(folder / "log.mcap", [*only, ("/path", "trajectory_msgs/msg/JointTrajectory", "", 100.0, path)])
    with pytest.raises(UserError, match="/path has whole trajectories, between whose points the controller interpol"):
        imported_only(folder, "")


def test_currents_of_a_dynamic_joint_state(folder: Path) -> None:
    (folder / "robot.leg.yaml").write_text(LEG.format(drive="{kind: torque, motor: {torque_constant: 0.1 N*m/A}}"))
    messages: list[Any] = []
    for k, time in enumerate(TIME):
        each = [{"interface_names": ["position", "current"], "values": [float(a), 2.0]} for a in ANGLES[k]]
        said = {"header": stamp(time), "joint_names": list(JOINTS), "interface_values": each}
        messages.append(("/dynamic_joint_states", "control_msgs/msg/DynamicJointState", DYNAMIC_STATE, time, said))
    log_mcap(folder / "log.mcap", messages)
    found, titles, _ = imported(folder, "log.mcap")
    assert titles[3:] == ["hip current [A]", "knee current [A]"]
    assert found.torques is not None
    np.testing.assert_allclose(found.torques, 0.2)


def test_a_bag_of_ros_2_with_commands(folder: Path) -> None:
    typesys = pytest.importorskip("rosbags.typesys")
    from rosbags.rosbag2 import StoragePlugin, Writer

    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    kinds = {"/joint_states": "sensor_msgs/msg/JointState", "/cmd": "std_msgs/msg/Float64MultiArray"}
    with Writer(folder / "bag", version=9, storage_plugin=StoragePlugin.SQLITE3) as bag:
        topics = {topic: bag.add_connection(topic, kind, typestore=store) for topic, kind in kinds.items()}
        for k, time in enumerate(TIME):
            said = {"header": stamp(time), "name": list(JOINTS), "position": list(ANGLES[k])}
            for topic, content in (("/joint_states", said), ("/cmd", {"data": list(COMMANDS[k])})):
                data = store.serialize_cdr(_message(store, kinds[topic], content), kinds[topic])
                bag.write(topics[topic], round(time * 1e9), data)
    more = "commands: {topic: /cmd, joints: [hip_joint, knee_joint]}\n"
    as_logged(imported(folder, "bag/bag.db3", more=more)[0])


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("knee_joint}", "knee_joint, command: x}", r'knee command: there is no column "x"; the file has'),
        (
            "knee_joint}",
            "knee_joint, current: hip_joint}",
            r"\(one that takes command\) takes no current",
        ),
        ("knee_joint}", "knee_joint, command: {column: x, unit: V}}", r"joints.knee.command.unit: "),
        ("kind: import", "kind: import\nrelease: free", "the leg is driven: no part of its motion is free"),
        ("kind: import", "kind: import\ncommands: /x", "does not apply to a file of format csv"),
    ],
)
def test_mistakes(folder: Path, old: str, new: str, words: str) -> None:
    from synth.files.import_project import read_import_project
    from synth.motion.importers.import_result import read_files

    header = "time [s],hip_joint [rad],knee_joint [rad],hip_joint command [rad]"
    log_csv(folder, header, ANGLES, COMMANDS[:, :1])
    path = project(folder, "log.csv")
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(UserError, match=words):
        read_files(read_import_project(path))


def test_a_command_that_is_missing_names_the_key(folder: Path) -> None:
    log_csv(folder, "time [s],hip_joint [rad],knee_joint [rad]", ANGLES)
    path = project(folder, "log.csv")
    from synth.files.import_project import read_import_project
    from synth.motion.importers.import_result import read_files

    with pytest.raises(UserError, match="there is no command of hip, which its drive needs") as caught:
        read_files(read_import_project(path))
    assert len(caught.value.problems) == 2
