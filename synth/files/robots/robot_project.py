"""A starting project for a leg taken from a robot's file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from synth.errors import Problem, UserError
from synth.files.leg_file import read_leg, write_leg
from synth.files.output import place, write_text
from synth.files.paths import read_bytes
from synth.files.robots.planar_chain import PickedLeg, pick_leg
from synth.files.robots.robot_tree import Robot
from synth.swing.leg_model import Leg

HEAD = 4_000  # bytes that tell a format
LEG_FILE = "robot.leg.yaml"
SMALLEST_READING = "trials/*.csv"


def read_robot(path: str | Path) -> Robot:
    """A robot from MJCF or URDF, distinguished by the root element, not by the file's extension.

    Raises
    ------
    UserError
        If the file is neither, or has mistakes.
    """
    file = Path(path)
    start = read_bytes(file, 200_000_000, "a robot's file names its meshes and does not hold them", first=HEAD)
    if b"<mujoco" in start and b"<robot" not in start.partition(b"<mujoco")[0]:
        from synth.files.robots.read_mjcf import read_mjcf

        return read_mjcf(file)
    if b"<robot" in start:
        from synth.files.robots.read_urdf import read_urdf

        return read_urdf(file)
    text = "is neither MJCF (root <mujoco>) nor URDF (root <robot>)"
    if b"<sdf" in start:
        text += "; SDF is written by synth and not read: convert it to URDF"
    raise UserError(Problem(text, str(path)))


def robot_leg(path: str | Path, chain: Sequence[str], plane: str | None = None, tip: float | None = None) -> PickedLeg:
    """The chain of a robot's file as a leg, see ``pick_leg``; mistakes name the file."""
    robot = read_robot(path)
    try:
        return pick_leg(robot, chain, plane, tip)
    except UserError as error:
        raise UserError([Problem(item.text, item.file or str(path), key=item.key) for item in error.problems]) from None


def write_robot_project(kind: str, picked: PickedLeg, source: str, folder: Path, doubts: Sequence[str] = ()) -> None:
    """The leg, a project of that kind, and a README on missing recordings and omitted features.

    ``doubts`` : sentences on numbers of the leg to check.

    Raises
    ------
    UserError
        If the robot's leg is none that a project reads.
    """
    (folder / ("animal" if kind == "leg" else "trials")).mkdir(parents=True)
    write_leg(picked.leg, folder / LEG_FILE)
    try:
        read_leg(folder / LEG_FILE)
    except UserError as error:
        text = "gives a leg that no project can use:"
        last = picked.leg.joints[-1]
        end = f"; --tip gives the last link another length than {1e3 * last.link.length:.3g} mm"
        own = f"joints.{last.name}.link."
        problems = [
            Problem(f"{text} {item.text}{end if (item.key or '').startswith(own) else ''}", source, key=item.key)
            for item in error.problems
        ]
        raise UserError(problems) from None
    header = ",".join(["time [s]", *(f"{name} [rad]" for name in picked.leg.joint_names)])
    write_text(place(folder, f"{PROJECT_NAMES[kind]}.yaml"), _PROJECTS[kind](picked.leg, source))
    lost = "".join(f"- {text}\n" for text in picked.messages) or "- nothing\n"
    check = "\n## To check\n\n" + "".join(f"- {text}\n" for text in doubts) if doubts else ""
    write_text(
        folder / "README.md",
        f"# {picked.leg.name}\n\n"
        f"`{LEG_FILE}` is the planar leg of {', '.join(picked.leg.joint_names)} out of `{source}`. Its measured angles "
        "are that\nrobot's joint readings.\n\n"
        f"## To add\n\n{_RECORDINGS[kind]}, a CSV each with the header\n\n    {header}\n\n"
        f"(or `[deg]`). {_TO_ADD[kind]}Then\n\n    synth {kind} {PROJECT_NAMES[kind]}.yaml --out result\n\n"
        f"## What the leg does not hold\n\n{lost}{check}",
    )


def _fit(leg: Leg, source: str) -> str:
    return f"""# Springs, dampers and free angles of {source}'s leg from recordings of its free swings.
kind: fit
leg: {LEG_FILE}
trials:
  - {SMALLEST_READING}
free_angle: auto
"""


def _gap(leg: Leg, source: str) -> str:
    return f"""# Why the built leg moves differently from {source}.
kind: gap
leg: {LEG_FILE}
trials:
  - {SMALLEST_READING}          # {{file: check.csv, held_out: true}} for one that only scores
tolerance: {{length: 0.5 %, mass: 1 %, com: 1 %, inertia: 2 %, spring: 3 %, damper: 5 %, free_angle: 0.5 deg}}
"""


def _leg(leg: Leg, source: str) -> str:
    names = ", ".join(leg.joint_names)
    return f"""# Springs and dampers with which {source}'s leg moves like an animal's.
kind: leg-design
source: {{leg: animal/animal.leg.yaml, trials: [animal/*.csv]}}    # the animal's leg, joints named {names}
scale: {{time: froude}}
target: {LEG_FILE}
"""


PROJECT_NAMES = {"fit": "fit", "gap": "gap", "leg": "leg-design"}
_PROJECTS = {"fit": _fit, "gap": _gap, "leg": _leg}
_RECORDINGS = {
    "fit": "Recordings of the moving leg in `trials/`",
    "gap": "Recordings of the moving leg in `trials/`",
    "leg": "The animal's leg file `animal/animal.leg.yaml`, its joints named as the robot's,\nand recordings of the "
    "animal in `animal/`",
}
_TO_ADD = {
    "fit": "",
    "gap": "For a joint that swings freely write in the leg file: `damper: {rate: 0 N*m*s/rad}`. ",
    "leg": "`synth import` makes both: its leg file is `leg.leg.yaml`, its recordings are in `trials/`. ",
}
