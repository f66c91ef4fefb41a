"""A spring rate that increases or decreases with deflection."""

from __future__ import annotations

from math import sqrt

import numpy as np

from synth.arrays import Array
from synth.swing.effects.definition import Effect, Parameter, Prior, Shape, SimplerEffect, signed, size
from synth.swing.effects.inlined import inlined, power
from synth.swing.leg_model import Leg

# Of the spring's rate, by which it may change at once at an onset. A bumper beside a spring is of its size; what is
# several times as stiff is no part of the spring but a stop, whose torque is the same while the joint is pressed on it.
STEEPEST = 4.0


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
    stiffening,
    exponent,
    reach,
    onset,
    softening,
):
    """An odd power of the deflection beyond the onset, plus the deficit k u - k u / sqrt(1 + (softening u)^2)."""
    beyond = (max(abs(deflection) - onset, 0.0) + 1e-9) / reach
    extra = stiffening * power(beyond, exponent)
    lost = spring_rate * deflection * (1.0 - 1.0 / sqrt(1.0 + (softening * deflection) ** 2))
    return lost - (extra if deflection > 0.0 else -extra), 0.0


def bounded(leg: Leg, joint: int, slowest: float, values: Array) -> Array:
    """Parameters (n_parameter, n_lane), the rate beyond an onset at most ``STEEPEST`` times the spring's more."""
    found, spring = values.copy(), leg.joints[joint].spring
    stiffening, exponent, reach, onset, _ = found
    most = STEEPEST * (spring.rate if spring is not None else np.inf) * reach
    found[0] = np.where((exponent == 1.0) & (onset > 0.0), np.minimum(stiffening, most), stiffening)
    return found


EFFECT = Effect(
    name="hardening_spring",
    meaning="a stiffness that grows (or falls) with deflection",
    phrase="has a spring whose rate changes with deflection",
    needs=("spring",),
    formula="-stiffening sign(u) ((|u| - onset) / reach)^exponent, u the deflection; k u / sqrt(1 + (softening u)^2)",
    source="G. Duffing, Erzwungene Schwingungen (1918): exponent 3; bumper: exponent 1 with an onset",
    way="torque",
    belongs_to="spring",
    parameters=(
        Parameter(
            "stiffening", "N*m", prior=signed(0.4), meaning="extra torque at reach; negative: softening", form="change"
        ),
        Parameter("exponent", "1", 3.0, Prior(3.0, 1.0, lower=1.0, upper=7.0), off=3.0, natural=False),
        Parameter(
            "reach", "rad", 1.0, off=1.0, above=0.0, meaning="deflection beyond the onset to which stiffening refers"
        ),
        Parameter("onset", "rad", 0.0, Prior(0.0, 0.4, lower=0.0, upper=0.9), meaning="deflection where it begins"),
        Parameter("softening", "1/rad", 0.0, size(1.0), meaning="1 over the deflection at which the spring softens"),
    ),
    stated=("stiffening", "softening", "onset", "reach", "exponent"),
    strengths=("stiffening", "softening"),
    bounds="bounded",
    becomes=(SimplerEffect("spring_rate", {"exponent": 1.0, "onset": 0.0, "softening": 0.0}),),
    shapes=(
        Shape(("stiffening", "exponent"), {"reach": 1.0}, ({"exponent": 2.0}, {"exponent": 3.5})),
        Shape(("stiffening", "onset"), {"exponent": 1.0, "reach": 0.3}, ({"onset": 0.3}, {"onset": 0.6})),
        Shape(("softening",), {}, ({"softening": 0.3},)),
    ),
)
