"""The links of the built leg: mass properties from the target's file, plus those of drawn and bought parts.

The upper half of a joint belongs to the link before it, the lower half to its own link. Half of a spring belongs to
each, because each of its ends moves with one half. The target's file states what a link's figures include:

- ``includes: none``: the link without its joints' parts. The parts are added; the drawn tube is the link itself.
- ``includes: joint``: everything. The figures are used, unless no link with the drawn parts has them: then the nearest
  that can be built, see ``link_remainder``. Drawn parts that alone weigh more are the link.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import sqrt
from typing import Any

from synth.design.link_remainder import LinkRemainder, possible_body, remainder_of
from synth.design.part_masses import PartMass
from synth.remarks import Remark, noted
from synth.swing.leg_model import Leg, Link
from synth.swing.rigid_body import RigidBody, combined_body, link_body, offset_torque
from synth.units import quantity

WORTH_SAYING = 0.10  # of a link's mass or inertia about its joint: the limit for a warning, from the requirements
SPRING_SHARE = 0.5  # of a spring, to either half: each end moves with one half, the middle by half the angle
SAME_LINK = 5e-3  # relative: links whose mass and inertia about the joint differ by less move alike


@dataclass(frozen=True)
class BuiltLink:
    """One link: as given in the target's file, its parts as drawn, and as simulated.

    ``parts`` : name, mass (kg) on this link, source of the mass. ``drawn``: tube and parts together; without the tube
    for links whose figures include none of their joints' parts. ``body`` is the built link as a rigid body in space,
    with the properties that a planar leg does not use.
    """

    joint: str
    assumed: Link
    drawn: RigidBody
    body: RigidBody
    parts: tuple[tuple[str, float, str], ...]

    @property
    def link(self) -> Link:
        """The planar link that is simulated; its figures include all parts."""
        return self.body.link(self.assumed.length)

    @property
    def stands(self) -> bool:
        """Whether the link's own figures are simulated unchanged."""
        return self.body == link_body(self.assumed)

    @property
    def share(self) -> float:
        """Relative difference of simulated and assumed mass, centre or inertia about the joint, whichever is larger."""
        return _difference(self.link, self.assumed)

    @property
    def rest(self) -> LinkRemainder | None:
        """What the assumed figures leave beside the drawn parts; None where they include none, or weigh no more."""
        return remainder_of(self.assumed, self.drawn) if self.assumed.includes == "joint" else None

    def as_json(self, gravity: float) -> dict[str, Any]:
        """The link's entry under ``links`` in ``design.json``."""
        return {
            "includes": self.assumed.includes,
            "assumed": _figures(link_body(self.assumed)),
            "built": {**_figures(self.body), "com_across": quantity(self.body.centre[0], "mm")},
            "drawn": _figures(self.drawn),
            "offset_torque": quantity(offset_torque(self.body, gravity), "N*m"),
            "parts": [{"part": n, "mass": quantity(mass, "g"), "basis": basis} for n, mass, basis in self.parts],
        }


def _figures(body: RigidBody) -> dict[str, Any]:
    return {
        "mass": quantity(body.mass, "g"),
        "com": quantity(-body.centre[1], "mm"),
        "inertia": quantity(body.inertia[2], "kg*m^2"),
    }


def built_links(target: Leg, masses: Sequence[PartMass]) -> tuple[BuiltLink, ...]:
    """Every link of the target with its parts, proximal to distal."""
    return tuple(_built(target, index, masses) for index in range(len(target.joints)))


def _built(target: Leg, index: int, masses: Sequence[PartMass]) -> BuiltLink:
    joint = target.joints[index]
    shares = _shares(target, index, masses)
    added = [item for item in shares if joint.link.includes == "joint" or item[0].family != "link"]
    bodies = [body for _, body in added]
    drawn = combined_body(bodies)
    if joint.link.includes == "none":
        body = combined_body([link_body(joint.link), drawn])
    else:
        body = possible_body(joint.link, drawn, bodies)
    parts = tuple((item.part, part.mass, item.basis) for item, part in added)
    return BuiltLink(joint.name, joint.link, drawn, body, parts)


def _shares(target: Leg, index: int, masses: Sequence[PartMass]) -> list[tuple[PartMass, RigidBody]]:
    """Parts that move with a link, each with the share that does, in the frame of the link's own joint."""
    name, found = target.joint_names[index], []
    end = (0.0, -target.joints[index].link.length, 0.0)
    after = target.joint_names[index + 1] if index + 1 < len(target.joints) else None
    for item in masses:
        if item.joint == name and item.moves_with == "lower":
            found.append((item, item.body))
        elif item.joint == name and item.moves_with == "spring":
            found.append((item, item.body.share(SPRING_SHARE)))
        elif item.joint == after and item.moves_with == "upper":
            found.append((item, item.body.shifted(end)))
        elif item.joint == after and item.moves_with == "spring":
            found.append((item, item.body.share(1.0 - SPRING_SHARE).shifted(end)))
    return found


def with_links(leg: Leg, links: Sequence[BuiltLink]) -> Leg:
    """The leg with its links as built."""
    joints = (replace(joint, link=link.link) for joint, link in zip(leg.joints, links, strict=True))
    return replace(leg, joints=tuple(joints))


def same_links(one: Leg, other: Leg, within: float = SAME_LINK) -> bool:
    """Whether the links of both legs have the same mass, centre and inertia about the joint, ``within`` relative."""
    pairs = zip(one.joints, other.joints, strict=True)
    return all(_difference(first.link, second.link) < within for first, second in pairs)


