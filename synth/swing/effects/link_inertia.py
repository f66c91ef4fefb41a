"""Mass distribution: a link's centre of mass or its inertia is off."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.swing.effects.definition import Effect, Parameter, Prior, Shape

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes


def change(legs: LegLanes, joint: int, sign: int, com: Array, inertia: Array) -> None:
    """Move the centre of mass by a share of its distance, and scale the inertia about it; both (n_lane,)."""
    legs.com[joint] *= 1.0 + com
    legs.com_across[joint] *= 1.0 + com
    legs.inertia[joint] *= 1.0 + inertia


EFFECT = Effect(
    name="link_inertia",
    meaning="mass distribution: centre of mass or inertia off",
    phrase="carries a link whose mass lies elsewhere",
    formula="com (1 + com share), inertia about it (1 + inertia share)",
    source="definition",
    way="leg",
    changes="`com`, `com_across` and `inertia` of `link:`",
    shows_locked=True,
    parameters=(
        Parameter(
            "com",
            "1",
            0.0,
            Prior(0.0, 0.15, lower=-0.9, upper=2.0),
            natural=False,
            meaning="relative excess of com",
            label="change of com",
            form="relative change",
        ),
        Parameter(
            "inertia",
            "1",
            0.0,
            Prior(0.0, 0.4, lower=-0.9, upper=5.0),
            natural=False,
            meaning="relative excess of inertia",
            label="change of inertia",
            form="relative change",
        ),
    ),
    strengths=("com", "inertia"),
    shapes=(Shape(("com", "inertia"), {}),),
)
