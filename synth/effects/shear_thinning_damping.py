"""A damper weaker at speed than its low-speed rate says, as one filled with a polymer is."""

from __future__ import annotations

from synth.effects.compiled import inlined
from synth.effects.effect import Effect, Parameter, Prior, Shape, positive


@inlined
def torque(  # type: ignore[no-untyped-def]
    rotation, rate, deflection, spring_rate, damper_rate, damper_torque, force, memory, loss, speed
):
    """Give back what the damper no longer holds; the viscosity is Carreau's with n = 1 - loss."""
    return damper_torque * (1.0 - (1.0 + (rate / speed) ** 2) ** (-0.5 * loss)), 0.0


EFFECT = Effect(
    name="shear_thinning_damping",
    meaning="a damper weaker at speed than its low-speed rate says",
    formula="damper torque times (1 + (w/speed)^2)^(-loss/2)",
    source="P. Carreau, Trans. Soc. Rheology 16 (1972) 99, with n = 1 - loss and no second plateau",
    way="torque",
    belongs_to="damper",
    parameters=(
        Parameter("loss", "1", 0.5, Prior(0.5, 0.3, lower=0.0, upper=1.2), natural=False, meaning="1 - Carreau's n"),
        Parameter("speed", "rad/s", prior=positive(0.2, 1.2), off=1.0, meaning="where the thinning begins"),
    ),
    strengths=("loss",),
    shapes=(
        Shape(
            ("loss", "speed"),
            {},
            ({"loss": 0.15, "speed": 0.05}, {"loss": 0.15, "speed": 0.3}, {"loss": 0.15, "speed": 1.0}),
        ),
    ),
)
