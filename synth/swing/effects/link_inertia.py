"""Mass distribution: a link's centre of mass or its inertia is off."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.swing.effects.definition import Effect, Parameter, Prior, Shape, signed

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes


def change(legs: LegLanes, joint: int, sign: int, com: Array, inertia: Array, across: Array) -> None:
    """Move the centre of mass by shares of its distance and, across, of the link's length; scale the inertia about it.

    All (n_lane,).
    """
    legs.com[joint] *= 1.0 + com
    legs.com_across[joint] = legs.com_across[joint] * (1.0 + com) + across * legs.length[joint]
    legs.inertia[joint] *= 1.0 + inertia


EFFECT = Effect(
    name="link_inertia",
    meaning="mass distribution: centre of mass or inertia off",
    phrase="carries a link whose mass lies elsewhere",
    formula="com (1 + com share), com_across + across times the link's length, inertia about it (1 + inertia share)",
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
        Parameter(
            "across",
            "1",
            0.0,
            signed(0.1, 0.5),
            natural=False,
            meaning="how much farther beside the link's line, share of its length; positive: right of a link that "
            "hangs down",
            label="shift beside the line over the link's length",
            form="relative change",
        ),
    ),
    strengths=("com", "inertia", "across"),
    shapes=(Shape(("com", "inertia"), {}), Shape(("com", "inertia", "across"), {})),
)
