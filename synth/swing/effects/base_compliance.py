"""A compliant mount: it rocks about a point near the first joint, slides, or both, on springs and dampers.

A sliding mount is modelled as the end of a link of ``LEVER`` leg lengths; its frequencies are within 0.2 % of those of
straight sliding (``tests/swing/effects/test_structure.py``). Gravity does no work on the mount's own rotation, because
the static deflection under the leg's weight is part of the mount's rest position.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from synth.swing.effects.definition import Effect, Parameter, Shape, positive, signed, stiff

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes
    from synth.swing.leg_model import Leg

LEVER = 100.0  # leg lengths; such a long link hardly rotates when its end slides
LEAST_SHARE = 0.02  # of the leg's own mass or inertia, lower limit of the mount's


def extend(
    legs: LegLanes,
    joint: int,
    stiffness: Array,
    mass: Array,
    rocking_stiffness: Array,
    arm: Array,
    inertia: Array,
    damping_ratio: Array,
) -> LegLanes:
    """Insert a link before the first: a very long one for sliding, one of length ``arm`` for rocking.

    With both stiffnesses there are two links, and the rocking mount is on the sliding one. A mount that rocks about a
    point below the first joint has a negative ``arm``: a link of negative length.
    """
    total, carried = legs.length.sum(axis=0), legs.mass.sum(axis=0)
    slides = bool(np.any(stiffness > 0.0))  # in the horizontal direction of the base
    if not slides or bool(np.any(rocking_stiffness > 0.0)):
        reach = np.cumsum(legs.length, axis=0) - legs.length + legs.com
        leg_inertia = (legs.inertia + legs.mass * (reach**2 + legs.com_across**2)).sum(axis=0)
        length = np.asarray(arm) + 0.0 * total
        own = np.maximum(inertia, LEAST_SHARE * leg_inertia)
        moving = own + leg_inertia + carried * length**2
        legs = _mount(legs, length, own, moving, rocking_stiffness, damping_ratio)
    if slides:
        length = LEVER * total
        own = np.maximum(mass, LEAST_SHARE * carried) * length**2
        legs = _mount(legs, length, own, own + carried * length**2, stiffness * length**2, damping_ratio)
    return legs


def _mount(
    legs: LegLanes, length: Array, own: Array, moving: Array, stiffness: Array, damping_ratio: Array
) -> LegLanes:
    """Insert a link of inertia ``own`` with spring and damper before the first; ``moving`` : inertia with the leg."""
    damping = 2.0 * damping_ratio * np.sqrt(stiffness * moving)
    return legs.with_link(
        0, length=length, inertia=own, spring_rate=stiffness, damper_rate=damping, rest=0.0, weightless=1.0
    )


def bounded(leg: Leg, joint: int, slowest: float, values: Array) -> Array:
    """Parameters (n_parameter, n_lane), the stiffnesses at least those of a mount that sways at ``slowest``, 1/s.

    Sliding and rocking each by themselves, with the leg straight and rigid.
    """
    stiffness, mass, rocking, arm, inertia, ratio = values
    length, com = np.array([(joint.link.length, joint.link.com) for joint in leg.joints]).T
    own = np.array([joint.link.mass for joint in leg.joints])
    about = np.array([joint.link.inertia + joint.link.mass * joint.link.com_across**2 for joint in leg.joints])
    reach = np.cumsum(length) - length + com
    leg_inertia, carried = float((about + own * reach**2).sum()), float(own.sum())
    sliding = np.maximum(mass, LEAST_SHARE * carried) + carried
    hung = (about[:, None] + own[:, None] * (reach[:, None] + arm) ** 2).sum(axis=0)  # about the rocking point
    turning = np.maximum(inertia, LEAST_SHARE * leg_inertia) + hung
    stiffness = np.where(stiffness > 0.0, np.maximum(stiffness, slowest**2 * sliding), stiffness)
    rocking = np.where(rocking > 0.0, np.maximum(rocking, slowest**2 * turning), rocking)
    return np.array([stiffness, mass, rocking, arm, inertia, ratio])


def start(legs: LegLanes, joint: int, rotation: Array) -> Array:
    """Deflections (n_new, n_lane) rad of the mount while the leg is held, due to the first joint's spring.

    A sliding mount starts undeflected, because the force of the hand is unknown. ``joint`` : index of the leg's first
    joint, which follows the new links.
    """
    torque = legs.spring_rate[joint] * (rotation[joint] - legs.rest[joint])
    sliding = np.abs(legs.length[:joint]) > 0.5 * LEVER * legs.length[joint:].sum(axis=0)
    return np.where(sliding, 0.0, torque / legs.spring_rate[:joint])


EFFECT = Effect(
    name="base_compliance",
    meaning="the mount moves",
    phrase="moves",
    formula="mass x'' + damper + stiffness x = force of the leg (sliding); inertia, rocking_stiffness (rocking at arm)",
    source="definition; damper from the ratio to the critical one of mount and leg together",
    way="structure",
    where="base",
    parameters=(
        Parameter("stiffness", "N/m", 0.0, stiff(30.0, 400.0), meaning="against sliding sideways"),
        Parameter("mass", "kg", 0.0, positive(0.3, 1.0), meaning="of the part of the mount that slides"),
        Parameter("rocking_stiffness", "N*m/rad", 0.0, stiff(30.0, 400.0), meaning="against rocking"),
        Parameter("arm", "m", 0.0, signed(1.5), meaning="distance of the first joint below the rocking point"),
        Parameter("inertia", "kg*m^2", 0.0, positive(0.3, 1.0), meaning="of the part of the mount that rocks"),
        Parameter("damping_ratio", "1", 0.05, positive(0.05, 0.7, upper=0.7), natural=False),
    ),
    stated=("stiffness", "rocking_stiffness", "mass", "arm", "inertia"),
    strengths=("stiffness", "rocking_stiffness"),
    bounds="bounded",
    shapes=(
        Shape(
            ("rocking_stiffness", "arm", "inertia", "damping_ratio"),
            {},
            ({"rocking_stiffness": 100.0, "arm": 1.0}, {"rocking_stiffness": 100.0, "arm": -1.0}),
        ),
        Shape(("stiffness", "mass", "damping_ratio"), {}, ({"stiffness": 100.0},)),
        Shape(
            ("stiffness", "mass", "rocking_stiffness", "arm", "inertia", "damping_ratio"),
            {},
            (
                {"stiffness": 100.0, "rocking_stiffness": 100.0, "arm": 1.0},
                {"stiffness": 100.0, "rocking_stiffness": 100.0, "arm": -1.0},
            ),
            richer=True,
        ),
    ),
)
