"""Inertia that turns with the joint, a rotor behind its gear or a pulley: more or less of it than stated."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from synth.swing.effects.definition import Effect, Parameter, Shape, signed

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes


def change(legs: LegLanes, joint: int, sign: int, inertia: Array) -> None:
    """Add ``inertia`` (n_lane,) kg m^2, limited so that the sum is not negative.

    Of a rotor it is its inertia times the gear ratio squared.
    """
    legs.armature[joint] = np.maximum(legs.armature[joint] + inertia, 0.0)


EFFECT = Effect(
    name="armature",
    meaning="another inertia that turns with the joint (rotor, gear) than the design's",
    phrase="turns another inertia of its own",
    formula="mass matrix in joint coordinates + inertia on the joint's diagonal, there at least 0",
    source="Featherstone, Rigid Body Dynamics Algorithms (2008), section 9.6; MuJoCo's joint attribute of this name",
    way="leg",
    changes="`armature` of the joint",
    parameters=(
        Parameter(
            "inertia",
            "kg*m^2",
            prior=signed(0.3),
            meaning="excess of all parts that turn with the joint",
            label="change of inertia",
            form="change",
        ),
    ),
    strengths=("inertia",),
    shapes=(
        Shape(("inertia",), {}, needs=("no armature",)),
        Shape(("inertia",), {}, ({}, {"inertia": -0.2}), needs=("armature",)),
    ),
)
