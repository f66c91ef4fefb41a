"""Speed of jumps: compiled lanes beside MuJoCo on the same jumps in the same run; time of a sweep by its size.

Run it: ``python tests/bench/bench_hopper.py [--million]``. It prints a table; nothing is asserted on the clock. MuJoCo
is given its best form here: no Python callback, its own contact, a plain ``mj_step`` loop in C, Euler's method at the
largest step (0.2 ms) at which it does not blow up.
"""

from __future__ import annotations

import argparse
import resource
import sys
import time
from pathlib import Path

import mujoco
import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from hopper.hoppers import catalogue, motor
from synth.hopper.motors import chosen_rows, motor_of
from synth.hopper.sweep import SweepProblem, run_sweep
from synth.jump.hopper_leg import Contact, HopperLeg, HopperTolerances
from synth.jump.jump_models import MODELS, lanes
from synth.jump.jump_runs import compiled_jump, simulate
from synth.jump.mujoco_model import mjcf, mujoco_jump
from synth.jump.planar_jump import planar_jump

LENGTHS = (0.08, 0.16)


def say(text: str) -> None:
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


def rate_of_lanes(model: str, count: int = 3200) -> float:
    """Designs a second of one core: HP motors of 75:1 to 250:1 by lengths."""
    motors = [motor(ratio) for ratio in (75, 100, 150, 210, 250)]
    jumper = compiled_jump("upper")
    groups = [lanes(HopperLeg(), m, Contact(), MODELS[model], np.linspace(*LENGTHS, count // 5)) for m in motors]
    jumper.run(groups[0][:, :16])
    best = 0.0
    for _ in range(5):
        start = time.process_time()
        for group in groups:
            jumper.run(group)
        best = max(best, count / (time.process_time() - start))
    return best


def rate_of_mujoco(step: float) -> tuple[float, float]:
    """Jumps a second of model A's leg by MuJoCo alone in C for 0.25 s, and its greatest height of the hips, m."""
    text = mjcf(HopperLeg(), motor(), Contact(), MODELS["A"], "own", step).replace(
        'integrator="RK4"', 'integrator="implicitfast"'
    )
    model = mujoco.MjModel.from_xml_string(text)
    leg = HopperLeg()
    count, height = 20, 0.0
    start = time.perf_counter()
    for _ in range(count):
        data = mujoco.MjData(model)
        a, b = leg.crouch, leg.lower_angle(leg.crouch)
        relative = np.diff([a, a, -b], prepend=0.0)
        data.qpos[0], data.qpos[1:4], data.qpos[4:7] = leg.height(a), relative, -relative
        for _ in range(10):
            mujoco.mj_step(model, data, nstep=round(0.025 / step))
            height = max(height, float(data.qpos[0]))
    return count / (time.perf_counter() - start), height


def sweep(count: int) -> tuple[float, float, float]:
    """Seconds, seconds of all cores' work, and MB for ``count`` designs of model full, HP and HPCB motors."""
    motors = tuple(motor_of(row) for row in chosen_rows(catalogue().motors, ["N20 HP*"]))
    lengths = tuple(np.linspace(0.06, 0.18, -(-count // len(motors))))
    problem = SweepProblem(
        HopperLeg(), motors, (HopperTolerances(),) * len(motors), lengths, Contact(), MODELS["full"], False
    )
    start, worked = time.perf_counter(), time.process_time()
    found = run_sweep(problem)
    spent, worked = time.perf_counter() - start, time.process_time() - worked
    assert len(found.motor) >= count
    return spent, worked, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--million", action="store_true", help="also 1 000 000 designs")
    arguments = parser.parse_args()
    for model in ("A", "B", "D", "full"):
        say(f"lanes, model {model:5s} {rate_of_lanes(model):9.0f} designs/s of one core")
    start = time.perf_counter()
    planar_jump(HopperLeg(), motor(), Contact(), MODELS["full"])
    start, count = time.perf_counter(), 10
    for _ in range(count):
        planar_jump(HopperLeg(), motor(), Contact(), MODELS["full"])
    say(f"planar form, full   {count / (time.perf_counter() - start):9.0f} designs/s on one core")
    for step in (2e-4, 1e-4, 5e-5):
        rate, height = rate_of_mujoco(step)
        say(f"MuJoCo in C, h {step * 1e3:4.2f} ms {rate:7.1f} jumps/s on one core (hips to {height:.4f} m)")
    ours = simulate([(HopperLeg(), motor())], Contact(), MODELS["A"])[0]
    start = time.perf_counter()
    theirs = mujoco_jump(HopperLeg(), motor(), Contact(), MODELS["A"]).outcome
    rate = 1 / (time.perf_counter() - start)
    say(f"MuJoCo on our contact {rate:6.1f} jumps/s, clearance {theirs.clearance * 1e3:.3f} mm; "
        f"lanes {ours.clearance * 1e3:.3f} mm")  # fmt: skip
    for count in (1_000, 10_000, 100_000, *((1_000_000,) if arguments.million else ())):
        spent, worked, memory = sweep(count)
        say(f"sweep of {count:9d} designs {spent:7.1f} s; cores worked {worked:6.1f} s")
        say(f"   {count / worked:.0f} designs a core-second")
        say(f"   up to {memory:.0f} MB")


if __name__ == "__main__":
    main()
