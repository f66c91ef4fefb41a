"""Possible next trials, jumps and pull-ups, and their prediction by a hypothesis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.diagnosis.plant import MenuItem
from synth.diagnosis.plants.jumping_leg.jump_bench import JumpBench, JumpFit
from synth.diagnosis.plants.jumping_leg.jump_data import ANGLE, CURRENT, FORCE, LEAST_NOISE, MODEL_ERROR_SHARE, Jump
from synth.diagnosis.plants.jumping_leg.jump_predict import N_TRIAL_UNKNOWN
from synth.estimation.information import TrialForecast
from synth.files.hopper_gap_project import HopperGapProject, JumpTrial
from synth.hopper.motors import motor_of
from synth.jump.jump_models import MODELS, columns
from synth.parts.catalogs import Catalogue
from synth.units import write

PULL_SHARE, PULL_TIME = 0.35, 1.0  # share of the stall torque, s: an imagined pull-up
NOISE_OF_NEW_SENSORS = {
    CURRENT: 0.01,
    "supply": 0.01,
    "pitch": 2e-3,
    "foot slide": 2e-4,
}  # of sensors that no trial has yet
LEAN_ANGLE = np.radians(10.0)  # of a suggested leaning jump


def menu(project: HopperGapProject, catalogue: Catalogue, trials: Sequence[Jump]) -> list[MenuItem[Jump]]:
    """Other supplies, loads, lengths and ratios; recorded currents; a lean; a pull-up."""
    jumps = [trial for trial in trials if trial.torque is None and not trial.leaning] or list(trials)
    usual = jumps[0]
    made = []
    if usual.torque is None:
        made.append(
            _menu_item("another jump like the first", {}, _imagined_jump(project, catalogue, usual, usual.trial))
        )
        for what, keys, change in _single_changes(usual, catalogue):
            made.append(
                _menu_item(what, keys, _imagined_jump(project, catalogue, usual, replace(usual.trial, **change)))
            )
        if CURRENT not in usual.measured:
            imagined = _imagined_jump(project, catalogue, usual, usual.trial, (CURRENT, "supply"))
            made.append(_menu_item("the motors' current and the supply's voltage recorded with a jump", {}, imagined))
        if any(trial.leaning for trial in trials):  # otherwise no candidate would show in a lean
            leaning = replace(usual.trial, lean=LEAN_ANGLE)
            imagined = _imagined_jump(project, catalogue, usual, leaning, ("pitch", "foot slide"))
            what = "a jump that starts leaning by 10 deg, its pitch and the foot's slide recorded"
            made.append(_menu_item(what, {"lean": "10 deg"}, imagined))
    made.append(_menu_item("an inverted pull-up, with its torque recorded", {}, _imagined_pull_up(usual)))
    return made


def _menu_item(what: str, keys: Mapping[str, object], jump: Jump) -> MenuItem[Jump]:
    """The item with the release angle of the hip, or a pull-up's first angle."""
    start = float(jump.jumps.start[0]) if jump.torque is None else float(jump.measured[ANGLE][0])
    return MenuItem(what, {"file": "jumps/next.csv", **keys}, jump, {"hip": start})


def _single_changes(usual: Jump, catalogue: Catalogue) -> list[tuple[str, dict[str, object], dict[str, Any]]]:
    """Words, ``trials:`` keys and trial's values of single changes."""
    body = usual.leg.structure_mass + 2 * usual.motor.mass
    volts, load = float(f"{0.75 * usual.motor.voltage:.3g}"), float(f"{0.3 * body:.2g}")
    found: list[tuple[str, dict[str, object], dict[str, Any]]] = [
        (f"a supply of {volts:g} V", {"supply": f"{volts:g} V"}, {"supply": volts}),
        (f"{load * 1e3:g} g more on the body", {"payload": write(load, "g")}, {"payload": load}),
    ]
    for share in (0.75, 1.25):
        length = float(f"{share * usual.leg.length:.2g}")
        keys: dict[str, object] = {"length": f"{length * 1e3:g} mm"}
        found.append((f"links of {length * 1e3:g} mm", keys, {"length": length}))
    family = usual.motor.name.rsplit(" ", 1)[0]
    rows = [row for row in catalogue.motors if row.complete and row.part.rsplit(" ", 1)[0] == family]
    rows = [row for row in rows if row.gear_ratio and row.part != usual.motor.name]
    below = [row for row in rows if (row.gear_ratio or 0.0) < usual.motor.gear_ratio]
    above = [row for row in rows if (row.gear_ratio or 0.0) > usual.motor.gear_ratio]
    near = [max(below, key=lambda r: r.gear_ratio or 0.0)] if below else []
    near += [min(above, key=lambda r: r.gear_ratio or 0.0)] if above else []
    return found + [(f"the motor {row.part}", {"motor": row.part}, {"motor": row.part}) for row in near]


