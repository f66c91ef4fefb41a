"""Files of a swinging chain's diagnosis: gap.json, predictions, missing torques, and the diagnosed leg."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.diagnosis.diagnosis_result import COMMAND_FILE
from synth.diagnosis.plants.swinging_chain.chain_result import GapResult, TrialGap
from synth.diagnosis.plants.swinging_chain.drive_numbers import all_with_drive_numbers
from synth.diagnosis.prediction_error import shrink_of_best
from synth.diagnosis.write import STAGES, basis_json, rms
from synth.estimation.parameters import DESIGNED
from synth.files.gap_project import GapProject
from synth.files.leg_file import write_leg
from synth.files.output import place, stems, write_csv, write_json
from synth.files.page_outline import outline_json
from synth.swing.chain import Conditions
from synth.swing.driving_inputs import driven_by
from synth.swing.effects import effect_named
from synth.swing.leg_model import Joint
from synth.units import quantity

ANGLES = {"free_angle": "deg"}  # tolerances that are not relative


def write_gap(result: GapResult, project: GapProject, folder: Path) -> None:
    """Write everything except the page into ``folder``.

    ``predicted/NAME.csv`` per scored trial, ``where/NAME.csv`` per trial, ``alone/NAME.csv`` per scored trial with each
    of the most probable causes alone; ``gap.json`` names them under ``trials``.
    """
    names = stems([trial.name for trial in result.trials])
    joints = result.leg.joint_names
    (folder / "predicted").mkdir()
    (folder / "where").mkdir()
    for trial, name in zip(result.trials, names, strict=True):
        if trial.scored:
            write_csv(place(folder / "predicted", f"{name}.csv"), predicted_columns(trial, joints))
        write_csv(place(folder / "where", f"{name}.csv"), where_columns(trial, joints))
        if trial.alone:
            (folder / "alone").mkdir(exist_ok=True)
            write_csv(place(folder / "alone", f"{name}.csv"), alone_columns(trial, joints))
    write_leg(result.diagnosed, folder / "diagnosed.leg.yaml")
    write_leg(project.leg, folder / "designed.leg.yaml")
    if result.next_experiment is not None and result.next_experiment.command is not None:
        write_csv(folder / COMMAND_FILE, command_columns(*result.next_experiment.command))
    write_json(folder / "gap.json", gap_json(result, project, names))
    write_json(folder / "page.json", outline_json(result.leg))


def command_columns(time: Array, command: Mapping[str, Array]) -> dict[str, Array]:
    """Time, and each driven joint's command angle, deg: a file that can be played as it is."""
    return {"time [s]": time, **{f"{name} command [deg]": np.degrees(angle) for name, angle in command.items()}}


def predicted_columns(trial: TrialGap, joints: Sequence[str]) -> dict[str, Array]:
    """Time, and each joint's command if it has one, measured angle, the nominal leg's best fit and explanation, deg."""
    columns: dict[str, Array] = {"time [s]": trial.time}
    for j, name in enumerate(joints):
        if name in trial.command:
            columns[f"{name} command [deg]"] = np.degrees(trial.command[name])
        for kind in ("measured", "before", "after"):
            columns[f"{name} {kind} [deg]"] = np.degrees(getattr(trial, kind)[:, j])
    return columns


def alone_columns(trial: TrialGap, joints: Sequence[str]) -> dict[str, Array]:
    """Time, and each joint's angle with each of the most probable causes alone, deg."""
    columns: dict[str, Array] = {"time [s]": trial.time}
    for cause, angles in trial.alone.items():
        for j, name in enumerate(joints):
            columns[f"{name} with {cause} [deg]"] = np.degrees(angles[:, j])
    return columns


