"""Play of a driven joint's gear: the rotor on one side, the link on the other, flanks between them.

The rotor with its gear is a link of its own, without length or mass; the joint's link follows at a second hinge, which
turns freely within the play. The flanks are those of ``joint_stop``: no event is located. What acts at the joint
(drive, armature, friction) acts on the rotor's side.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from synth.swing.effects.definition import Effect, Parameter, Shape, size
from synth.swing.effects.joint_stop import EFFECT as JOINT_STOP
from synth.swing.lane_layout import CONTROLLED

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes

LEAST_ROTOR = 0.01  # of the link's inertia about its joint: a lighter rotor only costs steps
DEPTH = 0.01  # rad, to which the flanks' torque refers; they are linear, so it does not matter
# Of the flanks in the diagnosis' shapes, in natural units: shorter contacts take longer to integrate. Against rigid
# flanks such contacts leave less than a tenth of the play's effect (tests/drives/test_gear_play.py).
CONTACT, DAMPING = 0.05, 40.0
PLACES = ("before the play", "behind the play")


def extend(
    legs: LegLanes,
    joint: int,
    play: Array,
    contact: Array,
    damping: Array,
    read_beyond: Array,
    controlled_beyond: Array,
) -> LegLanes:
    """Part the joint's link from its rotor, and connect them by a hinge with the play."""
    numbers = {name: getattr(legs, name)[joint].copy() for name in ("length", "mass", "com", "com_across", "inertia")}
    parts = slice(joint, min((link for link in legs.own if link > joint), default=legs.n))  # more than one if it bends
    reach = np.cumsum(legs.length[parts], axis=0) - legs.length[parts] + legs.com[parts]
    about_joint = (legs.inertia[parts] + legs.mass[parts] * (reach**2 + legs.com_across[parts] ** 2)).sum(axis=0)
    made = legs.with_link(joint + 1, **numbers)
    for name in numbers:
        getattr(made, name)[joint] = 0.0
    made.inertia[joint] = np.maximum(LEAST_ROTOR * about_joint - made.own_inertia[joint], 0.0)
    rotor = made.own_inertia[joint] + made.inertia[joint]
    stiffness = (np.pi / contact) ** 2 * rotor * about_joint / (rotor + about_joint)
    half, one = 0.5 * np.asarray(play), np.ones(legs.n_lane)
    flanks = half * one, -half * one, stiffness * one, damping * one, one, DEPTH * one
    made.put(JOINT_STOP, joint + 1, np.array(flanks))
    made.read_beyond[joint] = read_beyond
    made.controlled[CONTROLLED.index("controlled_beyond"), joint] = controlled_beyond
    return made


def start(legs: LegLanes, joint: int, rotation: Array) -> Array:
    """Rotation (n_lane,) rad of the link within the play when a recording begins: its weight holds it at a flank."""
    link = joint + 1
    angle = legs.tilt + np.cumsum(rotation, axis=0)
    carried = np.cumsum(legs.mass[::-1], axis=0)[::-1]
    moment = legs.mass * legs.com
    moment[:-1] += carried[1:] * legs.length[:-1]
    turning = moment * np.sin(angle) + legs.mass * legs.com_across * np.cos(angle)
    weight = -legs.gravity * (turning * (1.0 - legs.weightless[:, None]))[link:].sum(axis=0)
    upper, _, stiffness, *_ = legs.torques[JOINT_STOP.name][:, link]
    return np.asarray(np.sign(weight) * upper + weight / stiffness)


def deviation(legs: LegLanes, link: int, acceleration: Array) -> tuple[Array, Array]:
    """How far (n_lane,) rad, and how fast, rad/s, the link may be off that flank when a recording begins.

    ``acceleration`` (n_lane,) rad/s^2 at which it may already move towards the other flank.
    """
    half = legs.torques[JOINT_STOP.name][0, link]
    return half, np.sqrt(2.0 * half * acceleration)


def _shape(read: float, controlled: float) -> Shape:
    """A shape for where the encoder and the controller read."""
    held = {"contact": CONTACT, "damping": DAMPING, "read_beyond": read, "controlled_beyond": controlled}
    return Shape(("play",), held, ({"play": 0.04},), needs=("servo",) if controlled else ())


EFFECT = Effect(
    name="gear_play",
    meaning="play of a drive's gear: the rotor turns a little without the link",
    phrase="has play in its gear",
    needs=("driven rotor",),
    formula="rotor and link apart, between them J (pi / contact)^2 x max(0, 1 + damping dx/dt) at depth x of a flank, "
    "1/J = 1/rotor + 1/link (about the joint)",
    source="Nordin & Gutman, Automatica 38 (2002) 1633; flanks: Hunt & Crossley, J. Applied Mechanics 42 (1975) 440",
    way="structure",
    parameters=(
        Parameter("play", "rad", prior=size(0.1), meaning="full width, at the joint"),
        Parameter(
            "contact",
            "s",
            0.002,
            above=0.0,
            meaning="duration of a blow without damping: the flanks' stiffness, with rotor and link on either side",
        ),
        Parameter(
            "damping", "s/rad", 1.0, least=0.0, meaning="relative increase of a flank's torque per rad/s of closing"
        ),
        Parameter(
            "read_beyond",
            "1",
            0.0,
            natural=False,
            label="angle recorded",
            choices=PLACES,
            meaning="1: the recorded angle is the link's; 0: that of the gear on the rotor's side",
        ),
        Parameter(
            "controlled_beyond",
            "1",
            0.0,
            natural=False,
            label="angle controlled",
            choices=PLACES,
            meaning="1: the servo controls the link's angle; 0: that of the gear on the rotor's side",
        ),
    ),
    stated=("play", "read_beyond"),
    strengths=("play",),
    deviation="deviation",
    parts_drive=True,
    tolerance=1e-5,  # at 1e-6 the contacts take a third more time, and the motion is no nearer that of rigid flanks
    shapes=(_shape(1.0, 1.0), _shape(1.0, 0.0), _shape(0.0, 0.0)),
)
