"""A planted case as a user's project: the same leg, tolerances and trials, with simulated readings."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from synth.arrays import Array
from synth.files.leg_file import write_leg
from synth.files.output import write_text
from synth.rehearsal.plants import Planted
from synth.rehearsal.users_rig import Rig
from synth.units import write

if TYPE_CHECKING:
    from synth.files.gap_project import GapProject

Row = tuple[float, list[str], list[str]]  # time, cells of the angles and of the torques
KEPT_KEYS = ("tolerance", "accuracy", "noise", "seed")  # of the user's project, as written


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
            entry["tip_mass"] = _tip(trial.tip_mass, trial.tip_inertia, trial.tip_at)
        if trial.tilt:
            entry["tilt"] = write(trial.tilt, "deg")
        if trial.held_out:
            entry["held_out"] = True
        entries.append(entry)
        _write_trial(folder / file, rig, number, planted.readings[number])
    write_leg(project.leg, folder / "nominal.leg.yaml")
    written = load(project.path).value
    document = {"kind": "gap", "leg": "nominal.leg.yaml", "trials": entries}
    document |= {key: written[key] for key in KEPT_KEYS if key in written}
    write_text(folder / "gap.yaml", yaml.safe_dump(document, sort_keys=False))
    return folder / "gap.yaml"


def _tip(mass: float, inertia: float, at: float | None) -> Any:
    if not inertia and at is None:
        return write(mass, "kg")
    found = {"mass": write(mass, "kg"), "inertia": write(inertia, "kg*m^2")}
    return found if at is None else found | {"at": write(at, "m")}


def _write_trial(path: Path, rig: Rig, number: int, reading: Array) -> None:
    """Angles in degrees to 1e-7, and the known torques, in separate rows if sampled more densely."""
    leg, trial = rig.nominal, rig.trials[number]
    time = rig.times[number]
    heads = ["time [s]", *(f"{name} [deg]" for name in leg.names)]
    rows: list[Row] = [(float(t), [*_cells(np.degrees(row))], []) for t, row in zip(time, reading, strict=True)]
    if trial.known is not None:
        moments, torques = trial.known
        driven = np.flatnonzero(np.any(torques != 0.0, axis=0)).tolist()
        heads += [f"{leg.names[j]} torque [N*m]" for j in driven]
        rows = _with_torques(rows, moments, leg.sign[driven] * torques[:, driven], leg.n)
    lines = [",".join(heads), *(",".join([f"{t:.9g}", *angles, *torque]) for t, angles, torque in rows)]
    write_text(path, "\n".join(lines) + "\n")


def _with_torques(rows: list[Row], moments: Array, torques: Array, n: int) -> list[Row]:
    """Rows of both in order of time; equal times share a row."""
    merged: dict[float, Row] = {}
    empty = [""] * torques.shape[1]
    for t, angles, _ in rows:
        merged[float(f"{t:.9g}")] = (t, angles, empty)
    for t, row in zip(moments.tolist(), torques, strict=True):
        key = float(f"{t:.9g}")
        angles = merged[key][1] if key in merged else [""] * n
        merged[key] = (t, angles, [f"{value:.9g}" for value in row])
    return [merged[key] for key in sorted(merged)]


def _cells(values: Array) -> list[str]:
    return ["" if math.isnan(value) else f"{value:.7f}" for value in values.tolist()]
