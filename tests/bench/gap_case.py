"""Trials of a leg that rubs where its design does not, as a project that ``synth gap`` reads."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from bench import thesis_leg as thesis
from synth.arrays import Array
from synth.files.gap_project import Tolerance
from synth.files.leg_file import write_leg
from synth.files.output import write_csv
from synth.swing.chain import simulate
from synth.swing.leg_model import Leg
from synth.swing.tolerances import Tolerances

NOISE = np.radians(0.1)
HELD_OUT = 0.2  # of the trials
RUBBING = 0.012  # N m at the last joint but one


def pendulum() -> Leg:
    """One link alone: the thesis' shank on its knee."""
    return Leg("pendulum", thesis.leg().joints[1:2])


def releases(n: int, count: int) -> Array:
    """(count, n) rad from the free angles, 0.25 to 0.7 either way; the same however many there are."""
    generator = np.random.default_rng(1)
    drawn = generator.uniform(0.25, 0.7, (64, n)) * generator.choice([-1.0, 1.0], (64, n))
    return np.asarray(drawn[:count])


def write_project(leg: Leg, count: int, folder: Path, seed: int = 3) -> Path:
    """Write ``count`` trials of 1 s and 501 samples of the built leg, its design and ``gap.yaml``; a fifth held out."""
    folder.mkdir(parents=True)
    built, tolerances = leg, Tolerances.of(leg, Tolerance())
    generator = np.random.default_rng(seed)
    design = tolerances.leg(leg, np.clip(0.7 * generator.standard_normal(tolerances.size), -1.5, 1.5))
    joint = built.joints[-2 if len(built.joints) > 1 else 0]
    built = built.with_joints(**{joint.name: {"effects": {"coulomb_friction": {"torque": RUBBING}}}})
    rest = np.array([j.spring.free_angle for j in built.joints if j.spring])
    lines = ["kind: gap", "leg: nominal.leg.yaml", "trials:"]
    first_held = count - max(1, round(HELD_OUT * count))
    for index, away in enumerate(releases(len(built.joints), count)):
        motion = simulate(built, rest + away, np.zeros(len(rest)), thesis.TIMES)
        angles = np.degrees(built.to_measured(motion) + NOISE * generator.standard_normal(motion.shape))
        columns = {
            "time [s]": thesis.TIMES,
            **{f"{n} [deg]": a for n, a in zip(built.joint_names, angles.T, strict=True)},
        }
        write_csv(folder / f"{index:02d}.csv", columns)
        held = ", held_out: true" if index >= first_held else ""
        lines.append(f"  - {{file: {index:02d}.csv{held}}}")
    write_leg(replace(design, name="design"), folder / "nominal.leg.yaml")
    (folder / "gap.yaml").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder / "gap.yaml"
