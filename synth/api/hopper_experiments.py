"""The hopper's experiments on recorded data: motor constants, joint damping, and models against measured jumps."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from synth.arrays import Array
from synth.files import hopper_recordings as files
from synth.hopper import write_identified as write
from synth.hopper.identify_damping import identify_damping
from synth.hopper.identify_motor import identify_motor
from synth.hopper.measured_row import measured_row
from synth.hopper.motors import motor_of
from synth.hopper.seen_jumps import seen_jumps
from synth.hopper.steady_motor import steady_motor
from synth.hopper.validate_jumps import validate
from synth.parts.catalogs import Catalogue


@dataclass(frozen=True, eq=False)
class HopperExperiment:
    """The result of one experiment.

    ``content`` : its JSON; ``first_jump`` : columns of the first jump on a force plate by every model,
    None if none was measured. ``motor_row`` : header -> cell of a measured motor's catalogue row, None if none is
    asked.
    """

    kind: str
    content: Mapping[str, Any]
    first_jump: Mapping[str, Array] | None = None
    motor_row: Mapping[str, list[str | float]] | None = None

    @property
    def file_name(self) -> str:
        """The name of the JSON file."""
        return f"{self.kind.removeprefix('hopper-')}.json"

    def lines(self) -> list[str]:
        """The result as text."""
        return write.lines(dict(self.content))


def hopper_experiment(path: str | Path) -> HopperExperiment:
    """Read and identify one file of kind hopper-motor, hopper-pull-ups or hopper-jumps.

    Raises
    ------
    UserError
        With every mistake of the file, or if the recordings do not determine the parameters.
    """
    kind, given = files.kind_of(path), read_experiment(path)
    if isinstance(given, files.MotorRuns):
        return _motor(given)
    if isinstance(given, files.PullUps):
        content = write.head(kind, given.name, given.inputs) | write.damping_json(identify_damping(given))
        return HopperExperiment(kind, content)
    return _jumps(given)


def read_experiment(path: str | Path) -> files.MotorRuns | files.PullUps | files.PlateJumps:
    """Read one file of these kinds with its recordings, and check all of it; nothing is identified.

    Raises
    ------
    UserError : with every mistake of the file, or a motor that no catalogue has or that lacks figures.
    """
    kind = files.kind_of(path)
    if kind == "hopper-motor":
        runs = files.read_motor_runs(path)
        if runs.motor is not None:
            Catalogue.load().find_motor(runs.motor)
        return runs
    if kind == "hopper-pull-ups":
        return files.read_pull_ups(path)
    jumps = files.read_plate_jumps(path)
    motor_of(Catalogue.load(jumps.design.catalogs).find_motor(jumps.motor), jumps.design.motor_options)
    return jumps


def _motor(runs: files.MotorRuns) -> HopperExperiment:
    """Motor constants from run-ups, and from stall and free-speed tests; a catalogue row of them, if it is named."""
    content = write.head("hopper-motor", runs.name, runs.inputs)
    found = identify_motor(runs.runs, runs.ratio) if runs.runs else None
    steady = steady_motor(runs.stall, runs.free, runs.ratio, with_runs=bool(runs.runs)) if _has_tests(runs) else None
    if found is not None:
        content |= write.motor_json(found)
    if steady is not None:
        content |= write.steady_json(steady)
    if runs.motor is None:
        return HopperExperiment("hopper-motor", content)
    row = measured_row(Catalogue.load().find_motor(runs.motor), runs.ratio, found, steady)
    content["design"] = row.lines
    return HopperExperiment("hopper-motor", content, motor_row=row.columns)


def _has_tests(runs: files.MotorRuns) -> bool:
    return bool(runs.stall or runs.free)


def _jumps(jumps: files.PlateJumps) -> HopperExperiment:
    """Each model against jumps on a force plate, by video and by jump meter."""
    catalogue = Catalogue.load(jumps.design.catalogs)
    found = write.head("hopper-jumps", jumps.name, jumps.inputs)
    curves = None
    if jumps.jumps:
        result = validate(jumps, catalogue)
        curves = result.curves
        found |= write.validation_json(result)
    if jumps.videos or jumps.meters:
        found["seen"] = seen_jumps(jumps, catalogue).as_json()
    return HopperExperiment("hopper-jumps", found, curves)
