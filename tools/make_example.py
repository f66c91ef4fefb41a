"""Make the recordings of the built-in examples: MuJoCo on published values, then noise and encoder counts.

``python tools/make_example.py`` writes them into ``synth/examples``; the same seeds give the same files. The sources of
the published values are in the examples' READMEs; the links are those of the examples' leg files.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests"))

from peers.mujoco_leg import simulate  # noqa: E402, the same independent engine as the tests'
from synth.files.gap_project import Tolerance  # noqa: E402
from synth.files.leg_file import read_leg  # noqa: E402
from synth.swing.leg_model import Damper, Leg, Link, Spring  # noqa: E402

Array = NDArray[np.float64]

TOLERANCE = Tolerance()
COUNTS = 8192  # per turn
SAMPLE_TIME = 0.01  # s
RELEASED_BEFORE = 0.01  # s, from the release at rest to the first sample
FREE_ANGLE = (105.0, 108.0, 139.0)  # deg; Krnacik's thesis, Table 4
ANIMAL_SPRING = (0.1242022, 0.00632399, 0.00136526)  # N m/rad; Table 1, swarm, with its exchanged columns corrected
ANIMAL_DAMPER = (0.00376482, 0.00014961, 0.00011696)  # N m s/rad
REST_SPREAD = 2.0  # deg, SD of the free angles' shift from trial to trial
ROBOT_SPRING = (23.6673, 1.7062, 0.4538)  # Table 3
ROBOT_DAMPER = (1.2903, 0.1054, 0.0634)
KNEE_DROP_TORQUE, KNEE_DROP_EXPONENT, KNEE_DROP_SMOOTHING = 0.1168, 0.44, 1e-3  # N m at 1 rad/s, 1, rad/s

# Release poses of the animal's leg relative to the free angles, deg: flexed and extended, near and far.
RELEASES = ((-13, 31, 16), (9, -17, -24), (14, 22, -18), (-9, -24, 21), (6, 35, 27), (-15, 18, -29), (11, -21, 24))
CHECKS = ((-12, 26, -20), (10, 30, 15))
ROBOT_RELEASES = ((-14, 28, -22), (15, 20, 25), (-11, -22, -18))
KNEE_DROPS = (84.0, 96.0, 108.0, 120.0)  # deg, measured
BUILT_RELEASES = ((-14, 34, -22), (15, 26, 25), (-11, -32, -18))
BUILT_CHECKS = ((13, -28, 24), (-9, 42, 10))
# N m, rad/s; friction that the gap's nominal leg lacks. Smoothed over 2e-3 rad/s the sticking knee creeps by 0.23 deg,
# twice the noise, over 2e-4 rad/s by 0.04 deg (against true sticking, ``synth.swing.chain.simulate``; a step of 1e-5 s
# changes neither).
KNEE_FRICTION, FRICTION_SMOOTHING = 0.06, 2e-4


@dataclass(frozen=True)
class Reading:
    """Sensor model of an angle: noise, deg SD, then counts."""

    noise: float
    generator: np.random.Generator

    def read(self, angle: Array) -> Array:
        """Readings in deg of true angles in deg, any shape."""
        count = 360.0 / COUNTS
        return count * np.round((angle + self.generator.normal(0.0, self.noise, angle.shape)) / count)


def with_parts(leg: Leg, spring: Sequence[float], damper: Sequence[float], free_angle: Sequence[float]) -> Leg:
    """The leg with linear springs (N m/rad, free angles in deg) and dampers (N m s/rad) at its joints."""
    changes = {
        name: {"spring": Spring(k, float(np.radians(angle))), "damper": Damper(rate=b)}
        for name, k, b, angle in zip(leg.joint_names, spring, damper, free_angle, strict=True)
    }
    return leg.with_joints(**changes)


def release(
    leg: Leg, pose: Sequence[float], duration: float, step: float = 5e-5, **conditions: object
) -> tuple[Array, Array]:
    """Release the leg at ``pose`` (deg): times (m,) s from the first sample, measured angles (m, n) deg."""
    times = np.arange(round(duration / SAMPLE_TIME) + 1) * SAMPLE_TIME
    since_release = np.concatenate([[0.0], times + RELEASED_BEFORE])
    start = leg.to_rotation(np.radians(pose))
    rotation = simulate(leg, start, np.zeros(len(start)), since_release, step=step, **conditions)[1:]  # type: ignore[arg-type]
    return times, np.degrees(leg.to_measured(rotation))


def write(path: Path, leg: Leg, times: Array, angle: Array) -> None:
    """One recording in the trials' format."""
    path.parent.mkdir(parents=True, exist_ok=True)
    header = ",".join(["time [s]", *(f"{name} [deg]" for name in leg.joint_names)])
    rows = [f"{t:.3f}," + ",".join(f"{a:.4f}" for a in angles) for t, angles in zip(times, angle, strict=True)]
    path.write_text("\n".join([header, *rows, ""]), encoding="utf-8", newline="\n")


