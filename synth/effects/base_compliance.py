"""The mount moves: it rocks about the first joint's place, or slides, on a spring and a damper."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from synth.effects.effect import Effect, Parameter, Shape, stiff

if TYPE_CHECKING:
    from synth.model.lanes import LegLanes
    from synth.model.leg import Array

LEVER = 100.0  # leg lengths: a link so long turns by next to nothing when its end slides
BASE_INERTIA = 0.3  # of the leg's own, where not given
DAMPING_RATIO = 0.05


def extend(legs: LegLanes, joint: int, stiffness: Array, rocking_stiffness: Array) -> LegLanes:
    """One more link before the first: of no length for rocking; for sliding so long that its end goes straight.

    The base's own mass is ``BASE_INERTIA`` of the leg's and its damping ratio ``DAMPING_RATIO``: with a mount much
    stiffer than the joints' springs neither shows in the leg's motion.
    """
    total = legs.length.sum(axis=0)
    mass = legs.mass.sum(axis=0)
    slides = bool(np.any(stiffness > 0.0))  # in its own direction, level with the base
    if slides:
        lever = LEVER * total
        moving = (1.0 + BASE_INERTIA) * mass * lever**2
        own = BASE_INERTIA * mass * lever**2
        rate = stiffness * lever**2
    else:
        lever = np.zeros_like(total)
        reach = np.cumsum(legs.length, axis=0) - legs.length + legs.com
        leg_inertia = (legs.inertia + legs.mass * reach**2).sum(axis=0)
        own = BASE_INERTIA * leg_inertia
        moving = own + leg_inertia
        rate = rocking_stiffness
    damping = 2.0 * DAMPING_RATIO * np.sqrt(rate * moving)
    return legs.with_link(
        0, length=lever, inertia=own, spring_rate=rate, damper_rate=damping, rest=0.0, weightless=float(slides)
    )


def start(legs: LegLanes, joint: int, rotation: Array) -> Array:
    """Deflection (n_lane,) rad of the mount while the leg is held: what the first joint's spring bends it by.

    A sliding mount starts undeflected: what force the hand put on it is not known.
    """
    torque = legs.spring_rate[1] * (rotation[1] - legs.rest[1])
    return np.where(legs.length[0] > 0.0, 0.0, torque / legs.spring_rate[0])


EFFECT = Effect(
    name="base_compliance",
    meaning="the mount moves",
    formula="stiffness x + damper + mass of the mount = force of the leg (sliding), its like for rocking",
    source="definition; the small base's modes lie above the leg's",
    way="structure",
    where="base",
    parameters=(
        Parameter("stiffness", "N/m", 0.0, stiff(30.0, 1000.0), meaning="against sliding sideways"),
        Parameter("rocking_stiffness", "N*m/rad", 0.0, stiff(30.0, 1000.0), meaning="against rocking"),
    ),
    strengths=("stiffness", "rocking_stiffness"),
    shapes=(
        Shape(("rocking_stiffness",), {}, ({"rocking_stiffness": 100.0},)),
        Shape(("stiffness",), {}, ({"stiffness": 100.0},)),
    ),
)
