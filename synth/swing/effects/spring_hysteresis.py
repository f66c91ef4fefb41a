"""Spring hysteresis: loading and unloading follow different curves, by internal slip or by relaxation.

The law has a kink where the motion reverses; at a tolerance of 1e-6 the error is within 5e-5 rad
(``tests/swing/effects``).
"""

from __future__ import annotations

from synth.swing.effects.definition import Effect, Parameter, Shape, positive, size
from synth.swing.effects.inlined import inlined, power

NEVER = 1e9  # s, relaxation time of a spring that does not relax


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
    stiffness,
    slip,
    relaxation,
    knee,
):
    """A second spring whose deflection (memory, rad) is limited by slip and relaxes with time."""
    bent = memory / slip
    yielding = power(abs(bent) + 1e-9, knee) if rate * memory > 0.0 else 0.0
    return -stiffness * memory, rate * (1.0 - yielding) - memory / relaxation


def start(deflection, stiffness, slip, relaxation, knee):  # type: ignore[no-untyped-def]
    """The second spring is unloaded at the release, because the joint was held."""
    return 0.0 * deflection


EFFECT = Effect(
    name="spring_hysteresis",
    meaning="loading and unloading follow different curves",
    phrase="has a spring with hysteresis",
    needs=("spring",),
    formula="-stiffness z, dz/dt = w (1 - |z / slip|^knee while it loads) - z / relaxation",
    source="slip: Wen, J. Eng. Mech. 102 (1976) 249, with beta = gamma, n = knee; relaxation: Maxwell's element",
    way="torque",
    belongs_to="spring",
    linear=True,
    memory=True,
    parameters=(
        Parameter("stiffness", "N*m/rad", prior=size(0.3), meaning="rate of the part that slips or relaxes"),
        Parameter(
            "slip", "rad", NEVER, positive(0.3, 1.0, lower=0.06), off=NEVER, meaning="deflection at which it slips"
        ),
        Parameter("relaxation", "s", NEVER, positive(1.0, 1.5), off=NEVER, meaning="time constant of its relaxation"),
        Parameter(
            "knee",
            "1",
            1.5,
            positive(1.5, 0.5, 0.4, 6.0),
            off=1.5,
            natural=False,
            meaning="sharpness of the transition to slip",
        ),
    ),
    strengths=("stiffness",),
    shapes=(
        Shape(("stiffness", "slip", "knee"), {}, ({"slip": 0.1}, {"slip": 0.5})),
        Shape(("stiffness", "relaxation"), {}, ({"relaxation": 0.3}, {"relaxation": 1.5}, {"relaxation": 8.0})),
    ),
)
