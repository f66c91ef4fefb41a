"""The legs of a project's trials, and the links that the structures which they state add."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from synth.diagnosis.angle_trials import AngleTrial
from synth.swing.leg_lanes import LegLanes
from synth.swing.leg_model import Leg
from synth.swing.stated_effects import Place, stated_effects


@dataclass(frozen=True)
class TrialLegs:
    """The project's leg and the ``own`` legs of trials, each once."""

    leg: Leg
    own: tuple[Leg, ...] = ()

    @classmethod
    def of(cls, leg: Leg, trials: Sequence[AngleTrial]) -> TrialLegs:
        """The legs of these trials beside the project's."""
        own = [trial.recording.leg for trial in trials if trial.recording.leg is not None]
        return cls(leg, tuple({id(each): each for each in own}.values()))

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


def links_of_structures(leg: Leg) -> Mapping[Place, int]:
    """Number of links that each structure which a leg states adds."""
    legs, found = LegLanes.of(leg), {}
    for stated in stated_effects(leg, "structure"):
        with_it = stated.effect.function()(legs, legs.own[stated.joint], *legs.columns(stated.effect, stated.given))
        found[stated.place] = with_it.n - legs.n
        legs = with_it
    return found
