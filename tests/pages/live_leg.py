"""A leg folder with what its page needs to move: three links of the tests, its releases, parts as boxes in a GLB."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.design.page_data import damper_json, leg_json, replay_json
from synth.design.response import WantedRelease, WantedResponse
from synth.parts.damper_law import power_law_curve
from synth.swing.chain import Conditions
from synth.swing.leg_model import Damper, Leg, Spring
from synth.swing.mechanics import coefficients, rest_pose, static_torque
from three_links import LEG as ON_LINES
from three_links import TIME

LEG = ON_LINES.with_joints(  # centres of mass beside the lines of links, which moves the leg by degrees
    **{
        joint.name: {"link": replace(joint.link, com_across=share * joint.link.length)}
        for joint, share in zip(ON_LINES.joints, (0.1, -0.08, 0.12), strict=True)
    }
)
CURVED = LEG.with_joints(
    hip={"damper": Damper(curve=power_law_curve(2.0, 5.0, 0.5))},
    knee={"damper": Damper(curve=power_law_curve(0.2, 5.0, 0.5))},
)
RUBBING = LEG.with_joints(  # every effect that the page's integrator knows, each moving the leg by degrees
    hip={"effects": {"coulomb_friction": {"torque": 0.3}}},
    knee={
        "armature": 2e-3,
        "effects": {
            "stribeck_friction": {"torque": 0.05, "fall": 0.6, "speed": 0.3},
            "hardening_spring": {"stiffening": 0.3, "softening": 0.5},
        },
    },
    ankle={
        "effects": {
            "quadratic_damping": {"coefficient": 0.002},
            "coulomb_friction": {"torque": 0.004, "presliding": 2e-3, "creep": 0.1},
        }
    },
)
STIFFER = 1.6  # times the knee's rate, of the alternative spring
RELEASES = (
    WantedRelease("free_1", TIME, np.array([0.1, 1.4, -0.5]), np.zeros(3), Conditions()),
    WantedRelease("free_2", TIME, np.array([0.5, 0.8, -1.0]), np.array([0.0, -2.0, 1.0]), Conditions()),
    WantedRelease("locked_hip", TIME, np.array([0.3, 1.0, -0.8]), np.array([0.0, 3.0, 1.0]), Conditions(locked=(0,))),
    WantedRelease("heavy", TIME, np.array([0.2, 1.2, -0.4]), np.array([1.0, -1.0, 0.0]), Conditions(tip_mass=0.05)),
    WantedRelease("tilted", TIME, np.array([0.2, 1.2, -0.4]), np.zeros(3), Conditions(tilt=0.35)),
)


def responses() -> tuple[WantedResponse, Leg]:
    """What is wanted (linear dampers), and the leg as built (two curved dampers)."""
    return WantedResponse.of(LEG, RELEASES), CURVED


def swapped(wanted: WantedResponse, built: Leg) -> tuple[Leg, float]:
    """The built leg with the stiffer spring at the knee, resting as wanted, and its error by the engine in degrees."""
    rate = built.joints[1].spring.rate * STIFFER  # type: ignore[union-attr]
    pose = rest_pose(wanted.leg)
    torque = static_torque(coefficients(built), pose, built.tilt)
    joint = built.joints[1]
    rest = float(pose[1] + torque[1] / rate)
    spring = Spring(rate, joint.zero + joint.sign * rest)
    leg = replace(built, joints=(built.joints[0], replace(joint, spring=spring), built.joints[2]))
    return leg, float(np.degrees(wanted.overall([leg])[0]))


def page_content(wanted: WantedResponse, built: Leg) -> dict[str, Any]:
    """``page.json`` of that leg, with one other spring at the knee."""
    pose = rest_pose(wanted.leg)
    torque = static_torque(coefficients(built), pose, built.tilt)
    error = float(np.degrees(wanted.overall([built])[0]))
    _, other = swapped(wanted, built)
    joints: dict[str, Any] = {}
    for j, joint in enumerate(built.joints):
        assert joint.spring is not None
        spring = {
            "part": f"wind {joint.name}", "vendor": "to wind", "rate": joint.spring.rate, "error": error,
            "within_tolerance": True, "outer_mm": 20.0, "stress_per_torque": 500.0, "allowed_mpa": 1200.0,
            "choice": "{make: true}",
        }  # fmt: skip
        springs = [spring]
        if j == 1:
            rate = joint.spring.rate * STIFFER
            springs.append({**spring, "part": "B 12", "rate": rate, "error": other, "choice": "{part: B 12}"})
        damper = {"part": "D", "vendor": "", "law": "curve", "error": error, "spring_rate": None, "outer_mm": None,
                  "choice": "{part: D}", "unnamed": "", **damper_json(joint.damper)}  # fmt: skip
        joints[joint.name] = {
            "holding": {"rotation": float(pose[j]), "torque": float(torque[j])},
            "springs": springs,
            "dampers": [damper, {**damper, "part": "E at 0.2 N*m", "choice": "", "unnamed": "ordered by torque"}],
        }
    names = [release.name for release in wanted.releases]
    return {
        "format": "synth/page/1",
        "leg": leg_json(built, rest_pose(built)),
        "replay": replay_json(built, wanted, names),
        "joints": joints,
    }


def engine_angles(wanted: WantedResponse, leg: Leg) -> list[Array]:
    """(m, n) deg, each release of the leg by the engine."""
    return [np.degrees(leg.to_measured(motion[:, :, 0])) for motion in wanted.simulate([leg])]


def write_leg_folder(folder: Path, made: ModuleType) -> Path:
    """A design folder whose page can move; returns the page."""
    import trimesh

    from synth.reports import write_leg_report

    wanted, built = responses()
    names = [release.name for release in RELEASES]
    design = made.make_design(folder, joints=list(built.joint_names), trials=1)
    (folder / "page.json").write_text(json.dumps(page_content(wanted, built)), encoding="utf-8")
    for file in (folder / "responses" / "target").glob("*.csv"):
        file.unlink()
    for name, now, aim in zip(names, engine_angles(wanted, built), engine_angles(wanted, LEG), strict=True):
        columns = {"time [s]": list(TIME)}
        for j, joint in enumerate(built.joint_names):
            columns |= {f"{joint} animal [deg]": list(aim[:, j]), f"{joint} wanted [deg]": list(aim[:, j]),
                        f"{joint} built [deg]": list(now[:, j])}  # fmt: skip
        made.write_columns(folder / "responses" / "target" / f"{name}.csv", columns)
    scene, parts = trimesh.Scene(), []
    for joint, place in zip(built.joint_names, _places(built), strict=True):
        for family, size, shift, moves in (
            ("upper", (0.04, 0.03, 0.03), (0.0, 0.02, 0.0), "upper"),
            ("lower", (0.03, 0.1, 0.02), (0.0, -0.06, 0.0), "lower"),
            ("spring", (0.05, 0.02, 0.02), (0.0, 0.0, 0.03), "spring"),
        ):
            box = trimesh.creation.box(size)
            box.apply_translation(np.array(place) + shift)
            scene.add_geometry(box, node_name=f"{joint}_{family}", geom_name=f"{joint}_{family}")
            parts.append({"part": f"{joint}_{family}", "joint": joint, "family": family, "made": "print",
                          "material": "print", "mass": {"value": 12.5, "unit": "g"}, "moves_with": moves})  # fmt: skip
    (folder / "parts").mkdir(exist_ok=True)
    (folder / "parts" / "leg.glb").write_bytes(scene.export(file_type="glb"))
    design["solids"]["parts"] = parts
    design["files"] += [{"path": f"parts/{part['part']}.step", "sha256": "00"} for part in parts]
    design["joints"]["knee"]["stops"] = [{"value": 40.0, "unit": "deg"}, {"value": 170.0, "unit": "deg"}]
    made.write_json(folder / "design.json", design)
    return write_leg_report(folder)


def _places(leg: Leg) -> list[tuple[float, float, float]]:
    """Where each joint stands at rest, m."""
    angles: Sequence[float] = np.cumsum(rest_pose(leg)) + leg.tilt
    x = y = 0.0
    found = []
    for joint, turn in zip(leg.joints, angles, strict=True):
        found.append((x, y, 0.0))
        x += joint.link.length * float(np.sin(turn))
        y -= joint.link.length * float(np.cos(turn))
    return found
