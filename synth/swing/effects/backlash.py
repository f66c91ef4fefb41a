"""Backlash: a dead zone between the joint and its spring and damper.

A drive always turns with the joint: play in its gear, with the rotor on the other side, is ``gear_play``.

The flanks are rigid and not smoothed. The force jumps when the joint meets a flank with the damper behind it; the
integrator ends a step there (``synth.swing.turning_events``). Against an integration from event to event
(``tests/swing/effects/test_contact.py``) the error is at most 5e-5 rad on swings of 0.5 rad, mostly due to ``SEATING``,
with twice the steps of a leg without backlash.
"""

from __future__ import annotations

from synth.swing.effects.definition import Effect, Parameter, Shape, size
from synth.swing.effects.inlined import inlined

FASTEST = 2000.0  # 1/s, upper limit of the free output side's rate; a very weak damper is increased accordingly
SEATING = 1e-5  # relative lag of the pushed output side, so that rounding does not break the contact


@inlined
def torque(  # type: ignore[no-untyped-def]
    rotation, rate, deflection, spring_rate, damper_rate, damper_torque, force, memory, gap
):
    """Spring and damper act on a massless output side (memory: its deflection, rad), which the joint drives with play.

    In contact the output side follows the joint while the joint pushes it; otherwise it relaxes by itself. A damper
    curve, with its laws, is replaced by its secant at the joint's rate. ``force`` : torque (N m) of the spring's laws
    on the output side, which acts beside this one; ``damper_torque`` is less by that of the damper's laws.
    """
    lag = deflection - memory
    side = 1.0 if lag > 0.0 else -1.0
    secant = damper_torque / rate if abs(rate) > 1e-6 else damper_rate  # rad/s: at rest
    viscous = max(secant, spring_rate / FASTEST) + 1e-12
    alone = (force - spring_rate * memory) / viscous
    driven = side * (rate - side * (SEATING * abs(rate) + 1e-9))
    touching = side * lag > 0.5 * gap
    change = side * max(driven, side * alone) if touching else alone
    value = spring_rate * deflection + damper_torque - (spring_rate * memory + viscous * change)
    return (value if gap > 0.0 else 0.0), (change if gap > 0.0 else 0.0)


def start(deflection, gap):  # type: ignore[no-untyped-def]
    """Deflection of the output side at the release: the joint holds it against its spring."""
    import numpy as np

    return np.sign(deflection) * np.maximum(np.abs(deflection) - 0.5 * gap - 1e-7, 0.0)


EFFECT = Effect(
    name="backlash",
    meaning="a dead zone between the joint and its spring and damper (a drive's: gear_play)",
    phrase="has backlash",
    needs=("spring", "damper"),
    formula="play of width gap between the joint and the massless side that holds spring and damper with their laws; "
    "spring_hysteresis acts beside it",
    source="Nordin & Gutman, Automatica 38 (2002) 1633, the physical model with a massless shaft",
    way="torque",
    memory=True,
    play="gap",
    parameters=(Parameter("gap", "rad", prior=size(0.15), meaning="full width of the play"),),
    strengths=("gap",),
    shapes=(Shape(("gap",), {}, ({"gap": 0.02}, {"gap": 0.1})),),
)
