"""Contact at the end of travel."""

from __future__ import annotations

from synth.effects.compiled import inlined
from synth.effects.effect import Effect, Parameter, Prior, Shape, positive

FAR = 1e3  # rad


@inlined
def torque(  # type: ignore[no-untyped-def]
    rotation, rate, deflection, spring_rate, damper_rate, damper_torque, force, memory, upper, lower, stiffness, damping
):
    """One-sided linear spring and damper at either end; the contact pushes and never pulls."""
    above = rotation - upper
    below = lower - rotation
    push_back = max(stiffness * above + damping * rate, 0.0) if above > 0.0 else 0.0
    push_on = max(stiffness * below - damping * rate, 0.0) if below > 0.0 else 0.0
    return push_on - push_back, 0.0


def to_rotation(sign: int, zero: float, upper: float, lower: float) -> tuple[float, float]:
    """Ends of travel in measured angle to rotations."""
    ends = (sign * (upper - zero), sign * (lower - zero))
    return (ends[0], ends[1]) if sign > 0 else (ends[1], ends[0])


EFFECT = Effect(
    name="joint_stop",
    meaning="contact at the end of travel",
    formula="-max(0, stiffness x + damping w) at penetration x > 0, its mirror image at the other end",
    source="Kelvin-Voigt contact that does not pull: Gilardi & Sharf, Mechanism and Machine Theory 37 (2002) 1213",
    way="torque",
    parameters=(
        Parameter(
            "upper",
            "rad",
            FAR,
            Prior(0.6, 0.3),
            off=FAR,
            anchor="middle",
            meaning="end of travel above, measured angle",
        ),
        Parameter(
            "lower",
            "rad",
            -FAR,
            Prior(-0.6, 0.3),
            off=-FAR,
            anchor="middle",
            meaning="end of travel below, measured angle",
        ),
        Parameter("stiffness", "N*m/rad", prior=positive(5.0, 1.5), meaning="of the contact"),
        Parameter("damping", "N*m*s/rad", 0.0, positive(1.0, 1.5), meaning="of the contact"),
    ),
    strengths=("stiffness",),
    shapes=(
        Shape(
            ("upper", "stiffness", "damping"), {}, ({"upper": 0.75, "stiffness": 4.0}, {"upper": 0.4, "stiffness": 4.0})
        ),
        Shape(
            ("lower", "stiffness", "damping"),
            {},
            ({"lower": -0.75, "stiffness": 4.0}, {"lower": -0.4, "stiffness": 4.0}),
        ),
    ),
)
