"""Forces on a chain from outside: the weight that a robot's file compensates, and contacts, which a leg has not."""

from __future__ import annotations

from collections.abc import Sequence

from synth.errors import UserError
from synth.files.robots.robot_tree import Robot

ALIKE = 1e-9  # of the weight, rounding of one share written twice
SHOWN = 4  # names in a sentence


def felt_share(robot: Robot, groups: Sequence[Sequence[int]], messages: list[str]) -> float:
    """The share of gravity that the chain's bodies feel.

    A leg has one gravity for weight; inertia is apart from it. So equal compensation is a lower gravity, exactly.

    Raises
    ------
    UserError : the bodies' shares differ, or more than the weight is compensated.
    """
    bodies = [robot.bodies[index] for group in groups for index in group if robot.bodies[index].mass > 0.0]
    shares = [body.weightless for body in bodies]
    if not any(robot.gravity) or not any(shares):
        return 1.0
    if max(shares) - min(shares) > ALIKE or max(shares) > 1.0 + ALIKE:
        some = ", ".join(f"{body.name} {body.weightless:g}" for body in bodies[:SHOWN])
        more = f" and {len(bodies) - SHOWN} others" if len(bodies) > SHOWN else ""
        text = f"gravcomp of the chain's bodies is {some}{more}: a leg has one gravity for all its links; give every "
        raise UserError(f"{text}body below the chain's first joint the same gravcomp from 0 to 1")
    text = f"gravcomp compensates {shares[0]:.4g} of the weight: the leg's gravity is the rest"
    messages.append(f"{text}; that of a trial's tip mass would be reduced as well")
    return max(0.0, 1.0 - shares[0])


def contact_messages(robot: Robot, groups: Sequence[Sequence[int]]) -> list[str]:
    """Sentences that name the links' contacts with what is fixed in the world, and with moving bodies."""
    link = {body: number for number, group in enumerate(groups) for body in group}
    fixed: dict[str, None] = {}
    moving: dict[str, None] = {}
    for contact in robot.contacts:
        one, other = link.get(contact.body), link.get(contact.other)
        if one is None and other is None:
            continue  # not of the chain
        if one is not None and one == other:
            continue  # within one link
        (fixed if contact.other < 0 else moving)[f"{robot.bodies[contact.body].name} and {contact.other_name}"] = None
    found = []
    for names, what in (
        (list(fixed), "what is fixed in the world"),
        (list(moving), "one another and with other parts"),
    ):
        if names:
            more = f", and {len(names) - SHOWN} other pairs" if len(names) > SHOWN else ""
            found.append(f"contacts of the links with {what} are left out: {', '.join(names[:SHOWN])}{more}")
    return found
