"""A cause far larger than its prior calls usual is estimated as it is, and not pulled towards its absence."""

from __future__ import annotations

from pathlib import Path

import numpy as np

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
