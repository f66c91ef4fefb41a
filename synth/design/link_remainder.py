"""What a link holds beside its drawn parts: whether it can exist, and the nearest link that can be built.

The figures of a link that includes its joints' parts, less those parts, are the mass, centre and inertia of the rest:
cables, covers, a payload. No rest has less inertia about the hinge than its mass at its centre (Steiner's theorem), nor
more than its mass at the far end of its reach. Figures that ask for such a rest belong to no link with these parts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt

from synth.files.leg_keys import COM_LIMIT
from synth.swing.leg_model import Link
from synth.swing.rigid_body import RigidBody, combined_body, link_body

ROUNDING = 1e-9  # relative: figures that are the drawn parts' own differ from them by the last digits of a file


@dataclass(frozen=True)
class LinkRemainder:
    """The rest of a link: ``mass`` kg > 0, ``centre`` m along the link, ``about_hinge`` kg m^2, as its figures ask.

    ``across`` : of its centre, m; 0 of a link that states none.
    """

    mass: float
    centre: float
    about_hinge: float
    reach: float  # m from the hinge, beyond which no part of a link lies
    across: float = 0.0

    @property
    def least(self) -> float:
        """Least inertia about the hinge of this mass at this centre, kg m^2."""
        return self.mass * (self.centre**2 + self.across**2)

    @property
    def most(self) -> float:
        """Greatest inertia about the hinge of this mass within its reach, kg m^2."""
        return self.mass * self.reach**2

    @property
    def exists(self) -> bool:
        """Whether a body of this mass, centre and inertia lies within its reach of the hinge."""
        allowed = ROUNDING * self.most
        return self.least - allowed <= self.about_hinge <= self.most + allowed

    def within(self, span: tuple[float, float]) -> RigidBody:
        """The nearest rest that exists, its centre within ``span`` m along the link: a rod, or a point.

        It keeps its inertia about the hinge and gives up its centre, as far as the span allows: with the centre kept,
        each gram more of a joint's parts would push the rest outwards and raise the inertia, and with that the spring
        and its own mass; the rounds of parts and masses then went on for ever.
        """
        farthest = sqrt(max(self.about_hinge, 0.0) / self.mass)
        centre = min(max(min(max(self.centre, -farthest), farthest), span[0]), span[1])
        least, most = self.mass * centre**2, self.mass * max(abs(end) for end in span) ** 2
        own = min(max(self.about_hinge, least), most) - least
        return RigidBody(self.mass, (0.0, -centre, 0.0), (own, 0.0, own, 0.0, 0.0, 0.0))


def remainder_of(link: Link, drawn: RigidBody) -> LinkRemainder | None:
    """What the link's figures leave beside its drawn parts; None where these are as heavy or heavier.

    Where the link states no offset of its centre across, the rest is taken on its line, which asks least of it.
    """
    whole = link_body(link)
    mass = whole.mass - drawn.mass
    if mass <= ROUNDING * whole.mass:
        return None
    centre = (whole.mass * link.com + drawn.mass * drawn.centre[1]) / mass
    across = (whole.mass * link.com_across - drawn.mass * drawn.centre[0]) / mass if link.com_across else 0.0
    return LinkRemainder(mass, centre, whole.about_hinge - drawn.about_hinge, COM_LIMIT * link.length, across)


def possible_body(link: Link, drawn: RigidBody, parts: Sequence[RigidBody]) -> RigidBody:
    """The link by its figures where it can hold its drawn ``parts``; else the nearest that can.

    That has the stated mass, and the stated inertia about the hinge where a rest between the hinge and the link's end
    (or a drawn part's centre, or the stated one) can give it. Drawn parts that outweigh the figures are the link.
    """
    rest = remainder_of(link, drawn)
    if rest is None:
        return drawn
    if rest.exists:
        return link_body(link)
    places = (0.0, link.length, link.com, *(-body.centre[1] for body in parts))
    return combined_body([drawn, rest.within((min(places), max(places)))])
