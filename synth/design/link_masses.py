"""The links of the built leg: mass properties from the target's file, plus those of drawn and bought parts.

The upper half of a joint belongs to the link before it, the lower half to its own link. Half of a spring belongs to
each, because each of its ends moves with one half. The target's file states what a link's figures include:

- ``includes: none``: the link without its joints' parts. The parts are added; the drawn tube is the link itself.
- ``includes: joint``: everything. The figures are used, unless the drawn parts alone weigh more. Then the figures are
  impossible, and the drawn tube and parts are used.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from synth.design.part_masses import PartMass
from synth.remarks import Remark
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
        """Relative difference of simulated and assumed mass, or of inertia about the joint, whichever is larger."""
        return max(
            abs(self.body.mass / self.assumed.mass - 1.0),
            abs(self.body.about_hinge / link_body(self.assumed).about_hinge - 1.0),
        )

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
    across, along = body.centre[0], -body.centre[1]
    return {
        "mass": quantity(body.mass, "g"),
        "com": quantity(along, "mm"),
        "inertia": quantity(body.inertia[2] + body.mass * across**2, "kg*m^2"),
    }


def built_links(target: Leg, masses: Sequence[PartMass]) -> tuple[BuiltLink, ...]:
    """Every link of the target with its parts, proximal to distal."""
    return tuple(_built(target, index, masses) for index in range(len(target.joints)))


def _built(target: Leg, index: int, masses: Sequence[PartMass]) -> BuiltLink:
    joint = target.joints[index]
    shares = _shares(target, index, masses)
    added = [item for item in shares if joint.link.includes == "joint" or item[0].family != "link"]
    drawn = combined_body(body for _, body in added)
    own = link_body(joint.link)
    stated = drawn if drawn.mass > own.mass else own
    body = combined_body([own, drawn]) if joint.link.includes == "none" else stated
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


def same_links(one: Leg, other: Leg) -> bool:
    """Whether the links of both legs have the same mass and inertia about the joint, within ``SAME_LINK``."""
    return all(
        abs(a / b - 1.0) < SAME_LINK
        for first, second in zip(one.joints, other.joints, strict=True)
        for a, b in (
            (first.link.mass, second.link.mass),
            (link_body(first.link).about_hinge, link_body(second.link).about_hinge),
        )
    )


STATE = "State the link's mass properties and what they include: `link: {..., includes: none}`."


def link_warnings(links: Sequence[BuiltLink], assumed: Mapping[str, str]) -> list[tuple[str, str]]:
    """Joint and warning for each link whose built mass properties differ from the assumed ones.

    ``assumed``: parts whose mass is assumed, with the basis of the assumption.
    """
    warnings: list[tuple[str, str]] = []
    for item in links:
        own, built, drawn = link_body(item.assumed), item.body, item.drawn
        if item.share > WORTH_SAYING:
            warnings.append((item.joint, Remark(_difference_words(item), "check", STATE)))
        elif item.assumed.includes == "joint" and drawn.mass < (1.0 - WORTH_SAYING) * own.mass:
            text = (
                f"{item.joint}: its link is simulated with the target's {own.mass * 1e3:.0f} g, but the drawn tube and "
                f"joint parts weigh {drawn.mass * 1e3:.0f} g. If the link has no other parts of "
                f"{(own.mass - drawn.mass) * 1e3:.0f} g, correct the target's figures"
            )
            warnings.append((item.joint, text))
        named = [name for name, _, _ in item.parts if name in assumed]
        if named:
            grams = 1e3 * sum(mass for name, mass, _ in item.parts if name in named)
            text = (
                f"{item.joint}: {grams:.0f} g of its link's {built.mass * 1e3:.0f} g are assumed masses of "
                f"{', '.join(named)}: weigh them and write cad: {{masses: {{{named[0]}: ... g}}}}"
            )
            warnings.append((item.joint, text))
    return warnings


def _difference_words(item: BuiltLink) -> str:
    own, built = link_body(item.assumed), item.body
    figures = (
        f"{built.mass * 1e3:.0f} g instead of {own.mass * 1e3:.0f} g, its centre at {-built.centre[1] * 1e3:.0f} "
        f"instead of {-own.centre[1] * 1e3:.0f} mm, {built.about_hinge:.3g} instead of {own.about_hinge:.3g} kg*m^2 "
        "about the joint"
    )
    if item.assumed.includes == "none":
        return f"{item.joint}: with its joints' parts the link has {figures}; the leg is designed with these values"
    return (
        f"{item.joint}: the link as drawn, tube and joints' parts, ends up at {figures}: the target's figures do not "
        "fit what they are to hold; the leg is designed with the drawn ones"
    )
