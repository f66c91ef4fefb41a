"""A dead zone between the joint and its spring and damper.

Rigid flanks, no smoothing: the force jumps where the joint meets a flank with the damper behind it, a moment at which
the integrator ends a step (``synth.swing.turning_events``). Measured against an integration from event to event
(``tests/swing/effects/test_contact.py``): at most 5e-5 rad on swings of 0.5 rad, most of it due to ``SEATING``, at
twice the steps of a leg without play.
"""

from __future__ import annotations

from synth.swing.effects.definition import Effect, Parameter, Shape, size
from synth.swing.effects.inlined import inlined

FASTEST = 2000.0  # 1/s, of the output side left to itself: a spring with hardly any damper gets that much more of it
SEATING = 1e-5  # of the way, by which the output side stays behind while it is pushed; else rounding would part them


@inlined
def torque(  # type: ignore[no-untyped-def]
    rotation, rate, deflection, spring_rate, damper_rate, damper_torque, force, memory, gap
):
    """Spring and damper hold a massless output side (memory: its deflection, rad) that the joint drives with play.

    On a flank the output side goes with the joint as long as that pushes; else it goes back by itself. A damper's curve
    counts with its secant at the joint's rate.
    """
    lag = deflection - memory
    side = 1.0 if lag > 0.0 else -1.0
    secant = damper_torque / rate if abs(rate) > 1e-6 else damper_rate
    viscous = max(max(secant, damper_rate), spring_rate / FASTEST) + 1e-12
    alone = -spring_rate * memory / viscous
    driven = side * (rate - side * (SEATING * abs(rate) + 1e-9))
    touching = side * lag > 0.5 * gap
    change = side * max(driven, side * alone) if touching else alone
    value = spring_rate * deflection + damper_torque - (spring_rate * memory + viscous * change)
    return (value if gap > 0.0 else 0.0), (change if gap > 0.0 else 0.0)


def start(deflection, gap):  # type: ignore[no-untyped-def]
    """The output side at the release: held by the joint against its spring, on the far side of the play."""
    import numpy as np

    return np.sign(deflection) * np.maximum(np.abs(deflection) - 0.5 * gap - 1e-7, 0.0)


EFFECT = Effect(
    name="backlash",
    meaning="a dead zone between the joint and its spring and damper",
    phrase="has backlash",
    needs=("spring", "damper"),
    formula="play of width gap between the joint and the massless side that holds spring and damper",
    source="Nordin & Gutman, Automatica 38 (2002) 1633, the physical model with a massless shaft",
    way="torque",
    memory=True,
    play="gap",
    parameters=(Parameter("gap", "rad", prior=size(0.15), meaning="whole width of the play"),),
    strengths=("gap",),
    shapes=(Shape(("gap",), {}, ({"gap": 0.02}, {"gap": 0.1})),),
)
