"""What manufacturing and measuring leave open: the nominal leg's numbers as whitened unknowns under priors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from synth.arrays import Array
from synth.swing.leg_lanes import LegLanes
from synth.swing.leg_model import Leg

LINK_QUANTITIES = ("length", "mass", "com", "inertia")
QUANTITIES = (*LINK_QUANTITIES, "spring_rate", "damper_rate", "rest")


class Widths(Protocol):
    """What a project says of its tolerances."""

    def widths(self, leg: Leg) -> Array:
        """(7, n) one standard deviation of each of ``QUANTITIES`` at each joint: shares, of the rests rad."""


@dataclass(frozen=True)
class Tolerances:
    """Unknowns ``x`` (7 n,), standard normal: all joints' lengths, masses, coms, inertias, rates, dampers, rests.

    ``width`` (7, n): relative deviation, of the rests in rad; 0 holds a number at its nominal value.
    """

    width: Array

    @classmethod
    def of(cls, leg: Leg, tolerance: Widths) -> Tolerances:
        """From the project's tolerances."""
        return cls(tolerance.widths(leg))

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return self.width.size

    def apply(self, legs: LegLanes, x: Array) -> None:
        """Change the columns of a leg's lanes by ``x`` (7 n, n_lane).

        Relative errors enter as exponentials, so that no mass turns negative; the same to first order.
        """
        n = self.width.shape[1]
        shift = x.reshape(len(QUANTITIES), n, -1) * self.width[:, :, None]
        for q, name in enumerate(QUANTITIES):
            values = getattr(legs, name)
            if name == "rest":
                values += shift[q]
            else:
                values *= np.exp(shift[q])

    def leg(self, leg: Leg, x: Array) -> Leg:
        """The nominal leg with these errors."""
        n = self.width.shape[1]
        shift = x.reshape(len(QUANTITIES), n) * self.width
        factor = np.exp(shift)
        joints = []
        for j, joint in enumerate(leg.joints):
            link = replace(
                joint.link,
                length=joint.link.length * factor[0, j],
                mass=joint.link.mass * factor[1, j],
                com=joint.link.com * factor[2, j],
                inertia=joint.link.inertia * factor[3, j],
            )
            spring, damper = joint.spring, joint.damper
            if spring is not None:
                angle = spring.free_angle + joint.sign * shift[6, j]
                spring = replace(spring, rate=spring.rate * factor[4, j], free_angle=angle)
            if damper is not None and damper.rate is not None:
                damper = replace(damper, rate=damper.rate * factor[5, j])
            joints.append(replace(joint, link=link, spring=spring, damper=damper))
        return replace(leg, joints=tuple(joints))
