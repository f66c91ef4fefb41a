"""Recordings of a pendulum that a known torque drives until it turns over, as a project that ``synth gap`` reads."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from synth.files.gap_project import GapProject, read_gap_project
from synth.files.leg_file import read_leg
from synth.swing.chain import simulate

LEG = """kind: leg
name: pendulum
gravity: 9.81 m/s^2
joints:
  - name: hinge
    zero: 0 deg
    sign: +1
    range: [-7200 deg, 7200 deg]
    armature: 2e-3 kg*m^2
    link: {length: 500 mm, mass: 680 g, com: 450 mm, inertia: 9e-3 kg*m^2}
    damper: {rate: 0 N*m*s/rad}
"""
TOLERANCE = "{length: 0.5 %, mass: 1 %, com: 2 %, inertia: 10 %, damper: 5 %}"


def recorded(
    folder: Path,
    effects: dict[str, dict[str, float]],
    seed: int,
    torques: tuple[float, float],
    seconds: float,
    count: int,
) -> GapProject:
    """``count`` trials from rest with sine torques of 0.5 to 0.9 Hz and so many N m, noise of 0.05 deg at 200 Hz."""
    (folder / "pendulum.leg.yaml").write_text(LEG)
    leg, generator = read_leg(folder / "pendulum.leg.yaml"), np.random.default_rng(seed)
    built = leg.with_joints(hinge={"effects": effects})
    time = np.linspace(0.0, seconds, round(200 * seconds) + 1)
    lines = ["kind: gap", "leg: pendulum.leg.yaml", f"tolerance: {TOLERANCE}", "trials:"]
    for number in range(count):
        turn = 2.0 * np.pi * generator.uniform(0.5, 0.9) * time + generator.uniform(0.0, 2.0 * np.pi)
        torque = generator.uniform(*torques) * np.sin(turn)
        start = [generator.uniform(-1.0, 1.0)]
        angle = simulate(built, start, [0.0], time, tolerance=1e-9, known_torque=(time, torque[:, None]))[:, 0]
        angle = np.degrees(angle) + 0.05 * generator.standard_normal(len(time))
        rows = "\n".join(f"{t:.4f},{q:.5f},{m:.5f}" for t, q, m in zip(time, angle, torque, strict=True))
        (folder / f"{number}.csv").write_text(f"time [s],hinge [deg],hinge torque [N*m]\n{rows}\n")
        lines.append(f"  - {number}.csv")
    (folder / "gap.yaml").write_text("\n".join(lines) + "\n")
    return read_gap_project(folder / "gap.yaml")
