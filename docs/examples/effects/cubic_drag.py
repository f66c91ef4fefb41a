"""An effect of one's own: `synth gap gap.yaml --out result --effect cubic_drag.py`."""

from synth.effects import Effect, Parameter, Shape, inlined, size


@inlined
def torque(rotation, rate, deflection, spring_rate, damper_rate, damper_torque, force, memory, strength):
    """N*m on the joint at ``rate`` rad/s, and no memory."""
    return -strength * rate * rate * rate, 0.0


EFFECT = Effect(
    name="cubic_drag",
    meaning="drag that grows with the cube of speed",
    phrase="has drag that grows with the cube of speed",
    formula="-strength w^3",
    source="an example; no textbook",
    way="torque",
    parameters=(Parameter("strength", "N*m", prior=size(0.01), natural=False, meaning="torque at 1 rad/s"),),
    strengths=("strength",),
    shapes=(Shape(("strength",), {}),),
)
