"""A cause far larger than its prior calls usual is estimated as it is, and not pulled towards its absence."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from hopper.hoppers import catalogue
from hopper.recorded import DESIGN, PART, changed, write
from synth.arrays import Array
from synth.diagnosis.plants.jumping_leg.jump_bench import JumpFit
from synth.diagnosis.plants.jumping_leg.jump_candidates import candidates
from synth.diagnosis.plants.jumping_leg.jump_diagnosis import JumpingLeg
from synth.diagnosis.plants.jumping_leg.jump_search import as_designed
from synth.estimation.intervals import NORMAL90
from synth.files.hopper_gap_project import read_hopper_gap_project
from synth.jump.jump_runs import compiled_jump

SAG = 5.0  # ohm, of a worn block battery; the prior's deviation is 0.15 of the winding's 3.75 ohm


def sagging(length: float, ratio: int, seed: int) -> Array:
    """(n, 3) time, ground force, upper link for 0.3 s: the leg hardly lifts off."""
    jumper = compiled_jump("upper")
    leg = changed(length, ratio, {"voltage_sag": {"resistance": SAG}}).workspace()[:, 0]
    rows = jumper.trace(leg, tolerance=1e-6, duration=0.3, fall=np.inf)
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, rows[-1, 0], 1e-3)
    force, angle = (np.interp(time, rows[:, 0], rows[:, 1 + jumper.layout.row(name)]) for name in ("normal", "angle"))
    noisy = angle + rng.normal(0.0, np.radians(0.1), len(time))
    return np.column_stack([time, force + rng.normal(0.0, 0.02, len(time)), noisy])


def test_a_supply_resistance_of_nine_deviations_is_within_its_interval(tmp_path: Path) -> None:
    """From three jumps whose force and angle were recorded; with a normal prior the interval ends at 4.71 ohm."""
    (tmp_path / "hopper.yaml").write_text(DESIGN)
    lines = ["kind: gap", "leg: hopper.yaml", "trials:"]
    for k, (length, ratio) in enumerate([(0.12, 150), (0.12, 100), (0.1, 150)]):
        write(tmp_path / f"{k}.csv", sagging(length, ratio, k))
        lines.append(f'  - {{file: {k}.csv, motor: "{PART.format(ratio)}", length: {1e3 * length:g} mm}}')
    (tmp_path / "gap.yaml").write_text("\n".join(lines) + "\n")
    plant = JumpingLeg(read_hopper_gap_project(tmp_path / "gap.yaml"), catalogue())
    (sag,) = (each for each in candidates(plant.bench.trials) if each.key[0] == "voltage_sag")
    still = as_designed(plant.bench)
    start = JumpFit((sag,), np.concatenate([still.unknowns, [4.0]]), still.own)
    fit = plant.bench.solve_softly(start)
    width = NORMAL90 * float(np.sqrt(plant.covariance(fit)[-1, -1]))
    low, high = (sag.named(fit.unknowns[-1:] + side * width)["resistance"] for side in (-1.0, 1.0))
    assert low < SAG < high
    assert high - low < 1.0


def test_dry_gear_friction_is_told_with_what_the_motors_own_tolerance_takes(tmp_path: Path) -> None:
    """Of two motors the mean of their tolerances, as for torque constant and inductance."""
    (tmp_path / "hopper.yaml").write_text(DESIGN)
    lines = ["kind: gap", "leg: hopper.yaml", "trials:"]
    for ratio in (150, 100):
        write(tmp_path / f"{ratio}.csv", sagging(0.12, ratio, ratio))
        lines.append(f'  - {{file: {ratio}.csv, motor: "{PART.format(ratio)}", length: 120 mm}}')
    (tmp_path / "gap.yaml").write_text("\n".join(lines) + "\n")
    plant = JumpingLeg(read_hopper_gap_project(tmp_path / "gap.yaml"), catalogue())
    tolerances, jumps = plant.bench.predictor.tolerances, plant.bench.trials[0].jumps
    x = np.zeros(tolerances.size)
    own = float(jumps.friction[0])
    assert tolerances.against_design("gear_friction", {"torque": 6e-4}, jumps, x) == {"torque": 6e-4}
    for group, deviations in enumerate((2.0, 0.0)):
        x[tolerances.at("friction", group)] = deviations
    told = tolerances.against_design("gear_friction", {"torque": 6e-4}, jumps, x)["torque"]
    assert told == pytest.approx(6e-4 + own * (np.exp(tolerances.tolerance.friction) - 1.0))
