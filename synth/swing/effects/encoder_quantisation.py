"""An encoder with coarse counts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from synth.swing.effects.definition import Effect, Parameter, size

if TYPE_CHECKING:
    from synth.arrays import Array


def read(time: Array, rotation: Array, rate: Array, sign: int, zero: float, step: Array) -> Array:
    """The measured angle ``zero + sign q`` rounded to multiples of ``step`` (n_lane,) rad; 0: not rounded."""
    width = np.where(step > 0.0, step, 1.0)
    measured = rotation + sign * zero
    return np.where(step > 0.0, np.round(measured / width) * width - sign * zero, rotation)


EFFECT = Effect(
    name="encoder_quantisation",
    meaning="coarse counts",
    phrase="has an encoder with coarse counts",
    formula="reading = step round(angle / step)",
    source="Widrow & Kollar, Quantization Noise (2008), ch. 1: error step / sqrt(12)",
    way="reading",
    parameters=(Parameter("step", "rad", prior=size(0.02), natural=False, meaning="one count"),),
    strengths=("step",),
    shapes=(),
)
