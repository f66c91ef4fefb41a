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
    kind = files.kind_of(path)
    if kind == "hopper-motor":
        return HopperExperiment(kind, _motor(path))
    if kind == "hopper-pull-ups":
        pulls = files.read_pull_ups(path)
        content = write.head(kind, pulls.name, pulls.inputs) | write.damping_json(identify_damping(pulls))
        return HopperExperiment(kind, content)
    return _jumps(path)


def _motor(path: str | Path) -> dict[str, Any]:
    """Motor constants from run-ups, and from stall and free-speed tests."""
    runs = files.read_motor_runs(path)
    found = write.head("hopper-motor", runs.name, runs.inputs)
    if runs.runs:
        found |= write.motor_json(identify_motor(runs.runs, runs.ratio))
    if runs.stall or runs.free:
        steady = steady_motor(runs.stall, runs.free, runs.ratio, with_runs=bool(runs.runs))
        found |= write.steady_json(steady)
    return found


def _jumps(path: str | Path) -> HopperExperiment:
    """Each model against jumps on a force plate, by video and by jump meter."""
    jumps = files.read_plate_jumps(path)
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
