"""Dry friction that grows with the joint's load: with its bearing force, or with the transmitted spring torque."""

from __future__ import annotations

from synth.swing.effects.coulomb_friction import PRESLIDING_PARAMETER
from synth.swing.effects.definition import Effect, Parameter, Shape, size
from synth.swing.effects.inlined import bristle, held, inlined


@inlined
def torque(  # type: ignore[no-untyped-def]
    rotation, rate, deflection, spring_rate, damper_rate, damper_torque, force, memory, radius, share, presliding
):
    """The bristle of Coulomb friction with a strength in proportion to the present load."""
    level = radius * force + share * abs(spring_rate * deflection)
    change = bristle(rate, memory, presliding)
    return -level * held(memory, change, presliding), change


def start(deflection, radius, share, presliding):  # type: ignore[no-untyped-def]
    """Bristles at the release: straight."""
    return 0.0 * deflection


EFFECT = Effect(
    name="load_friction",
    meaning="dry friction that grows with the joint's load",
    phrase="has dry friction that grows with load",
    formula="-s (radius |F| + share |T|), F the bearing force, T the spring's torque, s as of coulomb_friction",
    source="journal bearing: Shigley, Mechanical Engineering Design, ch. 12; gear: Duclusaud et al., BAM, "
    "arXiv 2410.08650, model M3",
    way="torque",
    linear=True,
    memory=True,
    kin="bristle",
    bristle="presliding",
    uses_load=True,
    by_load=("radius",),
    parameters=(
        Parameter("radius", "m", 0.0, size(0.03), meaning="coefficient of friction times bearing radius"),
        Parameter(
            "share",
            "1",
            0.0,
            size(0.15),
            natural=False,
            meaning="friction per unit of the spring's torque",
            form="share",
        ),
        PRESLIDING_PARAMETER,
    ),
    strengths=("radius", "share"),
    shapes=(
        Shape(("radius", "presliding"), {}, ({}, {"presliding": 2e-3})),
        Shape(("share", "presliding"), {}, ({}, {"presliding": 2e-3})),
    ),
)
