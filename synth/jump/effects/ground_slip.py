"""Sliding foot: another ground friction than designed, usually less. Only a leaning jump needs friction."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.estimation.parameters import Parameter, Shape, positive
from synth.jump.effects.jump_effect import MotorEffect

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.jump.jump_lanes import JumpLanes


def change(jumps: JumpLanes, friction: Array) -> None:
    """Replace the design's coefficient, whose value is a guess, by ``friction`` if that is above 0."""
    jumps.ground_friction[:] = jumps.ground_friction * (friction <= 0.0) + friction


EFFECT = MotorEffect(
    name="ground_slip",
    meaning="the foot slides on the ground",
    phrase="lets the foot slide",
    formula="F = -friction N v / sqrt(v^2 + v_s^2)",
    source="Coulomb's law, regularised",
    place="base",
    leaning=True,
    parameters=(
        Parameter("friction", "1", 0.0, positive(0.15, 0.8, 0.005, 2.0), natural=False, meaning="coefficient"),
    ),
    strengths=("friction",),
    shapes=(Shape(("friction",), {}, ({"friction": 0.15}, {"friction": 0.06})),),
)
