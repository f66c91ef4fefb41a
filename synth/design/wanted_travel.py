"""The travel of a joint's spring from its free angle, and the seat in which it winds the spring."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import radians

import numpy as np

from synth.arrays import Array
from synth.swing.leg_model import Leg


@dataclass(frozen=True)
class WantedTravel:
    """Travel of a joint's spring from its free angle, rad: that which winds it, and that which opens it.

    ``turned_round``: larger measured angles close its arms; in a joint drawn as the thesis' smaller ones do.
    """

    winding: float
    opening: float
    turned_round: bool = False

    @classmethod
    def of_sides(cls, below: float, above: float) -> WantedTravel:
        """The travel (rad) at smaller and at larger angles: turned round if it is mainly towards larger ones."""
        turned = above >= 2.0 * below and above >= radians(2.0)
        return cls(above, below, turned_round=True) if turned else cls(below, above)


def travels(leg: Leg, motions: Sequence[Array]) -> list[WantedTravel]:
    """Each spring's travel from its free angle: over the joint's range if the leg states one, else over the motions.

    ``motions`` : (m, n) rotations, rad.
    """
    found = []
    for j, joint in enumerate(leg.joints):
        assert joint.spring is not None
        if joint.range is not None:
            ends = [angle - joint.spring.free_angle for angle in joint.range]
        else:
            turned = joint.sign * (np.concatenate([motion[:, j] for motion in motions]) - joint.rest)
            ends = [float(turned.min()), float(turned.max())]
        found.append(WantedTravel.of_sides(abs(min(0.0, *ends)), abs(max(0.0, *ends))))
    return found
