"""A planted case as a user's project: the same leg, tolerances and trials, with simulated readings."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from synth.arrays import Array
from synth.drives.servo import TorqueDrive
from synth.files.drive_columns import SUFFIXES, SUPPLY
from synth.files.leg_file import write_leg
from synth.files.output import write_text
from synth.planting.model import PlantedLeg
from synth.rehearsal.plants import Planted
from synth.rehearsal.users_rig import Rig
from synth.swing.leg_model import Leg
from synth.units import write

if TYPE_CHECKING:
    from synth.files.gap_project import GapProject

COPIED_KEYS = ("tolerance", "accuracy", "seed")  # of the user's project, as written


def write_case(project: GapProject, rig: Rig, planted: Planted, folder: Path) -> Path:
    """Write ``gap.yaml``, the leg and the recordings into the existing ``folder``; return the project's path."""
    import yaml

    from synth.files.yaml_lines import load

    (folder / "trials").mkdir()
    by_name = {trial.name: trial for trial in project.trials}
    entries = []
    for number, name in enumerate(rig.names):
        trial, file = by_name[name], f"trials/{number + 1:03d}.csv"
        entry: dict[str, Any] = {"file": file}
        if trial.locked:
            entry["locked"] = list(trial.locked)
        if trial.tip_mass:
            entry["tip_mass"] = _tip_text(trial.tip_mass, trial.tip_inertia, trial.tip_at)
        if trial.tilt:
            entry["tilt"] = write(trial.tilt, "deg")
        if trial.held_out:
            entry["held_out"] = True
        off = _torque_drives(project.leg) if rig.trials[number].known is None else []
        if off:  # else each case would warn of a current that is missing
            entry["drive_off"] = [rig.nominal.names[j] for j in off]
        entries.append(entry)
        _write_trial(folder / file, project.leg, rig, number, planted.readings[number])
    write_leg(project.leg, folder / "nominal.leg.yaml")
    written = load(project.path).value
    document: dict[str, Any] = {"kind": "gap", "leg": "nominal.leg.yaml", "trials": entries}
    document |= {key: written[key] for key in COPIED_KEYS if key in written}
    if project.noise:  # of the case's own readings, which are means where the user's are averaged
        joints = project.leg.joint_names
        document["noise"] = {name: write(float(rig.noise[joints.index(name)]), "deg") for name in project.noise}
    write_text(folder / "gap.yaml", yaml.safe_dump(document, sort_keys=False))
    return folder / "gap.yaml"


def _tip_text(mass: float, inertia: float, at: float | None) -> Any:
    if not inertia and at is None:
        return write(mass, "kg")
    found = {"mass": write(mass, "kg"), "inertia": write(inertia, "kg*m^2")}
    return found if at is None else found | {"at": write(at, "m")}


def _torque_drives(leg: Leg) -> list[int]:
    """Joints whose drive's current or torque was recorded."""
    return [j for j, joint in enumerate(leg.joints) if isinstance(joint.drive, TorqueDrive)]


def _known_columns(given: Leg, leg: PlantedLeg, known: tuple[Array, Array]) -> tuple[list[str], Array]:
    """Headers and columns (m, k) of the known torques, in the measured sense; the currents of joints ``by_current``."""
    torques = leg.sign * known[1]
    written = [j for j in range(leg.n) if torques[:, j].any() or j in _torque_drives(given)]
    heads, columns = [], []
    for j in written:
        drive, current = given.joints[j].drive, j in leg.by_current
        heads.append(f"{leg.names[j]} {'current [A]' if current else 'torque [N*m]'}")
        motor = drive.motor if isinstance(drive, TorqueDrive) else None
        factor = motor.torque_a_current if current and motor is not None else 1.0
        columns.append(torques[:, j] / factor)
    return heads, np.column_stack(columns) if columns else np.zeros((len(torques), 0))


def _write_trial(path: Path, given: Leg, rig: Rig, number: int, reading: Array) -> None:
    """Angles in degrees to 1e-7; known torques, currents and servos' inputs, in rows of their own where apart in time.

    ``given`` : the user's leg.
    """
    leg, trial = rig.nominal, rig.trials[number]
    heads = ["time [s]", *(f"{name} [deg]" for name in leg.names)]
    blocks = [_Block(rig.times[number], [_angle_cells(np.degrees(row)) for row in reading])]
    if trial.known is not None:
        names, columns = _known_columns(given, leg, trial.known)
        heads += names
        if names:
            blocks.append(_Block(trial.known[0], [_known_cells(row) for row in columns]))
    inputs = rig.inputs[number] if rig.inputs else None
    if inputs is not None:
        units = {SUPPLY: "V"} | {name + suffix: unit for name in leg.names for suffix, unit in SUFFIXES.items()}
        heads += [f"{name} [{units[name]}]" for name in inputs.columns]
        blocks.append(
            _Block(inputs.time, [_known_cells(row) for row in np.column_stack(list(inputs.columns.values()))])
        )
    write_text(path, "\n".join([",".join(heads), *_merge_by_time(blocks)]) + "\n")


class _Block(NamedTuple):
    """Columns with a clock of their own: times (m,) s, and the cells of each row."""

    time: Array
    cells: list[list[str]]


def _merge_by_time(blocks: list[_Block]) -> list[str]:
    """Rows of all in order of time; equal times share a row."""
    by_time = [{f"{t:.9g}": cells for t, cells in zip(each.time.tolist(), each.cells, strict=True)} for each in blocks]
    empty = [[""] * len(each.cells[0]) for each in blocks]
    moments = sorted({time for each in by_time for time in each}, key=float)
    return [
        ",".join([time, *(cell for own, none in zip(by_time, empty, strict=True) for cell in own.get(time, none))])
        for time in moments
    ]


def _known_cells(values: Array) -> list[str]:
    return ["" if math.isnan(value) else f"{value:.9g}" for value in values.tolist()]


def _angle_cells(values: Array) -> list[str]:
    return ["" if math.isnan(value) else f"{value:.7f}" for value in values.tolist()]
