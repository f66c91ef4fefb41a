"""Drag that grows faster than speed: air, or oil through an orifice."""

from __future__ import annotations

from synth.swing.effects.definition import Effect, Parameter, Prior, Shape, size
from synth.swing.effects.inlined import inlined, power


@inlined
def torque(  # type: ignore[no-untyped-def]
    rotation, rate, deflection, spring_rate, damper_rate, damper_torque, force, memory, coefficient, exponent, speed
):
    """Power-law drag; the tiny speed keeps the power's slope finite."""
    return -coefficient * speed * rate * power((abs(rate) + 1e-9) / speed, exponent - 1.0), 0.0


EFFECT = Effect(
    name="quadratic_damping",
    meaning="drag that grows faster than speed",
    phrase="has drag that grows faster than speed",
    formula="-coefficient speed^2 |w / speed|^exponent sign(w); speed does not matter at exponent 2",
    source="Newton's drag law; Hoerner, Fluid-Dynamic Drag (1965), ch. 1",
    way="torque",
    linear=True,
    parameters=(
        Parameter("coefficient", "N*m*s^2/rad^2", prior=size(0.2), meaning="torque at speed over its square"),
        Parameter("exponent", "1", 2.0, Prior(2.1, 0.4, lower=1.5, upper=3.5), off=2.0, natural=False),
        Parameter("speed", "rad/s", 1.0, off=1.0, above=0.0, meaning="speed to which the coefficient refers"),
    ),
    stated=("coefficient", "exponent", "speed"),
    idle={"speed": ("exponent", 2.0)},
    strengths=("coefficient",),
    shapes=(Shape(("coefficient", "exponent"), {"speed": 1.0}, ({"exponent": 2.0},)),),
)
