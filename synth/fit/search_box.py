"""How far a fit searches: bounds of the rates and rest angles, and the unit of time of its constants.

Both follow from the recordings, so that an insect's joint at 200 Hz, a crane and a damper a thousand times as strong
as its link are fitted as a limb is. The recordings' pace is half a radian of the fastest motion seen (``synth.pace``),
and about a quarter of the time constant of a joint that creeps.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.motion.time_step import USUAL
from synth.swing.leg_model import Leg
from synth.swing.mechanics import coefficients, outboard_inertia

# Greatest damper rate over inertia, times the pace. A joint of the time constant of four paces would then come to its
# creeping within a thousandth of it, which no recording shows.
MOST_DAMPING = 1000.0
# The same, times the interval of the samples: what decays by exp(30) from one to the next is not in them. A stronger
# damper fits them no better, and only shortens the integrator's steps.
MOST_DECAY = 30.0
# The same, times the recording's length and the square of the joint's frequency under gravity alone: a strong damper's
# rate shows in how gravity moves it, however little its inertia does.
MOST_CREEP = 10.0
# greatest spring rate over that damper rate, times the pace: a joint that creeps at the pace, sixteenfold
MOST_STIFFNESS = 4.0
# Least rates over inertia, times the length and its square: a thousandth of a swing, a swing that loses 5e-5 of it.
SWUNG, LOST = 2.0 * np.pi * 1e-3, 1e-4
TURNS = 4.0 * np.pi  # rad beyond the recorded angles, of a rest angle
NEAR_LOGARITHM, NEAR_ANGLE = np.log(2.0), 1.0  # of a logarithm, and rad: an estimate so near to a bound counts as at it


@dataclass(frozen=True)
class SearchBox:
    """``pace`` s and ``interval`` s of the samples, the shortest, and ``length`` s, the longest of the recordings.

    ``unit`` s, see ``Recording``.
    ``angles`` : lowest and highest recorded rotation of each joint, rad; empty: zero. The defaults are a limb's.
    """

    pace: float = USUAL
    length: float = 1.0
    interval: float = 1e-3
    unit: float = 1.0
    angles: tuple[tuple[float, float], ...] = ()

    def rates(self, leg: Leg) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
        """Logarithms (n,) of the least and the greatest spring rate (N m/rad), and of those of the damper rate."""
        inertia = outboard_inertia(leg)
        weight = np.cumsum(coefficients(leg).weight[::-1])[::-1]
        decay = np.maximum(
            min(MOST_DAMPING / self.pace, MOST_DECAY / self.interval), MOST_CREEP * self.length * weight / inertia
        )
        springs = inertia * (SWUNG / self.length) ** 2, inertia * decay * MOST_STIFFNESS / self.pace
        dampers = inertia * LOST / self.length, inertia * decay
        return (np.log(springs[0]), np.log(springs[1])), (np.log(dampers[0]), np.log(dampers[1]))

    def rests(self, n: int, beyond: float = TURNS) -> tuple[Array, Array]:
        """(n,) rad, the least and the greatest rest angle: so far ``beyond`` the recorded ones, rad."""
        low, high = np.array(self.angles or ((0.0, 0.0),) * n).T
        return low - beyond, high + beyond

    def steps(self, leg: Leg) -> int:
        """Integration steps that the strongest damper of the box may need: it limits them to a few time constants."""
        inertia = outboard_inertia(leg)
        return int(np.max(np.exp(self.rates(leg)[1][1]) / inertia) * self.length)


LIMB = SearchBox()  # without recordings