def where_columns(trial: TrialGap, joints: Sequence[str]) -> dict[str, Array]:
    """Time, phase, and for each joint the torque missing from the nominal best fit, speed, deflection and error."""
    columns: dict[str, Array] = {"time [s]": trial.time, "phase [1]": trial.phase.astype(float)}
    for j, name in enumerate(joints):
        columns[f"{name} missing torque [N*m]"] = trial.missing_torque[:, j]
        columns[f"{name} speed [deg/s]"] = np.degrees(trial.speed[:, j])
        columns[f"{name} deflection [deg]"] = np.degrees(trial.deflection[:, j])
        columns[f"{name} error before [deg]"] = np.degrees(trial.before[:, j] - trial.measured[:, j])
        columns[f"{name} error after [deg]"] = np.degrees(trial.after[:, j] - trial.measured[:, j])
    return columns


def gap_json(result: GapResult, project: GapProject, names: Sequence[str]) -> dict[str, Any]:
    """The content of ``gap.json``: the diagnosis, then its input; ``names``: file name of each trial."""
    document = result.as_json()
    gap, inputs = document.pop("gap"), document.pop("inputs")
    of_best = shrink_of_best(
        *(estimate.value for estimate in (result.before, result.after, result.best_possible, result.noise_floor))
    )
    gap["shrink_of_best"] = None if of_best is None else quantity(of_best, "1")
    gap["joints"] = _errors_by_joint([trial for trial in result.trials if trial.scored], result.leg.joint_names)
    document["name"] = project.name
    ranked = [entry.cause for entry in result.ranked]
    document["explanation"] = all_with_drive_numbers(document["explanation"], result.explanation, project.leg)
    document["ranked"] = all_with_drive_numbers(document["ranked"], ranked, project.leg)
    tied = zip(document["tied"], result.tied, strict=True)
    document["tied"] = [all_with_drive_numbers(entries, causes, project.leg) for entries, causes in tied]
    return {
        **document,
        "gap": gap,
        "trials": [
            {**_trial_json(trial, name, result.leg.joint_names), **_conditions(project, trial.name)}
            for trial, name in zip(result.trials, names, strict=True)
        ],
        "designed": {joint.name: _designed_rates(joint) for joint in project.leg.joints},
        **basis_json(result, project, effect_named, ANGLES, inputs),
    }


def _designed_rates(joint: Joint) -> dict[str, Any]:
    """The rates that an effect's change is added to, where the joint has them."""
    spring = None if joint.spring is None else joint.spring.rate
    damper = None if joint.damper is None else joint.damper.rate
    rates = ((spring, "N*m/rad"), (damper, "N*m*s/rad"))
    return {name: quantity(rate, unit) for name, (rate, unit) in zip(DESIGNED, rates, strict=True) if rate is not None}


def _errors_by_joint(trials: Sequence[TrialGap], joints: Sequence[str]) -> dict[str, Any]:
    """Joint -> RMS angle error as designed, before and after, over the given trials; locked joints are left out."""
    found: dict[str, Any] = {}
    for j, name in enumerate(joints):
        for stage in STAGES:
            errors = [getattr(trial, stage)[:, j] - trial.measured[:, j] for trial in trials]
            value = rms(np.concatenate(errors)) if errors else None
            if value is not None:
                found.setdefault(name, {})[stage] = quantity(value, "deg")
    return found


def _conditions(project: GapProject, name: str) -> dict[str, Any]:
    """The conditions of the trial with that name."""
    names = project.leg.joint_names
    trial = next((trial for trial in project.trials if trial.name == name), None)
    if trial is None:
        return {}
    locked = tuple(names.index(joint) for joint in trial.locked)
    found = Conditions(locked, trial.tip_mass, trial.tilt, trial.tip_inertia, trial.tip_at).as_json(names)
    torque = None if trial.torques is None else (trial.time, trial.torques)
    by = list(driven_by(torque, trial.signals))
    return {**found, "driven_by": by} if by else found


def _trial_json(trial: TrialGap, name: str, joints: Sequence[str]) -> dict[str, Any]:
    return {
        "file": trial.name,
        "held_out": trial.held_out,
        "scored": trial.scored,
        "predicted": f"predicted/{name}.csv" if trial.scored else None,
        "where": f"where/{name}.csv",
        **({"alone": f"alone/{name}.csv"} if trial.alone else {}),
        "rms": _errors_by_joint([trial], joints),
    }
