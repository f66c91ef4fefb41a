"""One leg for several simulators: MJCF, URDF, SDF and a USD layer, with the omissions of each."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from synth.arrays import Array
from synth.files.mjcf import mjcf_text
from synth.files.mjcf_omissions import mjcf_omissions
from synth.files.output import write_text
from synth.files.robot_usd import usd_file
from synth.files.robot_xml import sdf_file, urdf_file
from synth.swing.leg_model import Leg


def write_simulator_files(
    leg: Leg,
    fastest: Array,
    folder: Path,
    instead: Leg | None = None,
    told: Sequence[str] = (),
    driven: Sequence[str] = (),
    deflected: Array | None = None,
) -> dict[str, tuple[str, ...]]:
    """Write ``leg.mjcf.xml``, ``leg.urdf``, ``leg.sdf``, ``leg.usda`` and ``README.md``; file -> its omissions.

    ``fastest`` : (n,) rad/s, speed up to which each damper is represented; ``deflected`` : (n,) rad, likewise of each
    spring, see ``joint_laws``. ``instead`` : the leg for formats with dry friction (USD has none), where it has
    friction that they lack; ``told`` : what stands for what in it. ``driven`` : the error that MuJoCo's actuators
    leave.
    """
    folder.mkdir(parents=True, exist_ok=True)
    near = leg if instead is None else instead
    write_text(folder / "leg.mjcf.xml", mjcf_text(near, fastest, notes=(*told, *driven), deflected=deflected))
    lost = {"leg.mjcf.xml": (*told, *mjcf_omissions(near, fastest, deflected), *driven)}
    for name, made, notes in (
        ("leg.urdf", urdf_file(near, fastest), told),
        ("leg.sdf", sdf_file(near, fastest), told),
        ("leg.usda", usd_file(leg, fastest), ()),
    ):
        write_text(folder / name, made.text)
        lost[name] = (*notes, *made.warnings)
    write_text(folder / "README.md", _readme(leg, lost))
    return lost


def _readme(leg: Leg, lost: dict[str, tuple[str, ...]]) -> str:
    lines = [f"# {leg.name}", "", "The same leg for several simulators. Omissions of each file:", ""]
    for name, notes in lost.items():
        lines += [f"- `{name}`: {'nothing is lost' if not notes else ''}", *(f"  - {text}" for text in notes)]
    lines += [
        "",
        "`leg.usda` is a layer of joint and mass parameters: import `leg.urdf` into Isaac Sim and add it on top.",
    ]
    return "\n".join(line.rstrip() for line in lines) + "\n"
