"""Causes that add links are tried as far as every leg of the project leaves room for them; the others are told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.simulated_releases import TWO, recorded
from synth.diagnosis.plants.swinging_chain.chain_candidates import candidates, natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import Scene, scene_of
from synth.diagnosis.plants.swinging_chain.trial_legs import TrialLegs
from synth.files.gap_project import Tolerance
from synth.swing.leg_model import Leg

SIX = Leg("six", tuple(replace(TWO.joints[1], name=f"j{k}") for k in range(6)))
BENT = SIX.with_joints(j0={"effects": {"link_flexibility": {"stiffness": 20.0}}})
BENDS, MOUNT = [("link_flexibility", f"j{k}") for k in range(6)], ("base_compliance", "base")
UNTRIED = (
    "not tried: base_compliance (base), link_flexibility (j1, j2, j3, j4, j5), because a leg has 7 links, those of its "
    "stated effects included, and at most 7 are simulated"
)
TRIALS = recorded(SIX, 0.3 * np.random.default_rng(0).uniform(-1.0, 1.0, (3, 6)), time=np.arange(101) * 0.01)


def scene(main: Leg, own: Leg | None = None, *, held_out: bool = False) -> tuple[Scene, tuple[str, ...]]:
    """Of releases, one of them with its own leg, a held-out one or not."""
    place = 2 if held_out else 0
    trials = [replace(trial, leg=own if k == place else None) for k, trial in enumerate(TRIALS)]
    return scene_of(main, trials, Tolerance(), 0)


def structures(made: Scene) -> set[tuple[str, str]]:
    """Effect and place of the causes that add links."""
    every = candidates(made.leg, made.given, natural_sizes_of(made.leg, made.given), made.legs)
    return {each.key for each in every if each.links}


def test_a_leg_of_six_joints_has_room_for_one_link() -> None:
    made, warnings = scene(SIX)
    assert structures(made) == {MOUNT, *BENDS}
    assert not [text for text in warnings if "not tried" in text]


@pytest.mark.parametrize("held_out", [False, True])
def test_a_trials_own_leg_counts_as_well(held_out: bool) -> None:
    """The eighth link was that of the program's own candidate, and the user was told to state fewer."""
    made, warnings = scene(SIX, BENT, held_out=held_out)
    assert structures(made) == {BENDS[0]}  # in place of the stated one, or beside the trial that keeps it
    assert UNTRIED in warnings


def test_causes_without_room_are_told() -> None:
    made, warnings = scene(BENT)
    assert structures(made) == {BENDS[0]}
    assert UNTRIED in warnings


def test_two_causes_have_room_together_in_every_leg() -> None:
    """Four joints have room for three links, less one that a leg states."""
    four = Leg("four", SIX.joints[:4])
    bent = four.with_joints(j0={"effects": {"link_flexibility": {"stiffness": 20.0}}})
    legs = TrialLegs.of(four, [None, bent])
    place, other = (("link_flexibility", k) for k in (0, 1))
    assert legs.most_links == 5
    assert legs.leave_room([(place, 1), (other, 1), (("base_compliance", 0), 1)])  # the first acts in one leg only
    assert not legs.leave_room([(other, 1), (("base_compliance", 0), 2)])
    assert TrialLegs.of(bent, [None]).leave_room([(place, 1), (other, 1), (("base_compliance", 0), 1)])  # replaced
