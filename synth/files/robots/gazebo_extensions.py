"""Gazebo's elements of a URDF: springs of joints, which URDF itself lacks, and what else acts on a leg's motion.

Source of the tags: gazebosim/sdf_tutorials, docs/urdf/sdf_extensions.md, "Elements For Joints" and "For Links".
"""

from __future__ import annotations

from collections.abc import Mapping
from xml.etree.ElementTree import Element

STIFFNESS, REFERENCE = "springStiffness", "springReference"  # N m/rad and rad of a hinge; SDF's axis/dynamics
OF_LINKS = ("turnGravityOff", "gravity", "dampingFactor", "kp", "kd")  # weight, drag of its own, contacts
SHOWN = 4  # names in a sentence


def gazebo_words(root: Element) -> dict[str, Element]:
    """By the name of a joint or link: an element whose attributes are the tags that refer to it, with their texts.

    A tag's number is its text or its attribute ``value``. Of one that is given twice the last holds, as in Gazebo.
    """
    found: dict[str, Element] = {}
    for block in root.findall("gazebo"):
        name = block.get("reference", "")
        if name:
            words = found.setdefault(name, Element("gazebo"))
            for tag in block:
                words.set(str(tag.tag), (tag.get("value") or tag.text or "").strip())
    return found


def spring_words(found: Mapping[str, Element], joints: list[str]) -> str:
    """The sentence on springs: that there are none, or whose are read."""
    sprung = [name for name in joints if name in found and STIFFNESS in found[name].attrib]
    if not sprung:
        return "URDF has no springs"
    more = f" and {len(sprung) - SHOWN} others" if len(sprung) > SHOWN else ""
    return f"the springs are Gazebo's {STIFFNESS} and {REFERENCE} of {', '.join(sprung[:SHOWN])}{more}"


def omitted_of_joint(words: Element | None) -> tuple[str, ...]:
    """A sentence on a joint's tags that are not read."""
    names = [name for name in ({} if words is None else words.attrib) if name not in (STIFFNESS, REFERENCE)]
    return (f"Gazebo's {', '.join(names)} left out",) if names else ()


def omitted_of_links(found: Mapping[str, Element], links: Mapping[str, Element]) -> tuple[str, ...]:
    """A sentence on tags of links that change forces on them."""
    named = [f"{tag} of {name}" for name in links if name in found for tag in OF_LINKS if tag in found[name].attrib]
    if not named:
        return ()
    more = f" and {len(named) - SHOWN} others" if len(named) > SHOWN else ""
    return (f"Gazebo's {', '.join(named[:SHOWN])}{more} left out",)


def omitted_dynamics(dynamics: Element | None) -> tuple[str, ...]:
    """A sentence on attributes of ``dynamics`` that URDF has not: some simulators have a stiffness there."""
    names = [name for name in ({} if dynamics is None else dynamics.attrib) if name not in ("damping", "friction")]
    return (f"{', '.join(names)} of its dynamics left out: URDF has damping and friction alone",) if names else ()
