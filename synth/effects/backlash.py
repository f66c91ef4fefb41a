"""A dead zone between the joint and its spring and damper."""

from __future__ import annotations

from synth.effects.compiled import inlined
from synth.effects.effect import Effect, Parameter, Shape, size

CONTACT = 20.0  # contact stiffness over the spring's
FASTEST = 2000.0  # 1/s, of the massless output side: the contact is damped so that it goes no faster


@inlined
def torque(  # type: ignore[no-untyped-def]
    rotation, rate, deflection, spring_rate, damper_rate, damper_torque, force, memory, gap
):
    """Spring and damper hold a massless output side (memory: its deflection, rad) that the joint drives with play.

    Its contacts are springs ``CONTACT`` times the joint's; the output's own spring is as much stiffer as makes both in
    series the joint's. Without a gap nothing is changed.
    """
    on = 1.0 if gap > 0.0 else 0.0
    contact = CONTACT * spring_rate
    own = spring_rate * CONTACT / (CONTACT - 1.0)
    lag = deflection - memory
    pushed = contact * (lag - max(-0.5 * gap, min(0.5 * gap, lag)))
    viscous = max(damper_rate * (CONTACT / (CONTACT - 1.0)) ** 2, (own + contact) / FASTEST) + 1e-12
    value = spring_rate * deflection + damper_rate * rate - pushed
    return on * value, on * (pushed - own * memory) / viscous


def start(deflection, gap):  # type: ignore[no-untyped-def]
    """The output side at the release: held by the joint against its spring, on the far side of the play."""
    import numpy as np

    outside = np.sign(deflection) * np.maximum(np.abs(deflection) - 0.5 * gap, 0.0)
    return outside * (1.0 - 1.0 / CONTACT)


EFFECT = Effect(
    name="backlash",
    meaning="a dead zone between the joint and its spring and damper",
    formula="play of width gap between the joint and the massless side that holds spring and damper",
    source="Nordin & Gutman, Automatica 38 (2002) 1633, the physical model with a massless shaft",
    way="torque",
    memory=True,
    parameters=(Parameter("gap", "rad", prior=size(0.15), meaning="whole width of the play"),),
    strengths=("gap",),
    shapes=(Shape(("gap",), {}, ({"gap": 0.02}, {"gap": 0.1})),),
)
