"""The free angle of a spring differs from the design."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.swing.effects.definition import Effect, Parameter, Prior, Shape

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes


def change(legs: LegLanes, joint: int, sign: int, shift: Array) -> None:
    """Shift the free angle by ``shift`` (n_lane,) rad in measured angle."""
    legs.rest[joint] += sign * shift


EFFECT = Effect(
    name="spring_preload",
    meaning="the free angle differs from the design",
    phrase="has its free angle elsewhere",
    needs=("spring",),
    formula="free angle + shift",
    source="definition",
    way="leg",
    changes="`free_angle` of `spring:`",
    belongs_to="spring",
    parameters=(
        Parameter(
            "shift", "rad", prior=Prior(0.0, 0.12), natural=False, meaning="of the free angle, measured", form="change"
        ),
    ),
    strengths=("shift",),
    shapes=(Shape(("shift",), {}),),
)
