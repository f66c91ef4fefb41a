"""Inertia that turns with the joint: a rotor behind its gear, a pulley."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.swing.effects.definition import Effect, Parameter, Shape, size

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes


def change(legs: LegLanes, joint: int, sign: int, inertia: Array) -> None:
    """Add ``inertia`` (n_lane,) kg m^2: the rotor's inertia times the gear ratio squared."""
    legs.armature[joint] += inertia


EFFECT = Effect(
    name="armature",
    meaning="inertia that turns with the joint (rotor, gear)",
    phrase="turns inertia of its own",
    formula="mass matrix in joint coordinates + inertia on the joint's diagonal",
    source="Featherstone, Rigid Body Dynamics Algorithms (2008), section 9.6; MuJoCo's joint attribute of this name",
    way="leg",
    parameters=(Parameter("inertia", "kg*m^2", prior=size(0.3), meaning="of all parts that turn with the joint"),),
    strengths=("inertia",),
    shapes=(Shape(("inertia",), {}),),
)
