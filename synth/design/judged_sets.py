"""How good a set of parts is: its error with nominal parts, and what is to be expected of it with real ones.

A spring's free angle is open by 10 degrees and more, which would drown everything else, and favour joints too sluggish
to reach where a wrong spring pulls them. But it is measured in a minute and the arm's seat set by it, so sets are
chosen by what is to be expected then (``ready``); what parts give as they come is told beside it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import radians

import numpy as np

from synth.arrays import Array
from synth.design.choose_dampers import DamperOption
from synth.design.choose_springs import SpringOption
from synth.design.forecast import Forecast, Forecaster
from synth.design.part_lanes import Acting, PartLanes
from synth.design.response import WantedResponse
from synth.files.project_options import PartsOptions
from synth.swing.leg_model import Leg, Spring

SAMPLES_SHOWN, SAMPLES_CHOSEN = 64, 256  # draws of the tolerances: to compare and show, to report
RELEASES = 7  # about so many serve for tolerances
MEASURED_ANGLE = radians(1.0)  # what a protractor leaves open


@dataclass(frozen=True)
class Pair:
    """A spring and a damper at one joint."""

    spring: SpringOption
    damper: DamperOption


Pairs = tuple[Pair, ...]


def acting(pairs: Sequence[Pair]) -> list[Acting]:
    """What the pairs do at their joint."""
    return [Acting(pair.spring.rate, pair.damper.damper) for pair in pairs]


class Judge:
    """Measures sets of parts in one leg against the wanted motion.

    Parameters
    ----------
    wanted
        the motion and its releases.
    leg
        what the parts are put into: links and effects count.
    parts
        tolerances, and the error within which the response is to stay.
    seed
        of the draws, the same for every set.
    barred
        dampers, by their labels, that may not stand together.
    """

    def __init__(
        self,
        wanted: WantedResponse,
        leg: Leg,
        parts: PartsOptions,
        seed: int,
        barred: frozenset[tuple[str, ...]] = frozenset(),
    ) -> None:
        self.wanted, self.leg, self.barred = wanted, leg, barred
        none: list[list[Acting]] = [[] for _ in leg.joints]
        self._lanes = PartLanes(wanted, leg, none)
        few = PartLanes(wanted, leg, none, RELEASES)
        asked = parts.tolerance
        least = min(MEASURED_ANGLE, MEASURED_ANGLE if asked.free_angle is None else asked.free_angle)
        self._as_they_come = Forecaster(few, asked, parts.within, seed)
        self._ready = Forecaster(few, replace(asked, free_angle=least), parts.within, seed)

    def allows(self, pairs: Pairs) -> bool:
        """Whether the set's dampers may stand together."""
        return tuple(pair.damper.label for pair in pairs) not in self.barred

    def errors(self, sets: Sequence[Pairs]) -> Array:
        """(n_set,) rad, RMS over joints and all releases with nominal parts."""
        if not sets:
            return np.zeros(0)
        joints = [[each[j] for each in sets] for j in range(len(self.leg.joints))]
        lanes = PartLanes(self.wanted, self.leg, [acting(pairs) for pairs in joints])
        return lanes.errors(np.repeat(np.arange(len(sets))[:, None], len(joints), axis=1))

    def ready(self, pairs: Pairs, n_sample: int = SAMPLES_SHOWN, *, shares: bool = False) -> Forecast:
        """What is to be expected of a set whose springs were measured and set; this is what sets are chosen by.

        Sets are compared on equal draws where ``n_sample`` is equal.
        """
        return self._ready.forecast([(pair.spring, pair.damper) for pair in pairs], n_sample, shares=shares)

    def expected(self, pairs: Pairs, n_sample: int = SAMPLES_SHOWN) -> float:
        """Expected error (rad) of ``ready``, and nothing else of it."""
        return self._ready.expected([(pair.spring, pair.damper) for pair in pairs], n_sample)

    def as_they_come(self, pairs: Pairs, n_sample: int = SAMPLES_SHOWN, *, shares: bool = False) -> Forecast:
        """What is to be expected of a set if its arms are where the catalogue's free angles have them."""
        return self._as_they_come.forecast([(pair.spring, pair.damper) for pair in pairs], n_sample, shares=shares)

    def built(self, pairs: Pairs) -> Leg:
        """The leg with a set of parts, resting as wanted."""
        joints = []
        for j, (joint, pair) in enumerate(zip(self.leg.joints, pairs, strict=True)):
            free = joint.zero + joint.sign * self._lanes.rest(j, pair.spring.rate)
            joints.append(replace(joint, spring=Spring(pair.spring.rate, free), damper=pair.damper.damper))
        return replace(self.leg, joints=tuple(joints))
