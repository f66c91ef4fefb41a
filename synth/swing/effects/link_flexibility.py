"""A link, or its coupling to the joint, that bends: an additional hinge with a stiff spring."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from synth.swing.effects.definition import Effect, Parameter, Shape, positive, stiff

if TYPE_CHECKING:
    from synth.arrays import Array
    from synth.swing.leg_lanes import LegLanes

HUB = 0.1  # share of the link's inertia about its joint that remains at the joint if the coupling bends
# Least shares that the part beyond the bend has: of that inertia, about its own centre of mass, and of the link's mass.
# The last tenth of a uniform rod has 2.5 times that inertia.
LEAST_DISTAL, LEAST_DISTAL_MASS = 1e-4, 0.01
DAMPING_RATIO = 0.1  # of a bending link where none is given; assumed, of the order of printed plastics


def extend(legs: LegLanes, joint: int, stiffness: Array, place: Array, damping_ratio: Array) -> LegLanes:
    """Cut the joint's link at ``place`` (share of its length) and connect the parts by a hinge with a spring.

    Total mass, first moment and inertia remain those of the link. From these follow the masses of a uniform rod, a hub
    at the joint and a weight at the end, and the proximal part is the hub with its piece of the rod. It also has a
    moment of inertia where less than the share ``HUB`` would remain at the joint. It is less where a link's mass is so
    concentrated that the distal part would have no inertia left. The centres of mass of both parts lie as far beside
    the link's line as its own, so that what follows holds along the line alone.
    """
    length, mass, com, inertia = (getattr(legs, name)[joint] for name in ("length", "mass", "com", "inertia"))
    about_joint = inertia + mass * com**2
    share = np.broadcast_to(np.asarray(place, dtype=float), length.shape)
    least = np.minimum(LEAST_DISTAL * about_joint, 0.5 * inertia)
    rod = np.maximum(6.0 * (mass * com - about_joint / length) / length, 0.0)
    weight = mass * com / length - 0.5 * rod
    hub = np.maximum(mass - rod - weight, 0.0) * (share > 0.0)  # at a cut at the joint it moves with either part alike
    wanted = hub + share * rod
    of_rod = np.divide(share * rod, wanted, out=np.zeros_like(wanted), where=wanted > 0.0)
    near_com = 0.5 * of_rod * share * length  # m
    own = of_rod * (share * length) ** 2 / 3.0 - near_com**2  # m^2, inertia about that over mass
    near_mass = np.minimum(wanted, (1.0 - LEAST_DISTAL_MASS) * mass)
    near_mass = np.minimum(near_mass, _most_proximal(mass, com, inertia, near_com, own, least))
    near_inertia = near_mass * own
    far_mass = mass - near_mass
    far_com = (mass * com - near_mass * near_com) / far_mass  # from the joint
    far_inertia = about_joint - near_inertia - near_mass * near_com**2 - far_mass * far_com**2
    remains = near_inertia + near_mass * near_com**2 + far_mass * (share * length) ** 2
    added = np.clip(HUB * about_joint - remains, 0.0, np.maximum(far_inertia - least, 0.0))
    near_inertia, far_inertia = near_inertia + added, far_inertia - added
    across = legs.com_across[joint]
    moving = far_inertia + far_mass * ((far_com - share * length) ** 2 + across**2)
    made = legs.with_link(
        joint + 1,
        length=(1.0 - share) * length,
        mass=far_mass,
        com=far_com - share * length,
        com_across=across,
        inertia=far_inertia,
        spring_rate=stiffness,
        damper_rate=2.0 * damping_ratio * np.sqrt(stiffness * moving),
    )
    made.length[joint] = share * length
    made.mass[joint] = near_mass
    made.com[joint] = near_com
    made.inertia[joint] = near_inertia
    return made


def _most_proximal(mass: Array, com: Array, inertia: Array, near_com: Array, own: Array, least: Array) -> Array:
    """Mass (n_lane,) kg of the proximal part that leaves the distal one the inertia ``least`` about its centre of mass.

    The smaller root x of ``own x^2 - b x + mass (inertia - least) = 0``, which the sums of mass, first moment and
    inertia give; ``own`` m^2, the part's inertia about its centre of mass over its mass.
    """
    left = mass * (inertia - least)
    b = inertia - least + mass * ((com - near_com) ** 2 + own)
    return np.asarray(2.0 * left / (b + np.sqrt(b**2 - 4.0 * own * left)))


def start(legs: LegLanes, joint: int, rotation: Array) -> Array:
    """Bend (n_lane,) rad at the release, due to the joint's spring while a force holds the end of the link.

    The force's moment about the bend is less than about the joint, by the bend's place.
    """
    torque = legs.spring_rate[joint] * (rotation[joint] - legs.rest[joint])
    share = legs.length[joint + 1] / (legs.length[joint] + legs.length[joint + 1])
    return np.asarray(share * torque / legs.spring_rate[joint + 1])


EFFECT = Effect(
    name="link_flexibility",
    meaning="a link, or its coupling to the joint, bends",
    phrase="carries a link, or a coupling to it, that bends",
    formula="the link cut at place (share of its length), its parts joined by stiffness and a damper",
    source="pseudo-rigid-body model: Howell, Compliant Mechanisms (2001), ch. 5",
    way="structure",
    shows_locked=True,
    parameters=(
        Parameter("stiffness", "N*m/rad", prior=stiff(20.0, 200.0), meaning="of the hinge that represents the bend"),
        Parameter(
            "place",
            "1",
            0.0,
            positive(0.3, 0.5, upper=0.8),
            natural=False,
            below=1.0,
            meaning="where it bends, share of the length; 0 is the coupling",
        ),
        Parameter(
            "damping_ratio",
            "1",
            DAMPING_RATIO,
            positive(0.1, 0.7, upper=0.7),
            natural=False,
            meaning="of the bend, to the critical one of the part beyond it",
        ),
    ),
    strengths=("stiffness",),
    shapes=(
        Shape(("stiffness",), {"place": 0.0}, ({"stiffness": 100.0},)),
        Shape(("stiffness",), {"place": 0.4}, ({"stiffness": 100.0},)),
        Shape(
            ("stiffness", "place", "damping_ratio"),
            {},
            ({"stiffness": 100.0}, {"stiffness": 30.0}, {"stiffness": 10.0}),
            richer=True,
        ),
    ),
)
