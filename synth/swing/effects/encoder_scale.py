"""A joint's reading is scaled about its zero reading."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.swing.effects.definition import Effect, Parameter, Prior, Shape
from synth.swing.effects.encoder_offset import BY_SERVO

if TYPE_CHECKING:
    from synth.arrays import Array


def read(time: Array, rotation: Array, rate: Array, sign: int, zero: float, error: Array, controlled: Array) -> Array:
    """The rotation that is read, with relative ``error`` (n_lane,) of the measured angle ``zero + sign q``."""
    return rotation + error * (rotation + sign * zero)


def control(controlled_by: Array, joint: int, sign: int, zero: float, error: Array, controlled: Array) -> None:
    """Scale what the joint's servo controls by, ``controlled_by`` (3, n, n_lane), where it is this reading.

    What has shifted it before is scaled too.
    """
    _, scale, offset = controlled_by[:, joint]
    scale += (1.0 + scale) * controlled * error
    offset += (offset + sign * zero) * controlled * error


EFFECT = Effect(
    name="encoder_scale",
    meaning="a joint's reading is scaled about its zero reading (0 deg)",
    phrase="has an encoder with a wrong scale",
    formula="reading = angle (1 + error)",
    source="definition",
    way="reading",
    parameters=(
        Parameter(
            "error",
            "1",
            prior=Prior(0.0, 0.05, lower=-0.5, upper=0.5),
            natural=False,
            form="relative change",
            above=-1.0,
        ),
        BY_SERVO,
    ),
    strengths=("error",),
    controls="control",
    shapes=(
        Shape(("error",), {"controlled": 0.0}),
        Shape(("error",), {"controlled": 1.0}, needs=("servo",)),
    ),
)
