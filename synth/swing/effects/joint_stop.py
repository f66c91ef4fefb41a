"""Contact at the end of travel.

The contact torque begins at zero, so no event is located. At a tolerance of 1e-6 a bounce is within 2e-5 rad of one
with located contacts (``tests/swing/effects``).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from synth.swing.effects.definition import Effect, Parameter, Prior, Shape, positive
from synth.swing.effects.inlined import inlined, power

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_model import Leg

FAR = 1e3  # rad: beyond any motion
SOFTEST = 1.0  # of the joint's own stiffness (spring and gravity): what yields more does not end the travel
PLACES = (0.97, 0.9, 0.8, 0.65, 0.45)  # of half the range of motion from its middle: starting values of a stop's angle


@inlined
def torque(  # type: ignore[no-untyped-def]
    rotation,
    rate,
    deflection,
    spring_rate,
    damper_rate,
    damper_torque,
    force,
    memory,
    upper,
    lower,
    stiffness,
    damping,
    exponent,
    depth,
):
    """A power of the penetration at either end, with a damping that grows with it; the contact never pulls."""
    above = rotation - upper
    below = lower - rotation
    deep = max(max(above, below), 0.0) + 1e-12
    closing = rate if above > 0.0 else -rate
    push = stiffness * depth * power(deep / depth, exponent) * max(1.0 + damping * closing, 0.0)
    return (-push if above > 0.0 else push) if deep > 2e-12 else 0.0, 0.0


def to_rotation(sign: int, zero: float, upper: float, lower: float) -> tuple[float, float]:
    """Convert ends of travel from measured angles to rotations."""
    ends = (sign * (upper - zero), sign * (lower - zero))
    return (ends[0], ends[1]) if sign > 0 else (ends[1], ends[0])


def bounded(leg: Leg, joint: int, slowest: float, values: Array) -> Array:
    """The parameters (n_parameter, n_lane) with ends that do not cross: one that is searched takes the other along.

    It may start beyond an end that the leg file states. Crossed ends push everywhere, so stiffly that no search ends.
    """
    found = values.copy()
    found[1] = np.minimum(values[0], values[1])
    return found


EFFECT = Effect(
    name="joint_stop",
    meaning="contact at the end of travel",
    phrase="meets a stop",
    formula="-stiffness depth (x / depth)^exponent max(0, 1 + damping dx/dt) at depth x, mirrored at the other end",
    source="Hunt & Crossley, J. Applied Mechanics 42 (1975) 440",
    way="torque",
    parameters=(
        Parameter(
            "upper",
            "rad",
            FAR,
            Prior(0.8, 0.3),
            off=FAR,
            anchor="middle",
            meaning="end of travel above, measured angle",
        ),
        Parameter(
            "lower",
            "rad",
            -FAR,
            Prior(-0.8, 0.3),
            off=-FAR,
            anchor="middle",
            meaning="end of travel below, measured angle",
        ),
        Parameter("stiffness", "N*m/rad", prior=positive(8.0, 1.5, SOFTEST), meaning="torque at depth over depth"),
        Parameter(
            "damping", "s/rad", 0.0, positive(1.0, 1.5), meaning="relative increase of the torque per rad/s of closing"
        ),
        Parameter("exponent", "1", 1.0, Prior(1.2, 0.3, lower=1.0, upper=2.5), off=1.0, natural=False),
        Parameter("depth", "rad", 0.05, off=0.05, above=0.0, meaning="penetration to which the stiffness refers"),
    ),
    strengths=("stiffness",),
    ascending=("lower", "upper"),
    any_of=("upper", "lower"),
    bounds="bounded",
    shapes=tuple(
        Shape(
            (end, "stiffness", "damping", "exponent"),
            {"depth": 0.1},
            tuple({end: side * place, "stiffness": stiffness} for place in PLACES for stiffness in (8.0, 40.0)),
        )
        for end, side in (("upper", 1.0), ("lower", -1.0))
    ),
)
