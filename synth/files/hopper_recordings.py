"""Projects and recordings of the jumping leg's experiments: run-ups of a motor, inverted pull-ups, jumps on a plate."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.csv_table import CsvTable, read_table
from synth.files.hopper_project import HopperProject, design_named, refuse_links_that_do_not_meet
from synth.files.named_files import InputFile, ProjectReader
from synth.files.paths import inside, matching
from synth.files.recordings_together import clock_problem, clocks_together, with_equal_channels
from synth.files.schema import Because
from synth.files.validate import Quantity, Title, gathering
from synth.files.yaml_lines import load
from synth.units import factor

KINDS = ("hopper-motor", "hopper-pull-ups", "hopper-jumps")
LEAST_SAMPLES = 20  # of a run-up or pull-up
Length = Annotated[float, Quantity("m", above=0, most=10)]
Files = Annotated[list[str], Field(min_length=1, examples=["[runs/*.csv]"])]


@dataclass(frozen=True, eq=False)
class HopperRecording:
    """One recording's columns (n_time,) in SI by name; ``length`` of the upper links where it was given, m.

    ``begins`` : s, the file's own time at time 0; not 0 only for a large clock (``log_clock``).
    """

    name: str
    columns: Mapping[str, Array]
    length: float | None = None
    begins: float = 0.0

    def __getitem__(self, column: str) -> Array:
        return self.columns[column]


@dataclass(frozen=True, eq=False)
class MotorRuns:
    """Experiment B: run-ups of one gear motor, and steady points with its shaft held (``stall``) and ``free``.

    ``motor`` : its part in the catalogue, if it is written.
    """

    name: str
    ratio: float
    runs: tuple[HopperRecording, ...]
    inputs: tuple[InputFile, ...]
    stall: tuple[HopperRecording, ...] = ()
    free: tuple[HopperRecording, ...] = ()
    motor: str | None = None


@dataclass(frozen=True, eq=False)
class PullUps:
    """Experiment C: inverted pull-ups of legs of several lengths."""

    name: str
    design: HopperProject
    body_mass: float
    method: Literal["least_squares", "genetic"]
    seed: int
    trials: tuple[HopperRecording, ...]
    inputs: tuple[InputFile, ...]


@dataclass(frozen=True, eq=False)
class PlateJumps:
    """Experiment A: jumps of one built leg, on a plate, by a video of a point (hips or foot), or by a current meter."""

    name: str
    design: HopperProject
    motor: str
    length: float
    jumps: tuple[HopperRecording, ...]
    inputs: tuple[InputFile, ...]
    videos: tuple[tuple[str, HopperRecording], ...] = ()
    meters: tuple[HopperRecording, ...] = ()


@dataclass(frozen=True)
class _MotorFile:
    kind: str
    gear_ratio: Annotated[float, Quantity("1", above=0, most=1e5)]
    runs: Files | None = None
    stall: Files | None = None
    free_speed: Files | None = None
    motor: str | None = None
    name: Title | None = None


@dataclass(frozen=True)
class _PullUpFile:
    kind: str
    design: str
    body_mass: Annotated[float, Quantity("kg", above=0, most=100)]
    trials: Annotated[list[Any], Field(min_length=1, examples=["[{file: a.csv, length: 120 mm}]"])]
    method: Annotated[Literal["least_squares", "genetic"], Because("exact, in milliseconds")] = "least_squares"
    seed: Annotated[int, Field(ge=0, le=2**32 - 1)] = 0
    name: Title | None = None


@dataclass(frozen=True)
class _Trial:
    file: str
    length: Length


@dataclass(frozen=True)
class _JumpFile:
    kind: str
    design: str
    motor: str
    length: Length
    jumps: Files | None = None
    heights: Annotated[list[Any] | None, Field(min_length=1, examples=["[{file: video.csv, point: foot}]"])] = None
    currents: Files | None = None
    name: Title | None = None


@dataclass(frozen=True)
class _Video:
    file: str
    point: Literal["hips", "foot"]


def kind_of(path: str | Path) -> str:
    """The kind stated by a project file, or an empty text."""
    return str(load(path).value.get("kind", ""))


def read_motor_runs(path: str | Path) -> MotorRuns:
    """Read ``kind: hopper-motor``; each run has ``time [s],voltage [V],current [A],speed [rad/s]`` of the output.

    A stall test has ``voltage [V],current [A],torque [N*m]``, a free-speed test ``voltage [V],current [A],speed
    [rpm]``, one line per steady point, also at the output.
    """
    reader = ProjectReader.open(path, "hopper-motor")
    file = reader.section(_MotorFile)
    wanted = {"time": "s", "voltage": "V", "current": "A", "speed": "rad/s"}
    runs = _recordings(reader, file.runs or [], "runs", wanted) if file is not None else []
    steady = {"voltage": "V", "current": "A"}
    stall = _points(reader, file.stall or [], "stall", {**steady, "torque": "N*m"}) if file is not None else []
    free = (
        _points(reader, file.free_speed or [], "free_speed", {**steady, "speed": "rad/s"}) if file is not None else []
    )
    if file is not None and file.runs is None and file.stall is None and file.free_speed is None:
        reader.refuse('needs "runs" (run-ups), "stall" and "free_speed" (steady points), or all of them', ())
    reader.finish()
    assert file is not None
    name = file.name or reader.stem
    return MotorRuns(name, file.gear_ratio, tuple(runs), tuple(reader.inputs), tuple(stall), tuple(free), file.motor)


def read_pull_ups(path: str | Path) -> PullUps:
    """Read ``kind: hopper-pull-ups``; each trial has ``time [s],upper link [deg],hip torque [N*m]``.

    The angle is an upper link's from the leg's straight line, outward positive, the torque one motor's on it, likewise.
    """
    reader = ProjectReader.open(path, "hopper-pull-ups")
    file = reader.section(_PullUpFile)
    design = design_named(reader, "design")
    wanted = {"time": "s", "upper link": "rad", "hip torque": "N*m"}
    trials: list[HopperRecording] = []
    for index, item in enumerate(file.trials if file is not None else ()):
        key = ("trials", index)
        trial = reader.entry(_Trial, key, item)
        if trial is None:
            continue
        with gathering(reader.problems, reader.document, key):
            found = inside(reader.folder, trial.file)
            recording = read_recording(found, trial.file, wanted)
            reader.note(found)
            refuse_links_that_do_not_meet(reader, design, trial.length, (*key, "length"))
            trials.append(replace(recording, length=trial.length))
    reader.problems += clocks_together(
        [one.name for one in trials], *with_equal_channels([one.columns for one in trials])
    )
    reader.finish()
    assert file is not None
    assert design is not None
    return PullUps(
        file.name or reader.stem, design, file.body_mass, file.method, file.seed, tuple(trials), tuple(reader.inputs)
    )


def read_plate_jumps(path: str | Path) -> PlateJumps:
    """Read ``kind: hopper-jumps``; each jump has ``time [s],ground force [N],upper link [deg]``.

    A video's CSV under ``heights`` has ``time [s],height [m]`` of its ``point``, upward; a meter's under ``currents``
    ``time [s],current [A]`` of both motors.
    """
    reader = ProjectReader.open(path, "hopper-jumps")
    file = reader.section(_JumpFile)
    design = design_named(reader, "design")
    wanted = {"time": "s", "ground force": "N", "upper link": "rad"}
    jumps = _recordings(reader, file.jumps or [], "jumps", wanted) if file is not None else []
    videos = _videos(reader, file.heights or []) if file is not None else []
    meter = {"time": "s", "current": "A"}
    meters = _recordings(reader, file.currents or [], "currents", meter) if file is not None else []
    if file is not None and file.jumps is None and file.heights is None and file.currents is None:
        text = (
            'needs "jumps" (force plate and encoder), "heights" (a video\'s CSV), "currents" (a meter\'s), or several'
        )
        reader.refuse(text, ())
    if file is not None:
        refuse_links_that_do_not_meet(reader, design, file.length, ("length",))
    reader.finish()
    assert file is not None
    assert design is not None
    name, inputs = file.name or reader.stem, tuple(reader.inputs)
    return PlateJumps(name, design, file.motor, file.length, tuple(jumps), inputs, tuple(videos), tuple(meters))


def _videos(reader: ProjectReader, items: list[Any]) -> list[tuple[str, HopperRecording]]:
    """The point that each video follows, and its height over time."""
    found: list[tuple[str, HopperRecording]] = []
    for index, item in enumerate(items):
        video = reader.entry(_Video, ("heights", index), item)
        if video is None:
            continue
        with gathering(reader.problems, reader.document, ("heights", index)):
            for path in matching(reader.folder, video.file):
                reader.note(path)
                name = path.relative_to(reader.folder).as_posix()
                found.append((video.point, read_recording(path, name, {"time": "s", "height": "m"})))
    return found


def _points(reader: ProjectReader, patterns: list[str], key: str, wanted: Mapping[str, str]) -> list[HopperRecording]:
    """Tables of steady points, one per line, without a clock."""
    found = []
    for index, pattern in enumerate(patterns):
        with gathering(reader.problems, reader.document, (key, index)):
            for path in matching(reader.folder, pattern):
                reader.note(path)
                found.append(read_points(path, path.relative_to(reader.folder).as_posix(), wanted))
    return found


def read_points(path: Path, name: str, wanted: Mapping[str, str]) -> HopperRecording:
    """Read a CSV of points with the wanted columns (name -> SI unit), no cell of them empty.

    Raises
    ------
    UserError : a column is missing or of another kind, or a cell is empty.
    """
    table = read_table(path, name)
    return HopperRecording(name, _columns(table, name, wanted))


def read_recording(
    path: Path, name: str, wanted: Mapping[str, str], optional: Mapping[str, str] | None = None
) -> HopperRecording:
    """Read a CSV with the required columns (name -> SI unit) and any optional ones.

    Raises
    ------
    UserError
        If a column is missing or of another kind, a cell is empty, time does not rise, or there are too few samples.
    """
    table = read_table(path, name)
    found = _columns(table, name, wanted, optional)
    clock = table.clock(next(column for column in table.columns if column.name == "time"))
    found["time"] = time = clock.time
    if len(time) < LEAST_SAMPLES:
        raise UserError(Problem(f"has {len(time)} samples; at least {LEAST_SAMPLES} are needed", name))
    if not np.all(np.diff(time) > 0.0):
        row = int(np.argmax(np.diff(time) <= 0.0)) + 1
        raise UserError(Problem("time does not rise", name, table.line(row), "time"))
    if (problem := clock_problem(time, name, next(c.title for c in table.columns if c.name == "time"))) is not None:
        raise UserError(problem)
    return HopperRecording(name, found, begins=clock.begins)


def _columns(
    table: CsvTable, name: str, wanted: Mapping[str, str], optional: Mapping[str, str] | None = None
) -> dict[str, Array]:
    """The wanted columns, and such optional ones as there are, in SI."""
    columns = {column.name: column for column in table.columns}
    missing = [f'"{title} [{unit}]"' for title, unit in wanted.items() if title not in columns]
    if missing:
        raise UserError(Problem(f"has no column {', '.join(missing)}", name, 1))
    found: dict[str, Array] = {}
    there = {title: unit for title, unit in (optional or {}).items() if title in columns}
    for title, unit in (dict(wanted) | there).items():
        index = list(columns).index(title)
        try:
            scale = factor(columns[title].unit, unit)
        except UserError as error:
            raise UserError(Problem(error.problems[0].text, name, 1, title)) from None
        found[title] = table.values[:, index] * scale
        _refuse_gaps(table, found[title], title, name)
    return found


def _refuse_gaps(table: CsvTable, values: Array, title: str, name: str) -> None:
    if np.isnan(values).any():
        row = int(np.argmax(np.isnan(values)))
        raise UserError(Problem("has an empty cell; these experiments need every sample", name, table.line(row), title))


def _recordings(
    reader: ProjectReader, patterns: list[str], key: str, wanted: Mapping[str, str]
) -> list[HopperRecording]:
    found: list[HopperRecording] = []
    for index, pattern in enumerate(patterns):
        with gathering(reader.problems, reader.document, (key, index)):
            for path in matching(reader.folder, pattern):
                reader.note(path)
                found.append(read_recording(path, path.relative_to(reader.folder).as_posix(), wanted))
    reader.problems += clocks_together(
        [one.name for one in found], *with_equal_channels([one.columns for one in found])
    )
    return found
