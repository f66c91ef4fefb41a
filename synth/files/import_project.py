"""The project file of ``synth import``: foreign files, and which of their columns or points are the leg's joints."""

from __future__ import annotations

import os
from collections.abc import Mapping as Dictionary
from dataclasses import dataclass
from math import radians
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from synth.errors import Problem, UserError
from synth.files.column_units import column_factor
from synth.files.import_mapping import DRIVEN, CommandTopic, InputColumn, JointColumn, Mapping
from synth.files.leg_file import PartResolver
from synth.files.named_files import InputFile, ProjectReader
from synth.files.paths import matching
from synth.files.turns import TURN
from synth.files.validate import Quantity, Title
from synth.swing.leg_model import Leg

Window = tuple[float, float]
ALONG = 0.7  # cosine, 45 deg: a link's direction is across its axis, and stated by eye
TURNS = radians(720.0)  # rad, two turns either way: a larger angle is a mistake of units
Formats = Literal[
    "auto", "anipose", "c3d", "csv", "csv-points", "deeplabcut", "deeplabcut-h5", "json", "matlab", "mcap", "motive",
    "nwb-pose", "opensim", "qualisys", "rosbag", "sleap", "sleap-analysis", "sleap-csv", "trc", "vicon",
]  # fmt: skip
Cuts = Literal["cut", "free", "keep"]
Text = Annotated[str, Field(min_length=1, max_length=200)]


@dataclass(frozen=True)
class _ImportFile:
    kind: str
    leg: Annotated[str, Field(examples=["rat.leg.yaml"])]
    files: Annotated[list[Any], Field(min_length=1, examples=["[videos/*.csv]"])]
    exclude: Annotated[list[Text] | None, Field(examples=["[videos/b.csv]"])] = None
    format: Formats = "auto"
    time: Any = None
    frame_rate: Annotated[float, Quantity("Hz", above=0)] | None = None
    joints: Annotated[dict[str, Any] | None, Field(examples=["{hip: {column: hip_flexion_r, unit: deg}}"])] = None
    points: Annotated[list[Text] | None, Field(examples=["[hip, knee, ankle, toe]"])] = None
    individual: str | None = None
    likelihood: Annotated[float, Quantity("1", least=0, most=1)] | None = None
    plane: Annotated[list[str] | None, Field(min_length=2, max_length=2, examples=["[x, z]"])] = None
    mirror: bool = False
    roll: Annotated[float, Quantity("rad", least=-TURNS, most=TURNS)] = 0.0
    release: Cuts = "cut"
    name: Title | None = None
    topic: Text | None = None
    commands: Annotated[Any, Field(examples=["/leg_controller/commands"])] = None
    supply: Annotated[Any, Field(examples=["{column: input_volts, unit: V}"])] = None


@dataclass(frozen=True)
class _Commands:
    topic: Annotated[Text, Field(examples=["/leg_controller/commands"])]
    joints: Annotated[list[Text] | None, Field(examples=["[hip, knee]"])] = None


@dataclass(frozen=True)
class _InputColumn:
    column: Annotated[Text, Field(examples=["supply_volts"])]
    unit: Text | None = None


@dataclass(frozen=True)
class _CommandColumn:
    column: Annotated[Text, Field(examples=["goal_position"])]
    unit: Text | None = None
    counts: Annotated[int, Field(ge=2)] | None = None
    gear_ratio: Annotated[float, Quantity("1", above=0)] | None = None


@dataclass(frozen=True)
class _Clock:
    column: Annotated[Text, Field(examples=["t"])]
    unit: Annotated[Text | None, Field(examples=["ms"])] = None


