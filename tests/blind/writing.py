"""A case as files: ``gap.yaml``, ``nominal.leg.yaml``, ``trials/NN.csv``; none of them reveals the answer."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from blind.cases import Case
from synth.planting.model import Array, PlantedLeg, PlantedTrial
from synth.planting.setup import DEFAULT_TOLERANCE

LETTERS = "abcdefghjkmnpqrstuvwxyz23456789"


def folder_name(seed: int, number: int) -> str:
    """Eight letters, random."""
    rng = np.random.default_rng([seed, number, 0xF01D])
    return "".join(rng.choice(list(LETTERS), 8))


def _number(value: float, digits: int = 5) -> str:
    text = f"{value:.{digits}g}"
    return "0" if float(text) == 0 else text


def _length(value: float) -> str:
    return f"{_number(value * 1e3)} mm"


def _mass(value: float) -> str:
    return f"{_number(value * 1e3)} g"


def write_case(case: Case, folder: Path, name: str) -> None:
    """Write the case into ``folder``, which must not exist."""
    (folder / "trials").mkdir(parents=True)
    setup = case.setup
    lines = ["kind: gap", "leg: nominal.leg.yaml", "trials:"]
    names = setup.nominal.names
    for number, (trial, times, reading) in enumerate(
        zip(setup.trials, case.times, case.readings, strict=True), start=1
    ):
        file = f"trials/{number:02d}.csv"
        entry = [f"file: {file}"]
        if trial.tip_mass:
            entry.append(f"tip_mass: {_mass(trial.tip_mass)}")
        if trial.locked:
            entry.append(f"locked: [{', '.join(names[j] for j in trial.locked)}]")
        if trial.tilt:
            entry.append(f"tilt: {_number(math.degrees(trial.tilt))} deg")
        if trial.held_out:
            entry.append("held_out: true")
        lines.append(f"  - {{{', '.join(entry)}}}")
        _write_trial(folder / file, names, times, np.degrees(reading), _torque(setup.nominal, trial, times))
    lines.append(f"tolerance: {{{', '.join(_tolerances())}}}")
    (folder / "gap.yaml").write_text("\n".join(lines) + "\n")
    (folder / "nominal.leg.yaml").write_text(_leg_text(case, name))


def _tolerances() -> list[str]:
    shown = []
    for key, value in DEFAULT_TOLERANCE.items():
        shown.append(
            f"{key}: {_number(math.degrees(value))} deg" if key == "free_angle" else f"{key}: {_number(value * 100)} %"
        )
    return shown


def _leg_text(case: Case, name: str) -> str:
    leg: PlantedLeg = case.setup.nominal
    lines = [
        "kind: leg",
        f"name: leg {name}",
        "gravity: 9.81 m/s^2",
        f"tilt: {_number(math.degrees(leg.tilt))} deg",
        "joints:",
    ]
    for j in range(leg.n):
        length, mass, com, inertia, rate, damping, free = leg.values[:, j]
        free_reading = math.degrees(leg.zero[j] + leg.sign[j] * free)
        lines += [
            f"  - name: {leg.names[j]}",
            f"    zero: {_number(math.degrees(leg.zero[j]))} deg",
            f"    sign: {'+1' if leg.sign[j] > 0 else '-1'}",
        ]
        if case.setup.ranges:
            low, high = travel(case, j)
            lines.append(f"    range: [{low} deg, {high} deg]")
        lines += [
            f"    link: {{length: {_length(length)}, mass: {_mass(mass)}, com: {_length(com)}, "
            f"inertia: {_number(inertia)} kg*m^2}}",
            f"    spring: {{rate: {_number(rate)} N*m/rad, free_angle: {_number(free_reading, 6)} deg}}",
            f"    damper: {{rate: {_number(damping)} N*m*s/rad}}",
        ]
    return "\n".join(lines) + "\n"


def travel(case: Case, joint: int) -> tuple[int, int]:
    """The joint's designed range in whole degrees: the recorded range and an independent margin."""
    seen = np.degrees(np.concatenate([r[:, joint] for r in case.readings]))
    margin = np.random.default_rng([*case.answer["seed"], joint]).uniform(4, 40, 2)
    return math.floor(np.nanmin(seen) - margin[0]), math.ceil(np.nanmax(seen) + margin[1])


def _torque(leg: PlantedLeg, trial: PlantedTrial, times: Array) -> tuple[str, Array] | None:
    """Header and column of a known torque, in the measured angle's sense."""
    if not trial.drive:
        return None
    j = int(trial.drive[0])
    return f"{leg.names[j]} torque [N*m]", leg.sign[j] * trial.torque(times + trial.start)


def _write_trial(
    path: Path, names: tuple[str, ...], times: Array, reading: Array, torque: tuple[str, Array] | None
) -> None:
    rows = [",".join(["time [s]", *(f"{name} [deg]" for name in names), *([torque[0]] if torque else [])])]
    for k, (t, row) in enumerate(zip(times, reading, strict=True)):
        known = [_number(float(torque[1][k]), 8)] if torque else []
        rows.append(",".join([f"{t:.6f}", *("" if np.isnan(v) else f"{v:.5f}" for v in row), *known]))
    path.write_text("\n".join(rows) + "\n")
