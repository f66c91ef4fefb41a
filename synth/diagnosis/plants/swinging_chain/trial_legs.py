"""The legs of a project's trials: which of their effects a common cause replaces, and what links structures add.

An effect that a trial's own leg states is that leg's own, as of another arm, unless the project's leg states it alike:
a cause, which is common to all trials, then leaves it in that trial as its file states it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from synth.swing.lane_layout import MOST_LINKS
from synth.swing.leg_lanes import LegLanes
from synth.swing.leg_model import Leg
from synth.swing.stated_effects import COUNTS, REPLACED_WAYS, Place, StatedEffect, stated_effects


@dataclass(frozen=True)
class TrialLegs:
    """The project's leg and the ``own`` legs of trials, each once; ``swung`` : whether a trial is of the project's."""

    leg: Leg
    own: tuple[Leg, ...] = ()
    swung: bool = True

    @classmethod
    def of(cls, leg: Leg, each: Iterable[Leg | None]) -> TrialLegs:
        """The project's leg, and that of each trial; None: the project's."""
        given = list(each)
        own = {id(other): other for other in given if other is not None}
        return cls(leg, tuple(own.values()), swung=None in given or not own)

    @property
    def used(self) -> tuple[Leg, ...]:
        """The legs of trials; what the first states is common to all that state it alike."""
        return (self.leg, *self.own) if self.swung else self.own

    def own_places(self, leg: Leg) -> frozenset[Place]:
        """Where this leg states an effect of its own, which a common cause leaves in its trials."""
        if id(leg) not in self._own_places:
            first = leg if leg is self.leg else self.used[0]  # imagined trials are of the project's leg
            common = {stated.place: stated.values for stated in _replaceable(first)}
            own = (stated.place for stated in _replaceable(leg) if common.get(stated.place) != stated.values)
            self._own_places[id(leg)] = frozenset(own)
        return self._own_places[id(leg)]

    def replaced_links(self, place: Place) -> int:
        """Number of links of the stated structure whose place a cause takes."""
        return self._common_links.get(place, 0)

    @cached_property
    def _common_links(self) -> Mapping[Place, int]:
        """Links of the structures that the first of the legs states: asked for with every hypothesis."""
        return links_of_structures(self.used[0])

    @property
    def most_links(self) -> int:
        """Number of links of the leg that has most, with those of the structures that it states."""
        return len(self.leg.joints) + max(sum(number for _, number in stated) for stated, _ in self._kinds)

    def leave_room(self, causes: Sequence[tuple[Place, int]]) -> bool:
        """Whether each leg, with the links that ``causes`` add at their places, can be simulated."""
        for stated, own in self._kinds:
            acting = {place: number for place, number in causes if place not in own}
            kept = sum(number for place, number in stated if place not in acting)
            if len(self.leg.joints) + kept + sum(acting.values()) > MOST_LINKS:
                return False
        return True

    @cached_property
    def _kinds(self) -> set[tuple[frozenset[tuple[Place, int]], frozenset[Place]]]:
        """Links that a leg's structures add, and its own places: one of each kind of the legs."""
        each = (self.leg, *self.own)
        return {(frozenset(links_of_structures(leg).items()), self.own_places(leg)) for leg in each}

    @cached_property
    def _own_places(self) -> dict[int, frozenset[Place]]:
        """The results of ``own_places``; imagined trials are of ``leg``, which is kept here too."""
        return {}

    @cached_property
    def started(self) -> dict[Place, int]:
        """Number of links that start freely in each trial at each place where a leg states a structure; the largest.

        One for all legs, so that all trials' initial states are equally long: an entry without a link has no effect.
        """
        found: dict[Place, int] = {}
        for leg in (self.leg, *self.own):
            for place, number in links_of_structures(leg).items():
                found[place] = max(number, found.get(place, 0))
        return found


def _replaceable(leg: Leg) -> list[StatedEffect]:
    """The effects that a leg states and a cause may take the place of."""
    return [stated for way in REPLACED_WAYS for stated in stated_effects(leg, way) if stated.effect.name != COUNTS]


def links_of_structures(leg: Leg) -> Mapping[Place, int]:
    """Number of links that each structure which a leg states adds."""
    legs, found = LegLanes.of(leg), {}
    for stated in stated_effects(leg, "structure"):
        with_it = stated.effect.function()(legs, legs.own[stated.joint], *legs.columns(stated.effect, stated.given))
        found[stated.place] = with_it.n - legs.n
        legs = with_it
    return found
