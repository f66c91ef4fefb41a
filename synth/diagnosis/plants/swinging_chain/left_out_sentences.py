"""What a diagnosis leaves out: trials beyond the most that it learns from, and causes that cannot be simulated."""

from __future__ import annotations

from collections.abc import Sequence

from synth.diagnosis.angle_trials import AngleTrial
from synth.diagnosis.plants.swinging_chain.chain_candidates import causes_without_room
from synth.diagnosis.plants.swinging_chain.trial_legs import TrialLegs
from synth.swing.lane_layout import MOST_LINKS
from synth.swing.leg_model import Leg


def left_out_sentences(leg: Leg, learnt: Sequence[AngleTrial], spare: int, legs: TrialLegs) -> list[str]:
    """The remarks on it; ``spare`` : number of trials beside those ``learnt`` from that only score."""
    told = []
    if spare:
        told.append(
            f"{len(learnt)} of {len(learnt) + spare} trials, one of each kind and the rest spread evenly, are learnt "
            f"from; the other {spare} only score"
        )
    untried = causes_without_room(leg, learnt, legs)
    if untried:
        named = ", ".join(f"{effect} ({', '.join(places)})" for effect, places in untried.items())
        told.append(
            f"not tried: {named}, because a leg has {legs.most_links} links, those of its stated effects included, and "
            f"at most {MOST_LINKS} are simulated"
        )
    return told
