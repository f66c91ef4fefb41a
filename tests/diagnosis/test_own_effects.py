"""What a trial's own leg states is that leg's own: a common cause leaves it there, and is told with it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from diagnosis.simulated_releases import TWO, Effects, causes, recorded, with_effects
from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial, angle_trial
from synth.diagnosis.diagnosis_result import Cause
from synth.diagnosis.lanes import Block
from synth.diagnosis.plants.swinging_chain.chain_candidates import candidates, natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.diagnosis.plants.swinging_chain.chain_predictor import Predictor
from synth.diagnosis.plants.swinging_chain.replaced_effects import with_replaced_effects
from synth.diagnosis.plants.swinging_chain.trial_checks import check_trials
from synth.diagnosis.plants.swinging_chain.trial_legs import TrialLegs
from synth.diagnosis.score import first_state
from synth.files.gap_project import Tolerance
from synth.files.trial_list import Trial
from synth.fit.recordings import recordings
from synth.swing.leg_model import Leg
from synth.swing.tolerances import Tolerances

BEND: Effects = {"hip": {"link_flexibility": {"stiffness": 25.0}}}
LATE: Effects = {"knee": {"latency": {"delay": 0.02}}}
RUBS: Effects = {"knee": {"coulomb_friction": {"torque": 0.03}}}
PLACES = {
    "bend": (BEND, ("link_flexibility", "hip")),
    "latency": (LATE, ("latency", "knee")),
    "friction": (RUBS, ("coulomb_friction", "knee")),
}
OWN = with_effects(TWO, BEND)


def predicted(leg: Leg, trial: AngleTrial, key: tuple[str, str] | None) -> Array:
    """(m, n) rad of a trial, with the first cause of this effect and place at its first start; it moves from there."""
    every = candidates(leg, [trial], natural_sizes_of(leg, [trial]))
    cause = [each for each in every if each.key == key][:1]
    tolerances = Tolerances.of(leg, Tolerance())
    predictor = Predictor(leg, tolerances, 1e-9, TrialLegs.of(leg, [None, trial.recording.leg]))
    state = np.concatenate(
        [first_state(trial), np.zeros(2 * predictor.stated_links), *(np.full(2 * c.links, 0.5) for c in cause)]
    )
    unknowns = np.concatenate([np.zeros(tolerances.size), *(each.starts()[0] for each in cause)])
    return predictor.predict([trial], [Block(tuple(cause), unknowns[:, None], state[None, :, None])])[0][:, :, 0]


def of_leg(own: Leg | None) -> AngleTrial:
    """A trial of the project's leg or of its own."""
    (recording,) = recordings(TWO, [replace(recorded(TWO, held_out=0)[0], leg=own)], ())
    return angle_trial(recording, held_out=False)


@pytest.mark.parametrize(("effects", "key"), PLACES.values(), ids=PLACES)
def test_a_cause_leaves_what_a_trials_own_leg_states(effects: Effects, key: tuple[str, str]) -> None:
    own = of_leg(with_effects(TWO, effects))
    np.testing.assert_allclose(predicted(TWO, own, key), predicted(TWO, own, None), atol=1e-12)
    plain = of_leg(None)
    assert np.abs(predicted(TWO, plain, key) - predicted(TWO, plain, None)).max() > 1e-4


@pytest.mark.parametrize(("effects", "key"), PLACES.values(), ids=PLACES)
def test_a_cause_replaces_what_both_leg_files_state_alike(effects: Effects, key: tuple[str, str]) -> None:
    both = with_effects(TWO, effects)
    own = of_leg(replace(both, name="other"))
    np.testing.assert_allclose(predicted(both, own, key), predicted(both, of_leg(None), key), atol=1e-12)


def test_places_of_a_legs_own() -> None:
    stiffer = with_effects(TWO, {"hip": {"link_flexibility": {"stiffness": 60.0}}})
    assert TrialLegs.of(TWO, [None, OWN]).own_places(OWN) == {("link_flexibility", 0)}
    assert TrialLegs.of(stiffer, [None, OWN]).own_places(OWN) == {("link_flexibility", 0)}
    assert not TrialLegs.of(OWN, [None, replace(OWN)]).own_places(OWN)
    assert not TrialLegs.of(TWO, [None, OWN]).own_places(TWO)
    copy = replace(OWN)
    assert not TrialLegs.of(TWO, [OWN, copy]).own_places(copy)  # of all trials, so common to them


def two_rigs(main: Effects, own: Effects, stated: Leg) -> list[Trial]:
    """Releases of two rigs; those of the second with its own leg."""
    away = np.array([[-0.3, 0.5], [0.45, 0.35]])
    first = recorded(with_effects(TWO, main))
    second = recorded(with_effects(TWO, own), away, seed=1, first=4)
    return [*first, *(replace(trial, leg=stated, leg_file="own.leg.yaml") for trial in second)]


def test_one_bend_is_found_beside_that_of_an_own_leg() -> None:
    """No common stiffness fits both rigs."""
    result = diagnose(TWO, two_rigs({"hip": {"link_flexibility": {"stiffness": 60.0}}}, BEND, OWN), Tolerance())
    assert (result.verdict, causes(result)) == ("effect", [("link_flexibility", "hip")])
    assert result.explanation[0].parameters["stiffness"].value == pytest.approx(60.0, rel=0.15)
    assert result.after.value < 1.1 * result.noise_floor.value
    assert [text for text in result.warnings if "its own" in text] == [
        "hip: the link_flexibility found is that of the other trials: own.leg.yaml states its own "
        "(stiffness 25 N·m/rad), which stays in 4.csv, 5.csv"
    ]


def remarks(leg: Leg, trials: Sequence[Trial], cause: Cause) -> tuple[str, ...]:
    """Those on what the leg files state of a cause."""
    found: tuple[str, ...] = with_replaced_effects({"explanation": [cause], "warnings": ()}, leg, trials)["warnings"]
    return found


def test_every_leg_file_whose_effect_a_cause_replaces_is_named() -> None:
    trials, cause = two_rigs({}, {}, OWN), Cause("link_flexibility", "hip", {})
    text = "hip: the link_flexibility found is the whole effect, in the place of that in"
    assert remarks(OWN, trials, cause) == (
        f"{text} the leg file (stiffness 25 N·m/rad) and that in own.leg.yaml (stiffness 25 N·m/rad)",
    )
    assert remarks(TWO, trials[4:], cause) == (f"{text} own.leg.yaml (stiffness 25 N·m/rad)",)
    assert remarks(TWO, trials[:4], cause) == ()


def test_what_an_own_leg_states_is_told_as_of_its_file() -> None:
    (told,) = (text for text in check_trials(TWO, two_rigs({}, {}, OWN)) if "part of" in text)
    assert told == "part of the own leg of 4.csv, 5.csv, as own.leg.yaml states: link_flexibility (hip)"
