"""The free angle is not where the design has it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.swing.effects.definition import Effect, Parameter, Prior, Shape

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes


def change(legs: LegLanes, joint: int, sign: int, shift: Array) -> None:
    """Shift the rest; ``shift`` (n_lane,) rad in measured angle."""
    legs.rest[joint] += sign * shift


EFFECT = Effect(
    name="spring_preload",
    meaning="the free angle is not where the design has it",
    phrase="has its free angle elsewhere",
    needs=("spring",),
    formula="free angle + shift",
    source="definition",
    way="leg",
    belongs_to="spring",
    parameters=(
        Parameter("shift", "rad", prior=Prior(0.0, 0.12), natural=False, meaning="of the free angle, measured"),
    ),
    strengths=("shift",),
    shapes=(Shape(("shift",), {}),),
)
