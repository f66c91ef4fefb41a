"""A joint's reading is scaled about its zero reading."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.swing.effects.definition import Effect, Parameter, Prior, Shape

if TYPE_CHECKING:
    from synth.arrays import Array


def read(time: Array, rotation: Array, rate: Array, sign: int, zero: float, error: Array) -> Array:
    """The rotation that is read, with relative ``error`` (n_lane,) of the measured angle ``zero + sign q``."""
    return rotation + error * (rotation + sign * zero)


EFFECT = Effect(
    name="encoder_scale",
    meaning="a joint's reading is scaled about its zero reading (0 deg)",
    phrase="has an encoder with a wrong scale",
    formula="reading = angle (1 + error)",
    source="definition",
    way="reading",
    parameters=(
        Parameter("error", "1", prior=Prior(0.0, 0.05, lower=-0.5, upper=0.5), natural=False, form="relative change"),
    ),
    strengths=("error",),
    shapes=(Shape(("error",), {}),),
)