def write_truth(folder: Path, truth: dict[str, object]) -> None:
    """Write the true parameters of a folder's recordings."""
    (folder / "truth.json").write_text(json.dumps(truth, indent=1) + "\n", encoding="utf-8", newline="\n")


def animal_releases(links: Leg, folder: Path) -> dict[str, list[float]]:
    """Write the animal's releases; returns the free angles (deg) of each."""
    generator = np.random.default_rng(20231)
    reading = Reading(0.2, generator)
    names = [f"release_{i + 1}" for i in range(len(RELEASES))] + [f"check_{i + 1}" for i in range(len(CHECKS))]
    free_angles = {}
    for name, away in zip(names, RELEASES + CHECKS, strict=True):
        free_angle = np.array(FREE_ANGLE) + generator.normal(0.0, REST_SPREAD, 3)
        leg = with_parts(links, ANIMAL_SPRING, ANIMAL_DAMPER, free_angle)
        times, angle = release(leg, np.array(FREE_ANGLE) + np.array(away), 0.7)
        write(folder / f"{name}.csv", leg, times, reading.read(angle))
        free_angles[f"{name}.csv"] = [round(float(value), 6) for value in free_angle]
    return free_angles


def knee_damper(rotation: Array, rate: Array) -> Array:
    """Torque of the power-law damper at the knee, N m, smoothed around zero speed."""
    speed = np.sqrt(rate[1] ** 2 + KNEE_DROP_SMOOTHING**2)
    return np.array([0.0, -KNEE_DROP_TORQUE * rate[1] * speed ** (KNEE_DROP_EXPONENT - 1.0), 0.0])


def knee_drops(leg: Leg, folder: Path) -> None:
    """Write drops of the shank with only the knee's damper, hip and ankle locked straight."""
    reading = Reading(0.1, np.random.default_rng(20232))
    for i, start in enumerate(KNEE_DROPS):
        times, angle = release(leg, [90.0, start, 180.0], 2.0, locked=(0, 2), extra_torque=knee_damper)
        write(folder / f"knee_{i + 1}.csv", leg, times, reading.read(angle))


def robot_trials(links: Leg, folder: Path) -> None:
    """Write the trials of the fit example."""
    reading = Reading(0.1, np.random.default_rng(20233))
    leg = with_parts(links, ROBOT_SPRING, ROBOT_DAMPER, FREE_ANGLE)
    trials: dict[str, tuple[Sequence[float], dict[str, object]]] = {
        f"free_{i + 1}": (away, {}) for i, away in enumerate(ROBOT_RELEASES)
    }
    trials["locked_hip"] = ((5, 30, 20), {"locked": (0,)})
    trials["heavy"] = ((12, -20, -25), {"tip_mass": 0.05})
    trials["tilted"] = ((-12, 25, 20), {"tilt": float(np.radians(20.0))})
    trials["check"] = ((13, -18, 24), {})
    for name, (away, conditions) in trials.items():
        times, angle = release(leg, np.array(FREE_ANGLE) + np.array(away), 1.2, **conditions)
        write(folder / f"{name}.csv", leg, times, reading.read(angle))


def as_built(nominal: Leg, generator: np.random.Generator) -> Leg:
    """The leg with errors within the gap's default tolerances on every parameter, and dry friction at the knee."""
    joints = []
    for joint in nominal.joints:
        assert joint.spring is not None
        assert joint.damper is not None
        assert joint.damper.rate is not None
        spread = [
            TOLERANCE.length,
            TOLERANCE.mass,
            TOLERANCE.com,
            TOLERANCE.inertia,
            TOLERANCE.spring,
            TOLERANCE.damper,
        ]
        factors = 1.0 + np.array(spread) * generator.normal(0.0, 1.0, len(spread))
        length, mass, com, inertia, spring, damper = (float(factor) for factor in factors)
        link = joint.link
        built = Link(link.length * length, link.mass * mass, link.com * com, link.inertia * inertia)
        free_angle = joint.spring.free_angle + float(generator.normal(0.0, TOLERANCE.free_angle))
        parts = Spring(joint.spring.rate * spring, free_angle), Damper(joint.damper.rate * damper)
        effects = {"coulomb_friction": {"torque": KNEE_FRICTION}} if joint.name == "knee" else {}
        joints.append(replace(joint, link=built, spring=parts[0], damper=parts[1], effects=effects))
    return replace(nominal, joints=tuple(joints))


