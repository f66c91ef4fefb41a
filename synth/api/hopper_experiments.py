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
from synth.hopper.motors import motor_of
from synth.hopper.seen_jumps import seen_jumps
from synth.hopper.steady_motor import steady_motor
from synth.hopper.validate_jumps import validate
from synth.parts.catalogs import Catalogue


@dataclass(frozen=True, eq=False)
class HopperExperiment:
    """The result of one experiment.

    ``content`` : its JSON; ``first_jump`` : columns of the first jump on a force plate by every model,
    None if none was measured.
    """

    kind: str
    content: Mapping[str, Any]
    first_jump: Mapping[str, Array] | None = None

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
        return HopperExperiment(kind, _motor(given))
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
        return files.read_motor_runs(path)
    if kind == "hopper-pull-ups":
        return files.read_pull_ups(path)
    jumps = files.read_plate_jumps(path)
    motor_of(Catalogue.load(jumps.design.catalogs).find_motor(jumps.motor), jumps.design.motor_options)
    return jumps


def _motor(runs: files.MotorRuns) -> dict[str, Any]:
    """Motor constants from run-ups, and from stall and free-speed tests."""
    found = write.head("hopper-motor", runs.name, runs.inputs)
    if runs.runs:
        found |= write.motor_json(identify_motor(runs.runs, runs.ratio))
    if runs.stall or runs.free:
        steady = steady_motor(runs.stall, runs.free, runs.ratio, with_runs=bool(runs.runs))
        found |= write.steady_json(steady)
    return found


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
