"""The project file of ``synth gap`` for a jumping leg: ``leg:`` names a ``kind: hopper-design``.

A recording with a column ``hip torque`` is an inverted pull-up, any other a jump.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import radians
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field

from synth.arrays import Array
from synth.files.csv_table import read_table
from synth.files.hopper_project import HopperProject, design_named
from synth.files.hopper_recordings import HopperRecording, read_recording
from synth.files.named_files import InputFile, ProjectReader
from synth.files.paths import matching
from synth.files.recordings_together import clocks_together, with_equal_channels
from synth.files.schema import Because, Default
from synth.files.validate import BARE_DEVIATION, FileModel, Quantity, Title, check_part, gathering

PULL_UP = "hip torque"  # the column that marks a recording as a pull-up
JUMP_COLUMNS = {"time": "s", "upper link": "rad"}
PULL_UP_COLUMNS = {**JUMP_COLUMNS, PULL_UP: "N*m"}
OPTIONAL = {"ground force": "N", "current": "A", "supply": "V", "pitch": "rad", "foot slide": "m"}
MOST = 0.5  # a quantity with a larger deviation is unknown, and nothing can be inferred from it

Length = Annotated[float, Quantity("m", above=0, most=10)]
Share = Annotated[float, Quantity("1", least=0, most=MOST, bare=BARE_DEVIATION)]
_RUN_UPS = "usual after the motor's run-ups (synth hopper, kind hopper-motor)"
_BUILT = "usual for a leg that was measured after it was built"


@dataclass(frozen=True)
class JumpTolerance:
    """Uncertainty of the design due to manufacturing and measurement: standard deviations, as shares of the value.

    The motor's values (``motor`` its torque constant) apply to each motor separately. Zero: known exactly, so that any
    deviation counts as an effect.
    """

    length: Annotated[Share, Because(_BUILT)] = 0.005
    mass: Annotated[Share, Because(_BUILT)] = 0.01
    spring: Annotated[Share, Because("remaining uncertainty of a measured flexure rate")] = 0.05
    damper: Annotated[Share, Because("remaining after pull-ups (synth hopper, kind hopper-pull-ups)")] = 0.15
    motor: Annotated[Share, Because(_RUN_UPS)] = 0.02
    resistance: Annotated[Share, Because(_RUN_UPS)] = 0.02
    inductance: Annotated[Share, Because(_RUN_UPS)] = 0.2
    friction: Annotated[Share, Because(_RUN_UPS)] = 0.15
    rotor_inertia: Annotated[Share, Because(_RUN_UPS)] = 0.05
    efficiency: Annotated[Share, Because("of the gear; accuracy of the maker's line"), Field(examples=["5 %"])] = 0.03
    supply: Annotated[Share, Because("a voltmeter's")] = 0.005
    ground: Annotated[Share, Because("the contact's stiffness is an assumption")] = 0.3
    bumper: Annotated[Share, Because("the stop's stiffness is an assumption")] = 0.3
    force: Annotated[Share, Because("a force plate's scale")] = 0.01
    angle: Annotated[
        float, Quantity("rad", least=0, most=radians(30)), Because("the encoder's zero")
    ] = radians(0.3)  # fmt: skip
    stop: Annotated[
        float, Quantity("rad", least=0, most=radians(30)), Because("where the leg's stop is")
    ] = radians(1.0)  # fmt: skip
    crouch: Annotated[
        float, Quantity("rad", least=0, most=radians(30)), Because("each jump's start about the design's crouch")
    ] = radians(3.0)  # fmt: skip
    start: Annotated[
        float, Quantity("s", least=0, most=0.1), Because("switch-on time of the motors after time 0")
    ] = 0.0005  # fmt: skip


@dataclass(frozen=True, eq=False)
class JumpTrial:
    """One recording of a jump or a pull-up: columns (n_time,) in SI, and its conditions.

    ``payload`` kg on the body; ``supply`` V or None for the motor's own; ``lean`` rad from upright at the start;
    ``begins`` as in ``HopperRecording``.
    """

    name: str
    columns: Mapping[str, Array]
    kind: Literal["jump", "pull-up"]
    motor: str
    length: float
    payload: float = 0.0
    supply: float | None = None
    lean: float = 0.0
    held_out: bool = False
    sha256: str = ""
    begins: float = 0.0


class _JumpEntry(FileModel):
    """One item under ``trials:``; ``file`` may be a glob."""

    file: Annotated[str, Field(min_length=1, examples=["jumps/*.csv"])]
    motor: str | None = None
    length: Length | None = None
    payload: Annotated[float, Quantity("kg", least=0, most=100)] = 0.0
    supply: Annotated[float | None, Quantity("V", above=0, most=1000)] = None
    lean: Annotated[float, Quantity("rad", least=-radians(45), most=radians(45))] = 0.0
    held_out: bool = False


@dataclass(frozen=True)
class _HopperGapFile:
    kind: str
    leg: Annotated[str, Field(examples=["hopper.yaml"])]
    trials: Annotated[list[Any], Field(min_length=1, examples=["[jumps/*.csv]"])]
    motor: str | None = None
    length: Length | None = None
    tolerance: Any = None
    name: Title | None = None
    seed: Annotated[int, Field(ge=0, le=2**32 - 1)] = 0


@dataclass(frozen=True, eq=False)
class HopperGapProject:
    """The input of ``synth gap`` for a jumping leg: the ``design``, and ``trials`` of the built leg."""

    path: Path
    name: str
    design: HopperProject
    trials: tuple[JumpTrial, ...]
    tolerance: JumpTolerance
    seed: int
    defaults: tuple[Default, ...]
    inputs: tuple[InputFile, ...]


def read_hopper_gap_project(path: str | Path) -> HopperGapProject:
    """Read the project with its design and recordings.

    Raises
    ------
    UserError
        With every mistake of the project, the design and the recordings.
    """
    reader = ProjectReader.open(path, "gap")
    file, tolerance = reader.section(_HopperGapFile), reader.section(JumpTolerance, "tolerance")
    design = design_named(reader, "leg")
    if design is not None and design.model == "point_mass":
        reader.refuse("its model is point_mass, which does not predict a motion; choose another", ("leg",))
    trials = _trials(reader, file) if file is not None else ()
    if file is not None and trials and all(trial.held_out for trial in trials):
        reader.refuse("every trial is held out; at least one training trial is needed", ("trials",))
    reader.finish()
    assert file is not None
    assert tolerance is not None
    assert design is not None
    name = file.name or (design.name if reader.stem == "gap" else reader.stem)  # `gap` alone says nothing on a page
    return HopperGapProject(
        reader.document.path, name, design, trials, tolerance, file.seed,
        tuple(reader.defaults), tuple(reader.inputs),
    )  # fmt: skip


def _trials(reader: ProjectReader, file: _HopperGapFile) -> tuple[JumpTrial, ...]:
    found: list[JumpTrial] = []
    for index, raw in enumerate(file.trials):
        key = ("trials", index)
        value = {"file": raw} if isinstance(raw, str) else raw
        entry = check_part(_JumpEntry, reader.document, value, key, reader.problems)
        if entry is None:
            continue
        motor, length = entry.motor or file.motor, entry.length or file.length
        missing = [f'"{name}"' for name, given in (("motor", motor), ("length", length)) if given is None]
        if motor is None or length is None:
            reader.refuse(f"{' and '.join(missing)} missing: give it here, or once for all trials", key)
            continue
        with gathering(reader.problems, reader.document, key):
            for path in matching(reader.folder, entry.file):
                name = path.relative_to(reader.folder).as_posix()
                if any(trial.name == name for trial in found):
                    reader.refuse(f'"{name}" is listed twice; name it once', key)
                    continue
                found.append(_trial(reader, path, name, entry, motor, length))
    reader.problems += clocks_together(
        [one.name for one in found], *with_equal_channels([one.columns for one in found])
    )
    return tuple(found)


def _trial(reader: ProjectReader, path: Path, name: str, entry: _JumpEntry, motor: str, length: float) -> JumpTrial:
    recording = _recording(path, name)
    reader.note(path)
    sha256 = next(item.sha256 for item in reader.inputs if item.name == name)
    return JumpTrial(
        name, recording.columns, "pull-up" if PULL_UP in recording.columns else "jump", motor, length, entry.payload,
        entry.supply, entry.lean, entry.held_out, sha256, recording.begins,
    )  # fmt: skip


def _recording(path: Path, name: str) -> HopperRecording:
    titles = {column.name for column in read_table(path, name).columns}
    if PULL_UP in titles:
        return read_recording(path, name, PULL_UP_COLUMNS)
    return read_recording(path, name, JUMP_COLUMNS, OPTIONAL)
