"""Dry friction that falls with speed: from a breakaway torque to a lower sliding torque."""

from __future__ import annotations

from synth.swing.effects.coulomb_friction import PRESLIDING_PARAMETER
from synth.swing.effects.definition import Effect, Parameter, Prior, Shape, positive, size
from synth.swing.effects.inlined import bristle, held, inlined, stribeck_share


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
    friction,
    fall,
    speed,
    presliding,
):
    """The bristle of Coulomb friction with a strength that follows Stribeck's curve."""
    level = friction * stribeck_share(rate, speed, fall)
    change = bristle(rate, memory, presliding)
    return -level * held(memory, change, presliding), change


def start(deflection, friction, fall, speed, presliding):  # type: ignore[no-untyped-def]
    """Bristles at the release: straight."""
    return 0.0 * deflection


EFFECT = Effect(
    name="stribeck_friction",
    meaning="dry friction that falls with speed",
    phrase="has dry friction that falls with speed",
    formula="-s torque (1 - fall + fall exp(-(w/speed)^2)), s as of coulomb_friction",
    source="Stribeck 1902; Armstrong-Helouvry, Dupont & Canudas de Wit, Automatica 30 (1994) 1083, eq. 5",
    way="torque",
    linear=True,
    memory=True,
    kin="bristle",
    bristle="presliding",
    parameters=(
        Parameter("torque", "N*m", prior=size(0.15), meaning="breakaway torque, at lowest speed"),
        Parameter(
            "fall",
            "1",
            0.5,
            Prior(0.6, 0.25, lower=0.25, upper=1.0),
            natural=False,
            meaning="share lost at speed",
            form="share",
        ),
        Parameter("speed", "rad/s", prior=positive(0.15, 1.0, upper=1.0), off=1.0, meaning="speed over which it falls"),
        PRESLIDING_PARAMETER,
    ),
    stated=("torque", "fall", "speed"),
    strengths=("torque",),
    shapes=(
        Shape(
            ("torque", "fall", "speed", "presliding"),
            {},
            ({"fall": 0.6, "speed": 0.05, "presliding": 2e-3}, {"fall": 0.6, "speed": 0.25}),
        ),
        Shape(("torque", "fall", "speed"), {}, ({"fall": 0.6, "speed": 0.15},), ("servo", "motor")),
    ),
)
