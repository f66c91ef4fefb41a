"""From a chosen design to the dimensions that ``cad`` draws."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil, degrees, floor
from typing import TYPE_CHECKING, Any

import numpy as np

from synth.design.leg_design import LegDesign
from synth.errors import Problem, UserError
from synth.model.mechanics import rest_pose

if TYPE_CHECKING:
    from cad import JointDimensions, LegDimensions

MARGIN = 5.0  # deg, of travel drawn beyond what the leg does where the leg file gives no range


@dataclass(frozen=True)
class Solids:
    """Dimensions of all joints that can be drawn, and a sentence for each thing that was assumed or left out."""

    dimensions: LegDimensions
    notes: tuple[str, ...]


def dimensions_of(design: LegDesign) -> Solids:
    """Dimensions of the built leg's joints; the pose drawn is where the leg rests."""
    import cad

    notes: list[str] = []
    pose = np.degrees(design.built.to_measured(rest_pose(design.built)))
    joints = [_joint(design, j, float(pose[j]), notes) for j in range(len(design.built.joints))]
    return Solids(
        cad.LegDimensions(design.project.name[:60], tuple(joints), tilt=degrees(design.built.tilt)), tuple(notes)
    )


def _joint(design: LegDesign, j: int, rest: float, notes: list[str]) -> JointDimensions:
    import cad

    joint, options = design.built.joints[j], design.project.cad
    assert joint.spring is not None
    low, high = _range(design, j, rest)
    dimensions = cad.JointDimensions(
        name=joint.name,
        spring=_spring(design, j, notes),
        free_angle=degrees(joint.spring.free_angle),
        rest_angle=rest,
        range=(low, high),
        zero_angle=degrees(joint.zero),
        sign=joint.sign,
        damper=_damper(design, j, notes),
        link_length=joint.link.length * 1e3,
        shaft_diameter=options.shaft_diameter * 1e3,
        clearance=options.clearance * 1e3,
        wall=options.wall * 1e3,
    )
    turned = replace(dimensions, upper_arm_angle=cad.clear_upper_arm_angle(dimensions))
    if turned.upper_arm_angle != 0.0:
        notes.append(
            f"{joint.name}: over this travel the upper arm cannot lie where the angle is measured from; it is drawn at "
            f"{turned.upper_arm_angle:+.0f} deg from there, and the lower arm's shaft at {turned.arm_offset:+.1f} deg"
        )
    return turned


def _range(design: LegDesign, j: int, rest: float) -> tuple[float, float]:
    """The leg file's range, else what the wanted and the built leg do with a margin; deg."""
    joint = design.built.joints[j]
    if joint.range is not None:
        low, high = (degrees(angle) for angle in joint.range)
        return min(low, rest), max(high, rest)
    motions = [*design.wanted.motions, *design.built_motions]
    angles = np.degrees(np.concatenate([design.built.to_measured(motion)[:, j] for motion in motions]))
    return floor(min(angles.min(), rest) - MARGIN), ceil(max(angles.max(), rest) + MARGIN)


def _spring(design: LegDesign, j: int, notes: list[str]) -> Any:
    import cad

    option, name = design.springs.chosen[j], design.built.joint_names[j]
    if option.row is not None:
        row = option.row
        if row.wire_diameter is None or row.mean_diameter is None or row.body_coils is None:
            text = f"{row.part} ({row.place}) cannot be drawn: {row.status}; leave the solids out with --no-cad"
            raise UserError(Problem(text, str(design.project.path), key=f"select.joints.{name}.spring"))
        hand = row.hand or "right"
        if not row.hand:
            notes.append(f"{name}: the catalogue does not say which way {row.part} is wound; drawn right-hand")
        return cad.SpringDimensions(
            row.wire_diameter * 1e3, row.mean_diameter * 1e3, row.body_coils, degrees(option.included_angle), hand=hand
        )
    made = option.design
    assert made is not None
    if made.count > 1:
        notes.append(f"{name}: {made.count} springs stand side by side; one is drawn, and the pocket is for one")
    return cad.SpringDimensions(
        made.wire_diameter * 1e3, made.mean_diameter * 1e3, made.body_coils, degrees(made.included_angle)
    )


def _damper(design: LegDesign, j: int, notes: list[str]) -> Any:
    import cad

    row, name = design.dampers.chosen[j].row, design.built.joint_names[j]
    default = cad.DamperDimensions()
    diameter = row.outer_diameter * 1e3 if row is not None and row.outer_diameter is not None else None
    if diameter is None:
        notes.append(
            f"{name}: the catalogue does not give the damper's size; the bracket is drawn for "
            f"{default.outer_diameter:g} mm across and screws on a circle of {default.bolt_circle:g} mm. Measure yours"
        )
        return default
    return cad.DamperDimensions(outer_diameter=diameter, bolt_circle=diameter + 10.0)