def built_trials(nominal: Leg, folder: Path) -> dict[str, object]:
    """Write the trials of the gap example; returns the built leg's parameters."""
    generator = np.random.default_rng(20234)
    leg = as_built(nominal, generator)
    reading = Reading(0.1, generator)
    trials: dict[str, tuple[Sequence[float], dict[str, object]]] = {
        f"free_{i + 1}": (away, {}) for i, away in enumerate(BUILT_RELEASES)
    }
    trials["locked_hip"] = ((5, 36, 20), {"locked": (0,)})
    trials["heavy"] = ((12, -30, -25), {"tip_mass": 0.05})
    trials |= {f"check_{i + 1}": (away, {}) for i, away in enumerate(BUILT_CHECKS)}
    for name, (away, conditions) in trials.items():
        pose = np.array(FREE_ANGLE) + np.array(away)
        times, angle = release(leg, pose, 1.5, 2.5e-5, friction_width=FRICTION_SMOOTHING, **conditions)
        write(folder / f"{name}.csv", leg, times, reading.read(angle))
    built = {}
    for joint in leg.joints:
        assert joint.spring is not None
        assert joint.damper is not None
        values = {
            "length": (joint.link.length * 1e3, "mm"),
            "mass": (joint.link.mass * 1e3, "g"),
            "com": (joint.link.com * 1e3, "mm"),
            "inertia": (joint.link.inertia, "kg*m^2"),
            "spring_rate": (joint.spring.rate, "N*m/rad"),
            "damper_rate": (joint.damper.rate, "N*m*s/rad"),
            "free_angle": (np.degrees(joint.spring.free_angle), "deg"),
        }
        built[joint.name] = {key: {"value": float(f"{v:.6g}"), "unit": unit} for key, (v, unit) in values.items()}
    friction = {"joint": "knee", "torque": {"value": KNEE_FRICTION, "unit": "N*m"}}
    return {"coulomb_friction": friction, "built": built}


def truth_of(spring: Sequence[float], damper: Sequence[float]) -> dict[str, object]:
    """The values of all trials, joint by joint."""
    return {
        name: {
            "spring_rate": {"value": k, "unit": "N*m/rad"},
            "damper_rate": {"value": b, "unit": "N*m*s/rad"},
            "free_angle": {"value": angle, "unit": "deg"},
        }
        for name, k, b, angle in zip(("hip", "knee", "ankle"), spring, damper, FREE_ANGLE, strict=True)
    }


def make(examples: Path, out: Path) -> None:
    """Simulate the examples from the leg files in ``examples`` and write their recordings under ``out``."""
    shifted = animal_releases(read_leg(examples / "leg/animal/animal.leg.yaml"), out / "leg/animal/releases")
    knee_drops(read_leg(examples / "leg/robot/robot.leg.yaml"), out / "leg/robot/damper_drops")
    law = {"torque at 1 rad/s": {"value": KNEE_DROP_TORQUE, "unit": "N*m"}, "exponent": KNEE_DROP_EXPONENT}
    truth = {"animal": truth_of(ANIMAL_SPRING, ANIMAL_DAMPER), "free angles of each trial, deg": shifted}
    write_truth(out / "leg", {**truth, "knee damper of the drops": law})
    robot_trials(read_leg(examples / "fit/robot.leg.yaml"), out / "fit/trials")
    write_truth(out / "fit", {"robot": truth_of(ROBOT_SPRING, ROBOT_DAMPER)})
    write_truth(out / "gap", built_trials(read_leg(examples / "gap/nominal.leg.yaml"), out / "gap/trials"))


def main() -> None:
    """Write the recordings beside the leg files, or under ``--out``."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0] if __doc__ else None)
    examples = ROOT / "synth" / "examples"
    parser.add_argument("--out", type=Path, default=examples, help="folder to write into (default: %(default)s)")
    out: Path = parser.parse_args().out
    make(examples, out)
    print(f"written under {out}")


if __name__ == "__main__":
    main()
