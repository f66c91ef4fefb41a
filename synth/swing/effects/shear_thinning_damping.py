"""Shear thinning: at speed a damper, for example one filled with a polymer, is weaker than its low-speed rate."""

from __future__ import annotations

from synth.swing.effects.definition import Effect, Parameter, Prior, Shape, positive
from synth.swing.effects.inlined import inlined, power


@inlined
def torque(  # type: ignore[no-untyped-def]
    rotation, rate, deflection, spring_rate, damper_rate, damper_torque, force, memory, loss, speed, knee
):
    """Torque that the damper loses; the viscosity is Carreau and Yasuda's with n = 1 - loss, a = knee."""
    return damper_torque * (1.0 - power(1.0 + power(abs(rate / speed) + 1e-9, knee), -loss / knee)), 0.0


EFFECT = Effect(
    name="shear_thinning_damping",
    meaning="a damper weaker at speed than its low-speed rate says",
    phrase="has a damper that is weaker at speed",
    needs=("damper",),
    formula="damper torque times (1 + |w/speed|^knee)^(-loss/knee)",
    source="K. Yasuda et al., Rheologica Acta 20 (1981) 163, n = 1 - loss, a = knee; Carreau: knee 2",
    way="torque",
    belongs_to="damper",
    parameters=(
        Parameter("loss", "1", 0.5, Prior(0.5, 0.3, lower=0.0, upper=1.2), natural=False, meaning="1 - Carreau's n"),
        Parameter("speed", "rad/s", prior=positive(0.2, 1.2), off=1.0, meaning="at which thinning begins"),
        Parameter(
            "knee",
            "1",
            2.0,
            positive(2.0, 0.6, 0.5, 8.0),
            off=2.0,
            natural=False,
            meaning="sharpness of the transition",
        ),
    ),
    strengths=("loss",),
    shapes=(
        Shape(
            ("loss", "speed", "knee"),
            {},
            ({"loss": 0.15, "speed": 0.05, "knee": 2.0}, {"loss": 0.15, "speed": 0.3, "knee": 2.0}),
        ),
    ),
)
