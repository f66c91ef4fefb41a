"""A joint's reading is shifted."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.swing.effects.definition import Effect, Parameter, Prior, Shape
from synth.swing.lane_layout import CONTROLLED

if TYPE_CHECKING:
    from synth.arrays import Array


# Of an error of a reading, whether it is inside a servo's loop.
BY_SERVO = Parameter(
    "controlled",
    "1",
    0.0,
    natural=False,
    label="angle controlled",
    choices=("the true angle", "this reading"),
    meaning="1: the joint's servo controls this reading; 0: the true angle, by another sensor",
)


def read(time: Array, rotation: Array, rate: Array, sign: int, zero: float, offset: Array, controlled: Array) -> Array:
    """The rotation that is read; ``offset`` (n_lane,) rad in measured angle."""
    return rotation + sign * offset


def control(controlled_by: Array, joint: int, sign: int, zero: float, offset: Array, controlled: Array) -> None:
    """Shift what the joint's servo controls by, ``controlled_by`` (3, n, n_lane), where it is this reading."""
    controlled_by[CONTROLLED.index("controlled_offset"), joint] += sign * controlled * offset


EFFECT = Effect(
    name="encoder_offset",
    meaning="a joint's reading is shifted",
    phrase="has an encoder that is shifted",
    formula="reading = angle + offset",
    source="definition",
    way="reading",
    shows_locked=True,
    parameters=(
        Parameter(
            "offset",
            "rad",
            prior=Prior(0.0, 0.08),
            natural=False,
            meaning="by which the reading is too high",
            form="change",
        ),
        BY_SERVO,
    ),
    strengths=("offset",),
    controls="control",
    shapes=(
        Shape(("offset",), {"controlled": 0.0}),
        Shape(("offset",), {"controlled": 1.0}, needs=("servo",)),
    ),
)
