"""A joint's reading is shifted."""

from __future__ import annotations

from typing import TYPE_CHECKING

from synth.swing.effects.definition import Effect, Parameter, Prior, Shape

if TYPE_CHECKING:
    from synth.arrays import Array


def read(time: Array, rotation: Array, rate: Array, sign: int, zero: float, offset: Array) -> Array:
    """The rotation that is read; ``offset`` (n_lane,) rad in measured angle."""
    return rotation + sign * offset


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
    ),
    strengths=("offset",),
    shapes=(Shape(("offset",), {}),),
)
