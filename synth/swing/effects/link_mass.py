"""A link that is heavier or lighter than designed, with its inertia in proportion."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.swing.effects.definition import Effect, Parameter, Prior, Shape

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes


def change(legs: LegLanes, joint: int, sign: int, share: Array) -> None:
    """Scale mass and inertia of the joint's link by 1 + ``share`` (n_lane,)."""
    legs.mass[joint] *= 1.0 + share
    legs.inertia[joint] *= 1.0 + share


EFFECT = Effect(
    name="link_mass",
    meaning="a link heavier or lighter than designed, its inertia in proportion",
    phrase="carries a link of another mass",
    formula="mass (1 + share), inertia (1 + share)",
    source="definition",
    way="leg",
    changes="`mass` and `inertia` of `link:`",
    shows_locked=True,
    parameters=(
        Parameter(
            "share",
            "1",
            prior=Prior(0.0, 0.2, lower=-0.8, upper=3.0),
            natural=False,
            meaning="relative excess of mass and inertia",
            label="change of mass",
            form="relative change",
        ),
    ),
    strengths=("share",),
    shapes=(Shape(("share",), {}),),
)
