"""The built leg as MJCF, URDF and SDF: inertias of its links with all parts on them, drawn parts as visuals, stops."""

from __future__ import annotations

from collections.abc import Sequence
from math import radians
from pathlib import Path

from synth.design.leg_design import LegDesign, fastest_rates
from synth.design.part_masses import PartMass
from synth.files.mjcf import write_mjcf
from synth.files.robot_bodies import RobotLink, Visual
from synth.files.robot_xml import write_robot_files
from synth.swing.rigid_body import Vector


def write_robots(design: LegDesign, masses: Sequence[PartMass], folder: Path) -> list[str]:
    """Write ``leg.mjcf.xml``, ``leg.urdf`` and ``leg.sdf``; returns what URDF and SDF do not hold."""
    times = [release.time for release in design.wanted.releases]
    fastest = fastest_rates(design.built_motions, times)
    base, links = _base(design, masses, folder), _links(design, masses, folder)
    write_mjcf(design.built, fastest, folder / "leg.mjcf.xml", base, links)
    return write_robot_files(design.built, fastest, folder, base, links)


def _base(design: LegDesign, masses: Sequence[PartMass], folder: Path) -> RobotLink:
    """What hangs from the body: the first joint's upper half."""
    first = design.built.joint_names[0]
    return RobotLink(None, _shown(masses, first, ("upper", "spring"), 0.0, (0.0, 0.0, 0.0), folder))


def _links(design: LegDesign, masses: Sequence[PartMass], folder: Path) -> tuple[RobotLink, ...]:
    if design.drawn is None:
        return tuple(RobotLink() for _ in design.built.joints)
    found = []
    for index, (drawn, built) in enumerate(zip(design.drawn.dimensions.joints, design.links, strict=True)):
        # Files show the lower half's parts turned to the free angle; a link's frame has them straight.
        turn = -radians(drawn.rotation(drawn.free_angle))
        shown = _shown(masses, drawn.name, ("lower",), turn, (0.0, 0.0, 0.0), folder)
        if index + 1 < len(design.built.joints):
            end = (0.0, -built.assumed.length, 0.0)
            shown += _shown(masses, design.built.joint_names[index + 1], ("upper", "spring"), 0.0, end, folder)
        found.append(RobotLink(built.body, shown))
    return tuple(found)


def _shown(
    masses: Sequence[PartMass], joint: str, groups: tuple[str, ...], turn: float, shift: Vector, folder: Path
) -> tuple[Visual, ...]:
    """Parts of a joint that were exported; a spring is shown as it hangs from the upper half, unloaded."""
    from synth.cad.parts import COLOURS

    return tuple(
        Visual(item.part, f"parts/{item.part}.stl", turn, shift, COLOURS[item.family])
        for item in masses
        if item.joint == joint and item.moves_with in groups and (folder / "parts" / f"{item.part}.stl").is_file()
    )
