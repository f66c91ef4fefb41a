"""An effect as a user would write it into a file of their own; its strength in N m/(rad/s)^3."""

CUBIC_DRAG = """
from synth.effects import Effect, Parameter, Shape, inlined, size


@inlined
def torque(rotation, rate, deflection, spring_rate, damper_rate, damper_torque, force, memory, strength):
    return -strength * rate * rate * rate, 0.0


EFFECT = Effect(
    name="cubic_drag", meaning="drag that grows with the cube of speed", formula="-c w^3", source="none", way="torque",
    parameters=(Parameter("strength", "N*m", prior=size(0.01), natural=False),), strengths=("strength",),
    shapes=(Shape(("strength",), {}),),
)
"""