def midway_links(one: Leg, other: Leg) -> Leg:
    """The first leg with links that have the mean mass, centre and inertia about the joint of both legs' bodies."""
    joints = []
    for joint, beside in zip(one.joints, other.joints, strict=True):
        mean = combined_body(link_body(each.link).share(0.5) for each in (joint, beside)).link(joint.link.length)
        joints.append(replace(joint, link=replace(mean, includes=joint.link.includes)))
    return replace(one, joints=tuple(joints))


def turns_back(first: Leg, second: Leg, third: Leg) -> bool:
    """Whether links that changed from the ``first`` leg to the ``second`` change back, on the whole, to the ``third``.

    By the sum over links of the products of both changes of mass, centre and inertia about the joint, each relative as
    in ``_difference``.
    """
    product = 0.0
    for joints in zip(first.joints, second.joints, third.joints, strict=True):
        one, two, three = (_relative(joint.link, joints[1].link) for joint in joints)
        product += sum((b - a) * (c - b) for a, b, c in zip(one, two, three, strict=True))
    return product < 0.0


def _relative(link: Link, other: Link) -> tuple[float, float, float, float]:
    """Mass, centre along and across, and inertia about the joint of a link relative to those of another; its centre in
    radii of gyration of the other about the joint.
    """
    about = other.about_joint
    gyration = sqrt(about / other.mass)
    return link.mass / other.mass, link.com / gyration, link.com_across / gyration, link.about_joint / about


def _difference(one: Link, other: Link) -> float:
    """The largest relative difference of two links' figures; of the centre in radii of gyration about the joint."""
    return max(abs(a - b) for a, b in zip(_relative(one, other), _relative(other, other), strict=True))


STATE = "State the link's mass properties and what they include: `link: {..., includes: none}`."


def link_warnings(links: Sequence[BuiltLink], assumed: Mapping[str, str]) -> list[tuple[str, str]]:
    """Joint and warning for each link whose built mass properties differ from the assumed ones.

    ``assumed``: parts whose mass is assumed, with the basis of the assumption.
    """
    warnings: list[tuple[str, str]] = []
    for item in links:
        found = _difference_remark(item)
        if found:
            warnings.append((item.joint, found))
        named = [name for name, _, _ in item.parts if name in assumed]
        if named:
            grams = 1e3 * sum(mass for name, mass, _ in item.parts if name in named)
            text = (
                f"{item.joint}: {grams:.0f} g of its link's {item.body.mass * 1e3:.0f} g are assumed masses of "
                f"{', '.join(named)}: weigh them and write cad: {{masses: {{{named[0]}: ... g}}}}"
            )
            warnings.append((item.joint, text))
    return warnings


def _difference_remark(item: BuiltLink) -> str:
    """What the built link has that the target's file does not say, or the other way round; empty if nothing."""
    if item.share > WORTH_SAYING:
        return Remark(_difference_words(item), "check", STATE)
    if item.share > SAME_LINK:
        return noted(_difference_words(item))
    rest = item.rest
    if rest is None or rest.mass < WORTH_SAYING * item.assumed.mass:
        return ""
    return (
        f"{item.joint}: its link is simulated with the target's {item.assumed.mass * 1e3:.0f} g, but the drawn tube "
        f"and joint parts weigh {item.drawn.mass * 1e3:.0f} g. If the link has no other parts of "
        f"{rest.mass * 1e3:.0f} g, with their centre at {rest.centre * 1e3:.0f} mm, correct the target's figures"
    )


def _difference_words(item: BuiltLink) -> str:
    own, built, rest = link_body(item.assumed), item.body, item.rest
    centre = f"its centre at {-built.centre[1] * 1e3:.0f} instead of {-own.centre[1] * 1e3:.0f} mm"
    about = f"{built.about_hinge:.3g} instead of {own.about_hinge:.3g} kg*m^2 about the joint"
    figures = f"{built.mass * 1e3:.0f} g instead of {own.mass * 1e3:.0f} g, {centre}, {about}"
    if item.assumed.includes == "none":
        return f"{item.joint}: with its joints' parts the link has {figures}; the leg is designed with these values"
    if rest is not None:
        same = abs(built.about_hinge / own.about_hinge - 1.0) < SAME_LINK
        kept = f"its mass and inertia about the joint and {centre}" if same else f"its mass, {centre}, {about}"
        place = (item.drawn.mass * item.drawn.centre[1] - built.mass * built.centre[1]) / rest.mass
        where = f"as if these {rest.mass * 1e3:.0f} g lay about {place * 1e3:.0f} mm from the joint"
        return f"{item.joint}: {_impossible_words(item, rest)}. The leg is designed with {kept}, {where}"
    return (
        f"{item.joint}: the link as drawn, tube and joints' parts, ends up at {figures}: the target's figures do not "
        "fit what they are to hold; the leg is designed with the drawn ones"
    )


def _impossible_words(item: BuiltLink, rest: LinkRemainder) -> str:
    low = rest.about_hinge < rest.least
    limit = f"at least {rest.least:.3g}" if low else f"at most {rest.most:.3g}"
    return (
        f"no link with the drawn tube and joint parts has the target's figures. The parts weigh "
        f"{item.drawn.mass * 1e3:.0f} g and have {item.drawn.about_hinge:.3g} kg*m^2 about the joint; the other "
        f"{rest.mass * 1e3:.0f} g would have their centre at {rest.centre * 1e3:.0f} mm and {rest.about_hinge:.3g} "
        f"kg*m^2, where {limit} is possible"
    )
