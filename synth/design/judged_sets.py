"""Evaluation of sets of parts: the error with nominal parts, and the expected error with tolerances.

The free angle of a spring has a tolerance of 10 degrees and more. It would dominate all other tolerances, and favour
joints too slow to reach the rest pose of a wrong spring. It is measured in a minute, and the arm's seat is set by it.
Sets are therefore chosen by the expected error after that measurement (``ready``); the error of unmeasured parts is
reported too (``as_they_come``).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array
from synth.design.choose_dampers import DamperOption
from synth.design.choose_springs import SpringOption
from synth.design.forecast import IN_HAND, Forecast, Forecaster, SpringInHand, free_angles_measured
from synth.design.link_room import LinkRoom
from synth.design.part_lanes import ActingElements, PartLanes
from synth.design.response import WantedResponse
from synth.files.project_options import PartsOptions
from synth.swing.leg_model import Leg, Spring

SAMPLES_SHOWN, SAMPLES_CHOSEN = 64, 256  # draws of the tolerances: to compare and list sets, to report the chosen one
RELEASES = 7  # approximate number of releases that are simulated with tolerances


@dataclass(frozen=True)
class Pair:
    """A spring and a damper at one joint."""

    spring: SpringOption
    damper: DamperOption


Pairs = tuple[Pair, ...]


def acting_elements(pairs: Sequence[Pair]) -> list[ActingElements]:
    """The spring rates and dampers of the pairs, as they act at their joint."""
    return [ActingElements(pair.spring.rate, pair.damper.damper) for pair in pairs]


class Judge:
    """Evaluates sets of parts in one leg against the wanted motion.

    Parameters
    ----------
    wanted
        the motion and its releases.
    leg
        the leg for the parts: its links and effects are used.
    parts
        tolerances, and the required limit of the response error.
    seed
        of the draws, the same for every set.
    barred
        combinations of dampers, by their labels, that are excluded.
    in_hand
        measured springs, by the number of their joint.
    room
        the links that the parts must fit; None: they need no room.
    """

    def __init__(
        self,
        wanted: WantedResponse,
        leg: Leg,
        parts: PartsOptions,
        seed: int,
        barred: frozenset[tuple[str, ...]] = frozenset(),
        in_hand: Mapping[int, SpringInHand] = IN_HAND,
        room: LinkRoom | None = None,
    ) -> None:
        self.wanted, self.leg, self.barred, self.room = wanted, leg, barred, room
        none: list[list[ActingElements]] = [[] for _ in leg.joints]
        self._lanes = PartLanes(wanted, leg, none)
        few = self._lanes if len(wanted.releases) <= RELEASES else PartLanes(wanted, leg, none, RELEASES)
        asked = parts.tolerance
        self._as_they_come = Forecaster(few, asked, parts.within, seed, in_hand)
        self._ready = Forecaster(few, free_angles_measured(asked), parts.within, seed, in_hand)

    def allows(self, pairs: Pairs) -> bool:
        """Whether the set's combination of dampers is allowed, and its parts fit the links."""
        if tuple(pair.damper.label for pair in pairs) in self.barred:
            return False
        return self.room is None or self.room.fits([(pair.spring, pair.damper) for pair in pairs])

    def errors(self, sets: Sequence[Pairs]) -> Array:
        """(n_set,) rad, RMS over joints and all releases with nominal parts."""
        if not sets:
            return np.zeros(0)
        joints = [[each[j] for each in sets] for j in range(len(self.leg.joints))]
        lanes = self._lanes.of([acting_elements(pairs) for pairs in joints])
        return lanes.errors(np.repeat(np.arange(len(sets))[:, None], len(joints), axis=1))

    def ready(self, pairs: Pairs, n_sample: int = SAMPLES_SHOWN, *, shares: bool = False) -> Forecast:
        """Forecast with measured free angles and adjusted seats; sets are chosen by it.

        Sets with equal ``n_sample`` are compared on the same draws.
        """
        return self._ready.forecast([(pair.spring, pair.damper) for pair in pairs], n_sample, shares=shares)

    def expected(self, pairs: Pairs, n_sample: int = SAMPLES_SHOWN) -> float:
        """Expected error (rad) of ``ready`` only."""
        return self._ready.expected([(pair.spring, pair.damper) for pair in pairs], n_sample)

    def as_they_come(self, pairs: Pairs, n_sample: int = SAMPLES_SHOWN, *, shares: bool = False) -> Forecast:
        """Forecast with unmeasured springs, the seats set for the catalogue's free angles."""
        return self._as_they_come.forecast([(pair.spring, pair.damper) for pair in pairs], n_sample, shares=shares)

    def built(self, pairs: Pairs) -> Leg:
        """The leg with a set of parts, in the wanted rest pose."""
        joints = []
        for j, (joint, pair) in enumerate(zip(self.leg.joints, pairs, strict=True)):
            free = joint.zero + joint.sign * self._lanes.rest(j, pair.spring.rate)
            joints.append(replace(joint, spring=Spring(pair.spring.rate, free), damper=pair.damper.damper))
        return replace(self.leg, joints=tuple(joints))
