"""Slips of a leg file that are no unit: another zero, an inertia about the joint, a centre of mass from the far end."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from synth.swing.leg_model import Leg, Link

if TYPE_CHECKING:
    from synth.files.trial_list import Trial

# From the stated zero to readings that joints are usually given where a link points along its parent: straight up, or
# bent at a right angle to either side.
ZEROS = tuple(float(np.radians(turn)) for turn in (180.0, 90.0, -90.0))


@dataclass(frozen=True)
class OtherZero:
    """A joint whose ``zero``, rad, and ``sign`` in the leg file are not those of its column."""

    joint: int
    zero: float
    sign: int
    text: str
    remedy: str
    either: tuple[str, str] | None = None
    scale: float = 1.0
    must_follow: bool = True

    def of_leg(self, leg: Leg) -> Leg:
        """With the other zero; the spring's free angle and the commands stay, in measured angle."""
        joints = list(leg.joints)
        joints[self.joint] = replace(joints[self.joint], zero=self.zero, sign=self.sign)
        return replace(leg, joints=tuple(joints))

    def of(self, leg: Leg, trial: Trial) -> Trial:
        """The columns stay as they are."""
        return trial


# Least factor between a number as stated and as meant: a built link differs by less, and that is a cause,
# ``link_inertia``.
LEAST_RATIO = 1.5


class _Meaning(NamedTuple):
    """What a link's number may mean: the link if it does, None if it cannot; what is seen, and its remedy."""

    link: Callable[[Link], Link | None]
    text: str
    remedy: str


def _about_its_centre(link: Link) -> Link | None:
    """With the moment of inertia that is left of one about the joint, by Steiner's theorem."""
    left = link.inertia - link.mass * (link.com**2 + link.com_across**2)
    return replace(link, inertia=left) if 0.0 < LEAST_RATIO * left < link.inertia else None


def _from_its_joint(link: Link) -> Link | None:
    """With the centre of mass from the proximal joint, of one from the far end."""
    other = link.length - link.com
    far = 0.0 < LEAST_RATIO * min(other, link.com) < max(other, link.com)
    return replace(link, com=other) if far else None


def _on_the_other_side(link: Link) -> Link | None:
    """With the centre of mass as far on the other side of its line."""
    return replace(link, com_across=-link.com_across) if link.com_across else None


MEANINGS: Mapping[str, _Meaning] = {
    "inertia": _Meaning(
        _about_its_centre,
        "the inertia of {} looks stated about the joint",
        "state it about the link's centre of mass: inertia about the joint less mass times com squared",
    ),
    "com": _Meaning(
        _from_its_joint,
        "the centre of mass of {} looks stated from the far end",
        "state com from the link's own joint: its length less the stated one",
    ),
    "com_across": _Meaning(
        _on_the_other_side,
        "the centre of mass of {} looks stated on the wrong side of its line",
        "change the sign of com_across: it is positive on the right of a link that hangs down",
    ),
}


@dataclass(frozen=True)
class OtherMeaning:
    """Links whose ``number``, of ``MEANINGS``, means something else than the leg file takes it for."""

    joints: tuple[int, ...]
    number: str
    text: str
    remedy: str
    either: tuple[str, str] | None = None
    scale: float = 1.0
    must_follow: bool = True

    def of_leg(self, leg: Leg) -> Leg:
        """With the numbers as they are meant; one that cannot be meant so stays."""
        joints = list(leg.joints)
        for j in self.joints:
            joints[j] = replace(joints[j], link=MEANINGS[self.number].link(joints[j].link) or joints[j].link)
        return replace(leg, joints=tuple(joints))

    def of(self, leg: Leg, trial: Trial) -> Trial:
        """The columns stay as they are."""
        return trial


def leg_changes(leg: Leg) -> list[OtherZero | OtherMeaning]:
    """All slips of the leg file; of those that fit alike the first is meant."""
    return [*_other_zeros(leg), *_other_meanings(leg)]


def _other_meanings(leg: Leg) -> list[OtherMeaning]:
    """Of all links for which it is possible, and of each alone."""
    made = []
    for number, meaning in MEANINGS.items():
        may = [j for j, joint in enumerate(leg.joints) if meaning.link(joint.link) is not None]
        for joints in [tuple(may), *((j,) for j in may if len(may) > 1)] if may else []:
            names = " and ".join(leg.joint_names[j] for j in joints)
            made.append(OtherMeaning(joints, number, meaning.text.format(names), meaning.remedy))
    return made


def _other_zeros(leg: Leg) -> list[OtherZero]:
    """Each joint with a usual reading elsewhere as its zero, turning as stated or, after those, the other way."""
    made = []
    for sign in (1, -1):
        for j, joint in enumerate(leg.joints):
            for turn in ZEROS:
                zero = _within_a_turn(joint.zero + turn)
                signs = [f", sign: {each:+d}" if sign < 0 else "" for each in (joint.sign, -joint.sign)]
                text = f"{joint.name}: zero: {_degrees(joint.zero)}{signs[0]} is stated"
                text += f" and zero: {_degrees(zero)}{signs[1]} fits"
                remedy = "correct it in the leg file, or the column: zero is the reading where the link points " + (
                    "straight down" if j == 0 else "along the link before it"
                )
                made.append(OtherZero(j, zero, sign * joint.sign, text, remedy))
    return made


def _degrees(angle: float) -> str:
    """``90 deg``; what is left of 0 by arithmetic is 0."""
    return f"{round(float(np.degrees(angle)), 4) + 0.0:g} deg"


def _within_a_turn(angle: float) -> float:
    """rad, above minus half a turn, up to half a turn."""
    return -((np.pi - angle) % (2.0 * np.pi) - np.pi)
