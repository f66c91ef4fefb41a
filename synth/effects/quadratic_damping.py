"""Drag that grows faster than speed: air, or oil through an orifice."""

from __future__ import annotations

from synth.effects.compiled import inlined
from synth.effects.effect import Effect, Parameter, Prior, Shape, size


@inlined
def torque(  # type: ignore[no-untyped-def]
    rotation, rate, deflection, spring_rate, damper_rate, damper_torque, force, memory, coefficient, exponent
):
    """Power-law drag; the tiny speed keeps the power's slope finite."""
    return -coefficient * rate * (abs(rate) + 1e-9) ** (exponent - 1.0), 0.0


EFFECT = Effect(
    name="quadratic_damping",
    meaning="drag that grows faster than speed",
    formula="-coefficient |w|^(exponent - 1) w, w in rad/s",
    source="Newton's drag law; Hoerner, Fluid-Dynamic Drag (1965), ch. 1",
    way="torque",
    linear=True,
    parameters=(
        Parameter("coefficient", "N*m*s^2/rad^2", prior=size(0.2), meaning="torque at 1 rad/s"),
        Parameter("exponent", "1", 2.0, Prior(2.1, 0.4, lower=1.5, upper=3.5), off=2.0, natural=False),
    ),
    strengths=("coefficient",),
    shapes=(Shape(("coefficient", "exponent"), {}, ({"exponent": 2.0},)),),
)
