"""A diagnosis as files: gap.json, what was predicted, where torque is missing, and the diagnosed leg."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

import synth
from synth.arrays import Array
from synth.diagnosis.prediction_error import shrink_of_best
from synth.diagnosis.result import PHASES, Cause, GapResult, TrialGap
from synth.estimation.parameters import PlantEffect
from synth.files.gap_project import GapProject
from synth.files.leg_file import write_leg
from synth.files.output import place, stems, write_csv, write_json
from synth.swing.effects import effect_named
from synth.units import quantity

LIBRARIES = ("numpy", "scipy", "numba")
STAGES = ("as_designed", "before", "after")
ANGLES = {"free_angle": "deg"}  # tolerances that are no shares


def write_gap(result: GapResult, project: GapProject, folder: Path) -> None:
    """Write everything but the page into ``folder``.

    ``predicted/NAME.csv`` a scored trial, ``where/NAME.csv`` a trial, ``alone/NAME.csv`` a scored trial with each of
    the likeliest causes alone; all are named in ``gap.json`` under ``trials``.
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
    write_json(folder / "gap.json", gap_json(result, project, names))


def predicted_columns(trial: TrialGap, joints: Sequence[str]) -> dict[str, Array]:
    """Time, and a joint its measured angle beside the nominal leg at its best and with the explanation in, deg."""
    columns: dict[str, Array] = {"time [s]": trial.time}
    for j, name in enumerate(joints):
        for kind in ("measured", "before", "after"):
            columns[f"{name} {kind} [deg]"] = np.degrees(getattr(trial, kind)[:, j])
    return columns


def alone_columns(trial: TrialGap, joints: Sequence[str]) -> dict[str, Array]:
    """Time, and a joint its angle with each of the likeliest causes alone, deg."""
    columns: dict[str, Array] = {"time [s]": trial.time}
    for cause, angles in trial.alone.items():
        for j, name in enumerate(joints):
            columns[f"{name} with {cause} [deg]"] = np.degrees(angles[:, j])
    return columns


def where_columns(trial: TrialGap, joints: Sequence[str]) -> dict[str, Array]:
    """Time, phase, and a joint the torque that the nominal leg at its best lacks beside speed, deflection and error."""
    columns: dict[str, Array] = {"time [s]": trial.time, "phase [1]": trial.phase.astype(float)}
    for j, name in enumerate(joints):
        columns[f"{name} missing torque [N*m]"] = trial.missing_torque[:, j]
        columns[f"{name} speed [deg/s]"] = np.degrees(trial.speed[:, j])
        columns[f"{name} deflection [deg]"] = np.degrees(trial.deflection[:, j])
        columns[f"{name} error before [deg]"] = np.degrees(trial.before[:, j] - trial.measured[:, j])
        columns[f"{name} error after [deg]"] = np.degrees(trial.after[:, j] - trial.measured[:, j])
    return columns


def gap_json(result: GapResult, project: GapProject, names: Sequence[str]) -> dict[str, Any]:
    """The content of ``gap.json``: the diagnosis, then what it rests on; ``names``: a file name a trial."""
    document = result.as_json()
    gap, warnings, inputs = document.pop("gap"), document.pop("warnings"), document.pop("inputs")
    of_best = shrink_of_best(
        *(estimate.value for estimate in (result.before, result.after, result.best_possible, result.noise_floor))
    )
    gap["shrink_of_best"] = None if of_best is None else quantity(of_best, "1")
    gap["joints"] = _by_joint([trial for trial in result.trials if trial.scored], result.leg.joint_names)
    document["name"] = project.name
    return {
        **document,
        "gap": gap,
        "effects": described(_causes(result), effect_named),
        "trials": [
            _trial(trial, name, result.leg.joint_names) for trial, name in zip(result.trials, names, strict=True)
        ],
        "phases": list(PHASES),
        "warnings": warnings,
        "settings": {"seed": project.seed, **tolerance_settings(asdict(project.tolerance), ANGLES)},
        "defaults": [{"key": d.key, "value": d.value, "why": d.reason} for d in project.defaults],
        "inputs": inputs,
        "versions": {"synth": synth.__version__, **{n: importlib.metadata.version(n) for n in LIBRARIES}},
    }


def rms(values: Array) -> float | None:
    """Root mean square of what is known; None where nothing is."""
    known = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(known**2))) if known.size else None


def _by_joint(trials: Sequence[TrialGap], joints: Sequence[str]) -> dict[str, Any]:
    """Joint -> RMS angle error as designed, before and after, over the trials given; locked joints are left out."""
    found: dict[str, Any] = {}
    for j, name in enumerate(joints):
        for stage in STAGES:
            errors = [getattr(trial, stage)[:, j] - trial.measured[:, j] for trial in trials]
            value = rms(np.concatenate(errors)) if errors else None
            if value is not None:
                found.setdefault(name, {})[stage] = quantity(value, "deg")
    return found


def _trial(trial: TrialGap, name: str, joints: Sequence[str]) -> dict[str, Any]:
    return {
        "file": trial.name,
        "held_out": trial.held_out,
        "scored": trial.scored,
        "predicted": f"predicted/{name}.csv" if trial.scored else None,
        "where": f"where/{name}.csv",
        **({"alone": f"alone/{name}.csv"} if trial.alone else {}),
        "rms": _by_joint([trial], joints),
    }


def _causes(result: GapResult) -> list[Cause]:
    return [*result.explanation, *(entry.cause for entry in result.ranked), *(c for tie in result.tied for c in tie)]


def described(causes: Sequence[Cause], effect_called: Callable[[str], PlantEffect]) -> dict[str, dict[str, str]]:
    """Every effect among the causes: what it is, its formula and source."""
    found = {}
    for name in dict.fromkeys(cause.effect for cause in causes):
        effect = effect_called(name)
        found[name] = {"meaning": effect.meaning, "formula": effect.formula, "source": effect.source}
    return found


def tolerance_settings(tolerances: Mapping[str, float], units: Mapping[str, str]) -> dict[str, Any]:
    """One setting a tolerance, written in its unit or else in percent."""
    return {
        f"tolerance.{name}": {**quantity(value, units.get(name, "percent")), "how": "one standard deviation"}
        for name, value in tolerances.items()
    }