@dataclass(frozen=True)
class _Column:
    column: Annotated[Text | None, Field(examples=["hip_flexion_r"])] = None
    unit: Text | None = None
    counts: Annotated[int, Field(ge=2)] | None = None
    gear_ratio: Annotated[float, Quantity("1", above=0)] = 1.0
    zero: Annotated[float, Quantity("rad", least=-TURNS, most=TURNS)] | None = None
    zero_count: float | None = None
    sign: Literal[1, -1] | None = None
    segment: bool = False
    quaternion: Annotated[list[Text] | None, Field(min_length=4, max_length=4, examples=["[q0, q1, q2, q3]"])] = None
    axis: Annotated[list[float] | None, Field(min_length=3, max_length=3, examples=["[0, 0, 1]"])] = None
    down: Annotated[list[float] | None, Field(min_length=3, max_length=3, examples=["[1, 0, 0]"])] = None
    command: Annotated[Any, Field(examples=["goal_position"])] = None
    voltage: Annotated[Any, Field(examples=["{column: motor_volts, unit: V}"])] = None
    current: Annotated[Any, Field(examples=["{column: motor_current, unit: mA}"])] = None
    torque: Annotated[Any, Field(examples=["{column: effort, unit: N*m}"])] = None
    enabled: Annotated[Any, Field(examples=["torque_enable"])] = None


@dataclass(frozen=True)
class _FileEntry:
    file: Annotated[Text, Field(examples=["videos/*.csv"])]
    window: (
        Annotated[list[Annotated[float, Quantity("s")]], Field(min_length=2, max_length=2, examples=["[2.7 s, 3.4 s]"])]
        | None
    ) = None


@dataclass(frozen=True)
class ForeignFile:
    """A file to import: ``name`` relative to the project, and the manually chosen window, s."""

    path: Path
    name: str
    window: Window | None = None


@dataclass(frozen=True, eq=False)
class ImportProject:
    """The input of ``synth import``."""

    name: str
    leg: Leg
    files: tuple[ForeignFile, ...]
    format: Formats
    mapping: Mapping
    release: Cuts
    inputs: tuple[InputFile, ...] = ()


def read_import_project(path: str | Path, *, resolve_part: PartResolver | None = None) -> ImportProject:
    """Read a project of kind ``import`` with its leg; the foreign files are found, not read.

    Raises
    ------
    UserError
        With every mistake of the project and the leg.
    """
    reader = ProjectReader.open(path, "import", resolve_part)
    written = reader.written
    file = reader.entry(_ImportFile, (), written)
    leg = reader.leg(written["leg"], ("leg",)) if isinstance(written.get("leg"), str) else None
    clock = None
    if written.get("time") is not None:
        clock = reader.entry(_Clock, ("time",), written["time"])
        if clock is not None:
            _check_unit(reader, clock.unit, "s", ("time",))
    columns = _columns(reader, written.get("joints"))
    if leg is not None:
        reader.known_joints(columns, leg, ("joints",))
    supply = _input(reader, ("supply",), written.get("supply"), "V")
    commands = _command_topics(reader, written.get("commands"))
    files = _without(reader, _files(reader, written.get("files")), file.exclude if file is not None else None)
    if clock is not None and written.get("frame_rate") is not None:
        reader.refuse('"time" and "frame_rate" are both given; keep one', ("frame_rate",))
    reader.finish()
    assert file is not None
    assert leg is not None
    mapping = Mapping(
        clock.column if clock else None,
        clock.unit if clock else None,
        file.frame_rate,
        columns,
        tuple(file.points or ()),
        file.individual,
        file.likelihood,
        (file.plane[0], file.plane[1]) if file.plane else None,
        file.mirror,
        file.roll,
        file.topic,
        supply,
        commands,
    )
    name = file.name or leg.name
    return ImportProject(name, leg, files, file.format, mapping, file.release, tuple(reader.inputs))


def _columns(reader: ProjectReader, written: object) -> dict[str, JointColumn]:
    """One column per joint, or only its name if the file states the unit and uses the leg file's convention."""
    found: dict[str, JointColumn] = {}
    for name, value in written.items() if isinstance(written, dict) else ():
        key = ("joints", str(name))
        column = reader.entry(_Column, key, {"column": value} if isinstance(value, str) else value)
        if column is not None:
            found[str(name)] = _joint_column(reader, column, key)
    return found


