"""Files of a jumping leg's diagnosis: gap.json, predictions, and the missing torque."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.diagnosis.plants.jumping_leg.jump_data import ANGLE, UNITS, Jump, factor_of
from synth.diagnosis.plants.jumping_leg.jump_result import JumpGapResult
from synth.diagnosis.plants.jumping_leg.jump_score import ScoredJump
from synth.diagnosis.write import STAGES, basis_json, rms
from synth.files.hopper_gap_project import HopperGapProject
from synth.files.input_hashes import input_hashes
from synth.files.output import place, stems, write_csv, write_json
from synth.jump.effects import motor_effect_named
from synth.units import quantity

NAMES = {ANGLE: "hip"}  # place of the encoder; other channels keep their name
ANGLES = {"angle": "deg", "stop": "deg", "crouch": "deg", "start": "ms"}  # tolerances that are not relative


def write_gap(result: JumpGapResult, project: HopperGapProject, folder: Path) -> None:
    """Write everything except the page into ``folder``."""
    names = stems([trial.name for trial in result.gaps.trials])
    (folder / "predicted").mkdir()
    (folder / "where").mkdir()
    for i, name in enumerate(names):
        trial = result.gaps.trials[i]
        stages = {stage: getattr(result.gaps, stage)[i] for stage in STAGES}
        write_csv(place(folder / "predicted", f"{name}.csv"), predicted_columns(trial, stages))
        write_csv(place(folder / "where", f"{name}.csv"), _where_columns(result, i))
        if result.gaps.alone:
            (folder / "alone").mkdir(exist_ok=True)
            write_csv(place(folder / "alone", f"{name}.csv"), alone_columns(trial, result.gaps.alone, i))
    write_json(folder / "gap.json", gap_json(result, project, names))


def predicted_columns(trial: Jump, stages: dict[str, ScoredJump]) -> dict[str, Array]:
    """Time, and each channel as measured, with the nominal leg's best fit and with the explanation."""
    columns: dict[str, Array] = {"time [s]": trial.time}
    for channel, measured in trial.measured.items():
        name, unit = NAMES.get(channel, channel), UNITS[channel]
        scale = factor_of(channel)
        columns[f"{name} measured [{unit}]"] = measured / scale
        for stage in ("before", "after"):
            columns[f"{name} {stage} [{unit}]"] = stages[stage].channels[channel] / scale
    return columns


def alone_columns(trial: Jump, alone: Mapping[str, Sequence[ScoredJump]], i: int) -> dict[str, Array]:
    """Time, and every channel with each of the likeliest causes alone."""
    columns: dict[str, Array] = {"time [s]": trial.time}
    for cause, scored in alone.items():
        for channel in trial.measured:
            name, unit = NAMES.get(channel, channel), UNITS[channel]
            scale = factor_of(channel)
            columns[f"{name} with {cause} [{unit}]"] = scored[i].channels[channel] / scale
    return columns


def _where_columns(result: JumpGapResult, i: int) -> dict[str, Array]:
    trial, lack = result.gaps.trials[i], result.lacks[i]
    measured = trial.measured[ANGLE]
    errors = {
        f"hip error {stage} [deg]": np.degrees(getattr(result.gaps, stage)[i].channels[ANGLE] - measured)
        for stage in ("before", "after")
    }
    return {
        "time [s]": trial.time,
        "phase [1]": lack.phase.astype(float),
        "hip missing torque [N*m]": lack.torque,
        "hip speed [deg/s]": np.degrees(lack.speed),
        "hip deflection [deg]": np.degrees(lack.deflection),
        **errors,
    }


def gap_json(result: JumpGapResult, project: HopperGapProject, names: list[str]) -> dict[str, Any]:
    """The content of ``gap.json``: the diagnosis, then its input; ``names``: file name of each scored trial."""
    document = result.as_json()
    document["gap"]["joints"] = {"hip": {stage: document["gap"][stage] for stage in STAGES}}
    return {
        **document,
        "trials": [_trial_json(result, i, name) for i, name in enumerate(names)],
        "design_at": {name: quantity(value, "1") for name, value in result.unknowns.items()},
        **basis_json(result, project, motor_effect_named, ANGLES, input_hashes(project)),
    }


def _trial_json(result: JumpGapResult, i: int, name: str) -> dict[str, Any]:
    trial, rise = result.gaps.trials[i], result.gaps.rises[i]
    errors = {}
    for stage in STAGES:
        value = rms(getattr(result.gaps, stage)[i].channels[ANGLE] - trial.measured[ANGLE])
        if value is not None:
            errors[stage] = quantity(value, "deg")
    rises = {stage: getattr(rise, stage) for stage in ("measured", *STAGES)}
    return {
        "file": trial.name,
        "kind": trial.trial.kind,
        "motor": trial.motor.name,
        "leg_length": quantity(trial.leg.length, "mm"),
        "held_out": trial.trial.held_out,
        "scored": True,
        "predicted": f"predicted/{name}.csv",
        "where": f"where/{name}.csv",
        **({"alone": f"alone/{name}.csv"} if result.gaps.alone else {}),
        "rms": {"hip": errors},
        "rise": {key: quantity(value, "mm") for key, value in rises.items() if value is not None},
    }
