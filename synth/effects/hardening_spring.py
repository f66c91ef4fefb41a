"""A stiffness that grows, or falls, with deflection."""

from __future__ import annotations

from synth.effects.compiled import inlined
from synth.effects.effect import Effect, Parameter, Prior, Shape, signed


@inlined
def torque(  # type: ignore[no-untyped-def]
    rotation, rate, deflection, spring_rate, damper_rate, damper_torque, force, memory, stiffening, exponent
):
    """Odd power of the deflection."""
    return -stiffening * deflection * (abs(deflection) + 1e-9) ** (exponent - 1.0), 0.0


EFFECT = Effect(
    name="hardening_spring",
    meaning="a stiffness that grows (or falls) with deflection",
    formula="-stiffening |u|^(exponent - 1) u, u the deflection in rad from the free angle",
    source="G. Duffing, Erzwungene Schwingungen (1918): exponent 3",
    way="torque",
    belongs_to="spring",
    linear=True,
    parameters=(
        Parameter("stiffening", "N*m", prior=signed(0.4), meaning="extra torque at 1 rad; negative: softening"),
        Parameter("exponent", "1", 3.0, Prior(3.0, 1.0, lower=1.3, upper=7.0), off=3.0, natural=False),
    ),
    strengths=("stiffening",),
    shapes=(Shape(("stiffening", "exponent"), {}, ({"exponent": 2.0}, {"exponent": 3.5})),),
)