def _joint_column(reader: ProjectReader, column: _Column, key: tuple[str, ...]) -> JointColumn:
    _check_unit(reader, column.unit, "rad", key, column.counts)
    if column.quaternion is None and column.column is None:
        text = 'needs "column", the name of its column, or of an inertial sensor "quaternion", "axis" and "down"'
        reader.refuse(text, key)
    given = {word: _input(reader, (*key, word), getattr(column, word), unit) for word, unit in DRIVEN.items()}
    inputs = {word: each for word, each in given.items() if each is not None}
    if column.quaternion is not None:
        return _of_quaternion(reader, column, key, inputs)
    for word in ("axis", "down"):
        if getattr(column, word) is not None:
            reader.refuse("is of a sensor's quaternion: quaternion: [q0, q1, q2, q3]; leave it out", (*key, word))
    if column.segment and column.zero is None and column.zero_count is None:
        text = "a segment's angle needs its zero, the file's reading when this link hangs straight down: zero: 0 deg"
        reader.refuse(text, (*key, "segment"))
    zero = _zero(reader, column, key)
    return JointColumn(
        column.column or "", column.unit, zero, column.sign, inputs, column.counts, column.gear_ratio, column.segment
    )


def _of_quaternion(
    reader: ProjectReader, column: _Column, key: tuple[str, ...], inputs: dict[str, InputColumn]
) -> JointColumn:
    """A segment's angle out of its sensor's quaternion; its unit is known, and 0 is straight down."""
    for word in ("column", "unit", "counts", "zero_count"):
        if getattr(column, word) is not None:
            reader.refuse('does not apply beside "quaternion"; leave it out', (*key, word))
    if column.gear_ratio != 1.0:
        reader.refuse(
            'does not apply beside "quaternion": the sensor is on the link; leave it out', (*key, "gear_ratio")
        )
    axis, down = (None if each is None else np.array(each) for each in (column.axis, column.down))
    for word, each in (("axis", axis), ("down", down)):
        if each is not None and not (np.isfinite(each).all() and each.any()):
            reader.refuse("is no direction; write three numbers, such as [0, 0, 1]", (*key, word))
            return JointColumn("")
    if down is None:
        text = "needs the direction of this link from its joint outward, in the sensor's own axes: down: [1, 0, 0]"
        reader.refuse(text, key)
    elif axis is not None and abs(axis @ down) > ALONG * np.linalg.norm(axis) * np.linalg.norm(down):
        reader.refuse("is along the axis; a link points across the axis that it turns about", (*key, "down"))
    names = tuple(column.quaternion or ())
    return JointColumn(
        f"quaternion {', '.join(names)}",
        None,
        0.0 if column.zero is None else column.zero,
        column.sign,
        inputs,
        segment=True,
        quaternion=names,
        axis=None if axis is None else tuple(float(each) for each in axis),
        down=() if down is None else tuple(float(each) for each in down),
    )


def _zero(reader: ProjectReader, column: _Column, key: tuple[str, ...]) -> float | None:
    """The angle at which the link points along its parent, rad, from the angle or the count that the project states."""
    if column.zero_count is None:
        return column.zero
    if column.counts is None:
        reader.refuse("is a count of an encoder; beside it write its counts a turn: counts: 4096", (*key, "zero_count"))
        return None
    if column.zero is not None:
        reader.refuse('"zero" and "zero_count" are both given; keep one', (*key, "zero_count"))
    return column.zero_count * TURN / (column.counts * column.gear_ratio)


def _input(reader: ProjectReader, key: tuple[str, ...], written: object, canonical: str) -> InputColumn | None:
    """The column of an input: its name, or a mapping with its unit."""
    if written is None:
        return None
    value = {"column": written} if isinstance(written, str) else written
    schema: type[_InputColumn | _CommandColumn] = _CommandColumn if canonical == "rad" else _InputColumn
    column = reader.entry(schema, key, value)
    if column is None:
        return None
    if isinstance(column, _InputColumn):
        _check_unit(reader, column.unit, canonical, key)
        return InputColumn(column.column, column.unit)
    _check_unit(reader, column.unit, canonical, key, column.counts)
    return InputColumn(column.column, column.unit, column.counts, column.gear_ratio)


