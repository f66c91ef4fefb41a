"""The built leg as MJCF, URDF and SDF: links with the inertia of all their parts, drawn parts as visuals, stops."""

from __future__ import annotations

from collections.abc import Sequence
from math import radians
from pathlib import Path

import numpy as np

from synth.design.leg_design import LegDesign, fastest_rates
from synth.design.part_masses import PartMass
from synth.files.mjcf import write_mjcf
from synth.files.mjcf_omissions import mjcf_omissions
from synth.files.robot_bodies import RobotLink, Visual
from synth.files.robot_xml import write_robot_files
from synth.remarks import noted
from synth.swing.rigid_body import Vector


def write_robots(design: LegDesign, masses: Sequence[PartMass], folder: Path) -> list[str]:
    """Write ``leg.mjcf.xml``, ``leg.urdf`` and ``leg.sdf``; return sentences on what each lacks."""
    times = [release.time for release in design.wanted.releases]
    fastest = fastest_rates(design.built_motions, times)
    base, links = _base(design, masses, folder), _links(design, masses, folder)
    deflected = np.max([np.abs(motion - design.built.rest).max(axis=0) for motion in design.built_motions], axis=0)
    write_mjcf(design.built, fastest, folder / "leg.mjcf.xml", base, links, deflected)
    lost = mjcf_omissions(design.built, fastest, deflected)
    said = [noted(f"leg.mjcf.xml does not represent all of the leg: {'; '.join(lost)}")] if lost else []
    return said + write_robot_files(design.built, fastest, folder, base, links)


def _base(design: LegDesign, masses: Sequence[PartMass], folder: Path) -> RobotLink:
    """The base link: the first joint's upper half, which is fixed to the body."""
    first = design.built.joint_names[0]
    return RobotLink(None, _exported_parts(masses, first, ("upper", "spring"), 0.0, (0.0, 0.0, 0.0), folder))


def _links(design: LegDesign, masses: Sequence[PartMass], folder: Path) -> tuple[RobotLink, ...]:
    if design.drawn is None:
        return tuple(RobotLink() for _ in design.built.joints)
    found = []
    for index, (drawn, built) in enumerate(zip(design.drawn.dimensions.joints, design.links, strict=True)):
        # The files have the lower half's parts at their own angle; in a link's frame they are at angle 0.
        turn = -radians(drawn.rotation(drawn.filed_angle))
        shown = _exported_parts(masses, drawn.name, ("lower",), turn, (0.0, 0.0, 0.0), folder)
        if index + 1 < len(design.built.joints):
            end = (0.0, -built.assumed.length, 0.0)
            shown += _exported_parts(masses, design.built.joint_names[index + 1], ("upper", "spring"), 0.0, end, folder)
        found.append(RobotLink(built.body, shown))
    return tuple(found)


def _exported_parts(
    masses: Sequence[PartMass], joint: str, groups: tuple[str, ...], turn: float, shift: Vector, folder: Path
) -> tuple[Visual, ...]:
    """Exported parts of a joint; the spring is unloaded and fixed to the upper half."""
    from synth.cad.parts import COLOURS

    return tuple(
        Visual(item.part, f"parts/{item.part}.stl", turn, shift, COLOURS[item.family])
        for item in masses
        if item.joint == joint and item.moves_with in groups and (folder / "parts" / f"{item.part}.stl").is_file()
    )
