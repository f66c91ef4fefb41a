"""A designed leg's predicted response against its exported model in MuJoCo, with stops, friction and inertias.

The report predicts with our equations; ``leg.mjcf.xml`` holds the drawn leg: full inertias (with centres of mass
beside the link's line), dampers with their curves, dry friction and stops as limits. MuJoCo simulates each release.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from math import ceil, radians
from pathlib import Path
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.csv_table import in_si, read_table
from synth.files.leg_file import read_leg
from synth.files.mjcf import NOT_IN_MODEL
from synth.files.mjcf_backlash import arm_name, play_of
from synth.files.output import stems
from synth.files.run_manifest import sha256_file
from synth.model_checks.checked import ModelCheck, ModelChecks
from synth.model_checks.other_engine import HOW
from synth.mujoco_warnings import heard_warnings
from synth.parts.resolver import resolver
from synth.swing.effects import backlash
from synth.swing.foreign_effects import own_hashes
from synth.swing.leg_model import Leg

LIMIT = radians(0.3)  # issue 14, point 13: the exported model follows the report's prediction
MODEL, DESIGN, BUILT = "leg.mjcf.xml", "design.json", "built.leg.yaml"


@dataclass(frozen=True)
class Predicted:
    """One release of the report: times (m,) s, the built leg's rotations (m, n) rad and initial rates (n,)."""

    name: str
    time: Array
    rotation: Array
    rate: Array


def designed_leg_checks(folder: Path) -> ModelChecks:
    """Every joint of every predicted release, simulated by MuJoCo from the same start.

    Raises
    ------
    UserError : the folder is not a result of ``synth leg``.
    """
    files = [folder / name for name in (DESIGN, BUILT, MODEL)]
    missing = [path.name for path in files if not path.is_file()]
    if missing:
        raise UserError(Problem(f"is not a result of synth leg: {', '.join(missing)} is missing", str(folder)))
    design = json.loads((folder / DESIGN).read_text(encoding="utf-8"))
    leg = read_leg(folder / BUILT, resolve_part=resolver())
    inputs = tuple((path.name, sha256_file(path)) for path in files) + tuple(own_hashes(leg).items())
    try:
        import mujoco
    except ImportError:
        return ModelChecks(design["name"], "leg-design", (), (HOW,), inputs)
    model = mujoco.MjModel.from_xml_path(str(folder / MODEL))
    checks, left_out = [], _left_out(folder / MODEL)
    source = f"MuJoCo {mujoco.__version__} with {MODEL}, at the largest difference"
    for release in predicted(folder, design, leg):
        with heard_warnings(mujoco):  # a motion that diverges is told by its difference
            moved = move(mujoco, model, leg, release)
        for j, joint in enumerate(leg.joints):
            worst = int(np.argmax(np.abs(moved[:, j] - release.rotation[:, j])))
            theirs, ours = (leg.to_measured(motion[worst])[j] for motion in (moved, release.rotation))
            name = f"response to {release.name}"
            checks.append(ModelCheck(name, joint.name, float(theirs), float(ours), LIMIT, "deg", source))
    return ModelChecks(design["name"], "leg-design", tuple(checks), tuple(left_out), inputs)


def predicted(folder: Path, design: dict[str, Any], leg: Leg) -> list[Predicted]:
    """The releases of ``responses/target``: angles from the tables, initial rates from the fit of the wanted motion."""
    fitted = [trial for trial in design["stages"]["target"]["trials"] if not trial["held_out"]]
    found = []
    for trial, stem in zip(fitted, stems([trial["file"] for trial in fitted]), strict=True):
        table = read_table(folder / "responses" / "target" / f"{stem}.csv")
        shown = [f"{name} {what}" for name in leg.joint_names for what in ("animal", "wanted", "built")]
        wanted = {"time": "s"} | dict.fromkeys(shown, "rad")
        columns, problems = in_si(table, wanted, "is not a response table")
        if problems:
            raise UserError(problems)
        angles = np.stack([columns[f"{name} built"] for name in leg.joint_names], axis=1)
        rates = [trial["initial_rate"][name] for name in leg.joint_names]
        rate = np.radians([rate["value"] for rate in rates]) * leg.sign
        rotation = leg.to_rotation(angles)
        rate = leg.rates_off_stops(rotation[0], rate)  # as the design is released from a stop
        found.append(Predicted(stem, columns["time"], rotation, rate))
    return found


def move(mujoco: Any, model: Any, leg: Leg, release: Predicted) -> Array:
    """(m, n) rad: one release by the exported model, in steps no longer than its own."""
    data = mujoco.MjData(model)
    joints = [model.joint(name) for name in leg.joint_names]
    place = [int(joint.qposadr[0]) for joint in joints]
    data.qpos[place] = release.rotation[0]
    data.qvel[[int(joint.dofadr[0]) for joint in joints]] = release.rate
    _set_arms(data, leg, release)
    out, step = np.empty_like(release.rotation), float(model.opt.timestep)
    for sample in range(len(release.time)):
        if sample > 0:
            interval = float(release.time[sample] - release.time[sample - 1])
            count = max(1, ceil(interval / step - 1e-9))
            model.opt.timestep = interval / count
            mujoco.mj_step(model, data, nstep=count)
        out[sample] = data.qpos[place]
    model.opt.timestep = step
    return out


def _set_arms(data: Any, leg: Leg, release: Predicted) -> None:
    """Springs behind a backlash start where the effect's model has them: held against their flank."""
    for joint, rotation, rate in zip(leg.joints, release.rotation[0], release.rate, strict=True):
        gap = play_of(joint, driven=joint.drive is not None)
        if gap:
            arm = data.joint(arm_name(joint.name))
            held = backlash.start(rotation - joint.rest, gap)  # type: ignore[no-untyped-call]
            arm.qpos[0] = joint.rest + held
            arm.qvel[0] = rate


def _left_out(path: Path) -> list[str]:
    """The omissions that the model states in its comments."""
    text = path.read_text(encoding="utf-8")
    parts = (part.partition("-->")[0].strip() for part in text.split("<!--")[1:])
    return [part for part in parts if part.startswith(NOT_IN_MODEL)]
