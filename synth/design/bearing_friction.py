"""Dry friction of a joint's bearings and thrust washers, estimated by formulas with a source.

The frictional torque of a ball bearing is M = mu P d/2 with mu = 0.0015 for deep groove ball bearings without contact
seals (SKF, Rolling Bearings, 2016, p. 100, "Estimating the frictional moment"; Koyo gives 0.0010 to 0.0015). P is the
load on the bearing, d its bore. The starting torque may be twice that (roymech.org, Bearing Friction).

A thrust washer has the frictional torque mu F r at its mean radius r. A leg that swings in a vertical plane has no
axial load, so F is the axial component of the weight if the mount is one degree out of level. The grease of the shields
and the seal of a damper are not included.

The load P is the weight of everything below the joint, and half of the force of the deflected spring on the axis
(``cad.strength.axis_force``): half, because that force grows from zero with the deflection.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import radians, sin
from typing import Any

from synth.design.drawn_springs import simulate_built_leg
from synth.design.leg_design import LegDesign
from synth.units import quantity

BALL = 0.0015  # coefficient of friction of deep groove ball bearings (SKF)
SLIDING = 0.2  # steel washer on print, dry: the upper end of what nylon on steel is given, 0.1 to 0.2
OUT_OF_LEVEL = radians(1.0)  # estimate for a mount levelled by eye
EFFECT = "coulomb_friction"


@dataclass(frozen=True)
class BearingFriction:
    """Friction of one joint: loads (N) and torques (N*m)."""

    weight: float
    spring_force: float
    bearings: float
    washers: float

    @property
    def torque(self) -> float:
        """Total frictional torque, N*m."""
        return self.bearings + self.washers

    def as_json(self) -> dict[str, Any]:
        """For ``design.json``."""
        return {
            "torque": quantity(self.torque, "N*m"),
            "bearings": quantity(self.bearings, "N*m"),
            "thrust_washers": quantity(self.washers, "N*m"),
            "weight": quantity(self.weight, "N"),
            "spring_on_axis": quantity(self.spring_force, "N"),
            "basis": "M = 0.5 mu P d, mu = 0.0015 (SKF); thrust washers mu F r, mu = 0.2, F of a mount 1 deg off level",
        }


def friction_of(bore: float, washer: float, weight: float, spring_force: float) -> BearingFriction:
    """Friction of a shaft of ``bore`` m with thrust washers of outer diameter ``washer`` m; loads in N."""
    load = weight + spring_force
    rubbing = weight * sin(OUT_OF_LEVEL)
    return BearingFriction(weight, spring_force, BALL * load * bore / 2, SLIDING * rubbing * (bore + washer) / 4)


def bearing_friction(design: LegDesign) -> dict[str, BearingFriction]:
    """Estimated friction of every drawn joint; empty if nothing is drawn."""
    if design.drawn is None:
        return {}
    from synth.cad.checked_layout import lay_out
    from synth.cad.strength import axis_force

    leg, found = design.built, {}
    for j, dimensions in enumerate(design.drawn.dimensions.joints):
        weight = leg.gravity * sum(joint.link.mass for joint in leg.joints[j:])
        force = 0.0
        if dimensions.spring_torque > 0.0:
            force = 0.5 * dimensions.springs * axis_force(dimensions, lay_out(dimensions))
        hardware = dimensions.hardware
        washer = hardware.washer.outer_diameter
        found[dimensions.name] = friction_of(hardware.bearing.bore * 1e-3, washer * 1e-3, weight, force)
    return found


def with_friction(design: LegDesign, found: Mapping[str, BearingFriction]) -> LegDesign:
    """The design with bearing friction in its built leg, at joints whose file states no dry friction."""
    joints = []
    for joint in design.built.joints:
        if joint.name in found and EFFECT not in joint.effects:
            effect = {EFFECT: {"torque": found[joint.name].torque}}
            joint = replace(joint, effects={**joint.effects, **effect})
        joints.append(joint)
    if tuple(joints) == design.built.joints:
        return design
    return simulate_built_leg(replace(design, built=replace(design.built, joints=tuple(joints))))


def with_friction_notes(extra: dict[str, Any], found: Mapping[str, BearingFriction]) -> dict[str, Any]:
    """``extra`` with each joint's friction in ``solids.joints`` and a note on it."""
    if not found:
        return extra
    solids = dict(extra["solids"])
    joints = {name: {**item, "friction": found[name].as_json()} if name in found else item
              for name, item in solids["joints"].items()}  # fmt: skip
    listed = ", ".join(f"{name} {item.torque * 1e3:.2g} N*mm" for name, item in found.items())
    note = (
        f"the estimated friction of bearings and thrust washers is {listed} (M = 0.5 mu P d with mu = 0.0015, SKF; up "
        "to twice that at the start of a motion). built.leg.yaml has it as dry friction, without the damper's seal"
    )
    return {**extra, "solids": {**solids, "joints": joints, "notes": [*solids["notes"], note]}}