def _command_topics(reader: ProjectReader, written: object) -> tuple[CommandTopic, ...]:
    """One topic or several, each its name or a mapping."""
    found = []
    several = isinstance(written, list)
    for index, raw in enumerate(written if isinstance(written, list) else [] if written is None else [written]):
        key: tuple[str | int, ...] = ("commands", index) if several else ("commands",)
        each = reader.entry(_Commands, key, {"topic": raw} if isinstance(raw, str) else raw)
        if each is not None:
            found.append(CommandTopic(each.topic, tuple(each.joints or ())))
    return tuple(found)


def _check_unit(
    reader: ProjectReader, unit: str | None, canonical: str, key: tuple[str, ...], counts: int | None = None
) -> None:
    """Refuse a unit that is none of what the column at ``key`` holds, and one beside ``counts``."""
    if unit is None:
        return
    if counts is not None:
        reader.refuse(f'"unit" and "counts" are both given; keep counts: {counts} if these are raw counts',
                      (*key, "unit"))  # fmt: skip
        return
    try:
        column_factor(unit, canonical)
    except UserError as error:
        reader.refuse(error.problems[0].text, (*key, "unit"))


def bag_file(folder: Path, name: str) -> str:
    """The recording of a ROS 2 bag that is named by its folder; any other name as it is.

    Raises
    ------
    UserError : a bag without a recording, or with several MCAP files (several ``.db3`` are read as one).
    """
    bag = folder / name
    try:
        if not (bag / "metadata.yaml").is_file():
            return name
    except (OSError, ValueError):  # no name of a folder
        return name
    found = sorted(each.name for each in bag.iterdir() if each.suffix in (".db3", ".mcap"))
    if not found:
        raise UserError(Problem("is a bag without a .db3 or .mcap; one ending in .zstd is to be unpacked first", name))
    if len(found) > 1 and found[0].endswith(".mcap"):
        raise UserError(Problem(f"is a bag of several files; name each: {', '.join(found)}", name))
    return f"{name}/{found[0]}"


def _files(reader: ProjectReader, written: object) -> tuple[ForeignFile, ...]:
    """The files that the entries stand for, each once."""
    found: dict[Path, ForeignFile] = {}
    for index, raw in enumerate(written) if isinstance(written, list) else ():
        key = ("files", index)
        value = {"file": raw} if isinstance(raw, str) else raw
        if not isinstance(value, Dictionary):
            reader.refuse(f"{raw!r} is no file; write a file, a glob or {{file: ..., window: [2.7 s, 3.4 s]}}", key)
            continue
        entry = reader.entry(_FileEntry, key, dict(value))
        if entry is None:
            continue
        window = (entry.window[0], entry.window[1]) if entry.window else None
        if window is not None and not window[0] < window[1]:
            reader.refuse("the window must go from the earlier time to the later: [2.7 s, 3.4 s]", (*key, "window"))
        try:
            paths = matching(reader.folder, bag_file(reader.folder, entry.file))
        except UserError as error:
            for problem in error.problems:
                reader.refuse(problem.text, key)
            continue
        for path in paths:
            name = path.relative_to(reader.folder).as_posix()
            if Path(os.path.realpath(path)) in found:
                reader.refuse(f'"{name}" is listed twice; name it once', key)
                continue
            found[Path(os.path.realpath(path))] = ForeignFile(path, name, window)
    return tuple(found.values())


def _without(
    reader: ProjectReader, files: tuple[ForeignFile, ...], excluded: list[str] | None
) -> tuple[ForeignFile, ...]:
    """The files but those that ``excluded`` names; each of its names or globs must leave out one."""
    left = {Path(os.path.realpath(file.path)): file for file in files}
    for index, name in enumerate(excluded or ()):
        try:
            out = {Path(os.path.realpath(path)) for path in matching(reader.folder, name)}
        except UserError as error:
            for problem in error.problems:
                reader.refuse(problem.text, ("exclude", index))
            continue
        if files and not any(Path(os.path.realpath(file.path)) in out for file in files):
            reader.refuse(f'"{name}" is not among "files"; leave it out here', ("exclude", index))
        left = {path: file for path, file in left.items() if path not in out}
    if files and not left:
        reader.refuse("leaves out all files", ("exclude",))
    return tuple(left.values())