def _imagined_jump(
    project: HopperGapProject, catalogue: Catalogue, usual: Jump, trial: JumpTrial, more: Sequence[str] = ()
) -> Jump:
    """A jump under other conditions, with the usual and some more sensors, without readings."""
    design = project.design
    options = replace(design.motor_options, supply=trial.supply or design.motor_options.supply)
    motor = motor_of(catalogue.find_motor(trial.motor), options)
    leg = design.leg.with_length(trial.length)
    leg = replace(leg, structure_mass=leg.structure_mass + trial.payload)
    model = MODELS["A" if design.model == "C" else design.model]
    made = columns(leg, motor, design.contact, model, np.array([trial.length]))
    time = np.arange(0.0, 1.3 * usual.time[-1], float(np.median(np.diff(usual.time))))
    names = [*usual.measured, *(name for name in more if name not in usual.measured)]
    noise = {name: usual.noise.get(name, NOISE_OF_NEW_SENSORS.get(name, LEAST_NOISE[name])) for name in names}
    sizes = {FORCE: 4.0 * float(made.total_mass[0]) * leg.gravity, CURRENT: 2 * motor.stall_current,
             "supply": motor.voltage}  # fmt: skip
    sigma = {
        name: np.full(len(time), np.hypot(noise[name], MODEL_ERROR_SHARE[name] * sizes.get(name, 0.0)))
        for name in names
    }
    nothing = {name: np.zeros(len(time)) for name in names}
    group = usual.group if trial.motor == usual.trial.motor else -1
    return Jump(trial, leg, motor, time, nothing, sigma, noise, made, group, usual.slip_speed)


def _imagined_pull_up(usual: Jump) -> Jump:
    """A pull-up of the usual leg with a torque that oscillates three times per second."""
    time = np.arange(0.0, PULL_TIME, 1e-3)
    weight = usual.leg.gravity * float(usual.jumps.total_mass[0])
    lever = usual.leg.leverage(np.radians(20.0))
    torque = 0.5 * weight * lever * (1.0 + PULL_SHARE * np.sin(6.0 * np.pi * time)) * 1.5
    angle = np.full(len(time), np.radians(15.0))
    noise = {ANGLE: usual.noise[ANGLE]}
    trial = replace(usual.trial, kind="pull-up", lean=0.0, supply=None, payload=0.0)
    sigma = {ANGLE: np.full(len(time), usual.noise[ANGLE])}
    return replace(usual, trial=trial, time=time, measured={ANGLE: angle}, sigma=sigma, noise=noise, torque=torque)


def forecast(bench: JumpBench, fit: JumpFit, trial: Jump, covariance: Array) -> TrialForecast | None:
    """Prediction and its uncertainty, whitened by the noise; None if the simulation fails.

    A motor that no trial has used gets the tolerances of a new one.
    """
    spread = np.linalg.cholesky(covariance)
    if trial.group < 0:
        trial = replace(trial, group=0)
        first = bench.predictor.tolerances.at("motor", 0)
        width = bench.n_tolerance - first
        fresh = covariance.copy()
        fresh[first : first + width], fresh[:, first : first + width] = 0.0, 0.0
        fresh[range(first, first + width), range(first, first + width)] = 1.0
        spread = np.linalg.cholesky(fresh)
        unknowns = fit.unknowns.copy()
        unknowns[first : first + width] = 0.0
        fit = fit.at(unknowns)
    mean, slopes = bench.slopes(trial, fit, np.zeros(N_TRIAL_UNKNOWN))
    count = len(fit.unknowns)
    if not np.all(np.isfinite(mean)):
        return None
    root: Array = np.concatenate([slopes[:, :count] @ spread, slopes[:, count:]], axis=1)
    return TrialForecast(mean, root, np.zeros((len(mean), 0)))
