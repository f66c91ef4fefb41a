"""Effects that a leg file states are part of the designed leg: no gap, and other causes are found beside them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from diagnosis.simulated_releases import TWO, Effects, causes, off, read, recorded, with_effects
from synth.arrays import Array
from synth.diagnosis.angle_trials import angle_trial
from synth.diagnosis.lanes import Block
from synth.diagnosis.plants.swinging_chain.chain_candidates import Candidate, candidates, natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.diagnosis.plants.swinging_chain.chain_predictor import Predictor
from synth.diagnosis.plants.swinging_chain.stated_candidates import absent_effects
from synth.diagnosis.plants.swinging_chain.stated_forms import in_stated_forms
from synth.diagnosis.score import first_state
from synth.errors import UserError
from synth.files.gap_project import Tolerance
from synth.files.trial_list import Trial
from synth.fit.recordings import recordings
from synth.swing.chain import simulate
from synth.swing.leg_model import Leg
from synth.swing.tolerances import Tolerances

BEND: Effects = {"hip": {"link_flexibility": {"stiffness": 25.0}}}
MOUNT: Effects = {"base": {"base_compliance": {"stiffness": 400.0, "mass": 0.3, "damping_ratio": 0.05}}}
LATE: Effects = {"knee": {"latency": {"delay": 0.02}}}
SCALED: Effects = {"knee": {"encoder_offset": {"offset": 0.06}, "encoder_scale": {"error": 0.1}}}
TWICE: Effects = {"hip": {"link_flexibility": {"stiffness": 25.0}}, "knee": {"latency": {"delay": 0.02}}}
STATED = {"bend": BEND, "mount": MOUNT, "late": LATE, "scaled": SCALED, "two joints": TWICE}
SEVEN = STATED | {"mount and bend": {**BEND, **MOUNT}}


(RECORDING,) = recordings(TWO, recorded(TWO, held_out=0)[:1], ())
TRIAL = angle_trial(RECORDING, held_out=False)


def candidates_of(leg: Leg) -> list[Candidate]:
    return candidates(leg, [TRIAL], natural_sizes_of(leg, [TRIAL]))


def predicted(leg: Leg, key: tuple[str, str] | None = None, at: Array | None = None) -> Array:
    """(m, n) rad, what the leg's encoders read; with the first cause of this effect and place ``at`` its unknowns."""
    return predicted_with(leg, *[each for each in candidates_of(leg) if each.key == key][:1], at=at)


def predicted_with(leg: Leg, *cause: Candidate, at: Array | None = None) -> Array:
    """(m, n) rad, what the leg's encoders read with one of its causes at its first start, or ``at`` its unknowns."""
    tolerances = Tolerances.of(leg, Tolerance())
    state = np.concatenate([first_state(TRIAL), np.zeros(2 * sum(each.links for each in cause))])
    own = np.concatenate([each.starts()[0] for each in cause]) if cause and at is None else at
    unknowns = np.concatenate([np.zeros(tolerances.size), np.zeros(0) if own is None else own])
    block = Block(cause, unknowns[:, None], state[None, :, None])
    return Predictor(leg, tolerances, 1e-9).predict([TRIAL], [block])[0][:, :, 0]


@pytest.mark.parametrize("effects", SEVEN.values(), ids=SEVEN)
def test_the_designed_leg_moves_and_is_read_as_its_file_states(effects: Effects) -> None:
    leg = with_effects(TWO, effects)
    state, time = first_state(TRIAL), TRIAL.time
    moved = simulate(leg, state[:2], state[2:], time, tolerance=1e-9, rates=True)
    np.testing.assert_allclose(predicted(leg), read(leg, time, moved[:, :2], moved[:, 2:]), atol=2e-5)
    assert np.abs(predicted(leg) - predicted(TWO)).max() > math.radians(1.0)  # or the test would show nothing


@pytest.mark.parametrize(
    ("effects", "replaced"),
    [
        (TWICE, ("link_flexibility", "hip")),
        (TWICE, ("latency", "knee")),
        ({**BEND, **MOUNT}, ("base_compliance", "base")),
    ],
    ids=["bend", "latency", "mount"],
)
def test_a_cause_takes_the_place_of_the_stated_effect(effects: Effects, replaced: tuple[str, str]) -> None:
    """And leaves the others: as if the file did not state that one."""
    effect, place = replaced
    without = {**effects, place: {name: given for name, given in effects[place].items() if name != effect}}
    leg, other = with_effects(TWO, effects), with_effects(TWO, without)
    np.testing.assert_allclose(predicted(leg, replaced), predicted(other, replaced), atol=1e-9)


def test_readings_are_shifted_before_they_are_scaled_whoever_states_which() -> None:
    offset, scale = ({"knee": {name: given}} for name, given in SCALED["knee"].items())
    found = [(c.key, c) for c in candidates_of(TWO) if c.key[1] == "knee"]
    values = {name: next(iter(given.values())) for name, given in SCALED["knee"].items()}
    whole = predicted(with_effects(TWO, SCALED))
    for stated, name in ((offset, "encoder_scale"), (scale, "encoder_offset")):
        cause = dict(found)[name, "knee"]
        at = np.array([brentq(lambda x, c=cause, v=values[name]: c.values(np.array([[x]]))[0, 0] - v, 0.0, 9.0)])
        np.testing.assert_allclose(predicted(with_effects(TWO, stated), (name, "knee"), at), whole, atol=1e-9)


@pytest.mark.parametrize("effects", STATED.values(), ids=STATED)
def test_what_is_stated_is_no_gap(effects: Effects) -> None:
    leg = with_effects(TWO, effects)
    result = diagnose(leg, recorded(with_effects(off(TWO, 3, 0.5), effects)), Tolerance())
    assert (result.verdict, causes(result)) == ("none", [])
    assert result.before.value < 1.05 * result.noise_floor.value
    assert result.probability_none > 0.7


def test_dry_friction_is_found_beside_what_is_stated() -> None:
    leg = with_effects(TWO, TWICE)
    built = replace(leg.joints[1], effects={**leg.joints[1].effects, "coulomb_friction": {"torque": 0.03}})
    result = diagnose(leg, recorded(replace(leg, joints=(leg.joints[0], built))), Tolerance())
    assert (result.verdict, causes(result)) == ("effect", [("coulomb_friction", "knee")])
    assert result.explanation[0].parameters["torque"].value == pytest.approx(0.03, rel=0.1)


def test_a_cause_in_the_place_of_a_stated_effect_is_told_with_that() -> None:
    leg = with_effects(TWO, {"knee": {"encoder_offset": {"offset": 0.02}}})
    result = diagnose(leg, recorded(with_effects(TWO, {"knee": {"encoder_offset": {"offset": 0.06}}})), Tolerance())
    assert causes(result) == [("encoder_offset", "knee")]
    assert result.explanation[0].parameters["offset"].value == pytest.approx(0.06, rel=0.1)  # the whole, not the rest
    assert [text for text in result.warnings if "leg file" in text] == [
        "knee: the encoder_offset found is the whole effect, in the place of that in the leg file (offset 1.15°)"
    ]


DRY: Effects = {"knee": {"coulomb_friction": {"torque": 0.03}}}
ABSENT = {
    "friction": (
        DRY,
        "the knee's dry friction in the leg file (torque 0.03",
    ),
    "late": (LATE, "the knee's latency in the leg file (delay 20 ms)"),
    "bend": (BEND, "the hip's link flexibility in the leg file (stiffness 25"),
}


@pytest.mark.parametrize(("effects", "words"), ABSENT.values(), ids=ABSENT)
def test_a_stated_effect_that_the_rig_lacks_is_told_as_absent(effects: Effects, words: str) -> None:
    """And is left out of the diagnosed leg. A size of nil, or a bend of the largest stiffness tried, was told."""
    result = diagnose(with_effects(TWO, effects), recorded(TWO), Tolerance())
    ((place, (name,)),) = ((place, tuple(given)) for place, given in effects.items())
    assert (result.verdict, causes(result)) == ("effect", [(name, place)])
    assert result.sentence.lower().startswith(words)
    assert "in the leg file" in result.sentence
    assert "is not there" in result.sentence
    assert result.explanation[0].absent
    assert all(each.value == 0.0 for each in result.explanation[0].parameters.values())
    assert not any(joint.effects for joint in result.diagnosed.joints)
    assert not [text for text in result.warnings if "in the place of" in text or "largest value" in text]


def test_an_absent_effect_is_told_beside_what_the_file_lacks() -> None:
    result = diagnose(with_effects(TWO, LATE), recorded(with_effects(TWO, DRY)), Tolerance())
    found = {(cause.effect, cause.joint): cause.absent for cause in result.explanation}
    assert found == {("coulomb_friction", "knee"): False, ("latency", "knee"): True}
    assert result.diagnosed.joints[1].effects.keys() == {"coulomb_friction"}


def test_a_stated_effect_that_is_absent_moves_as_if_the_file_did_not_state_it() -> None:
    for effects in (BEND, MOUNT, LATE, DRY):
        (cause,) = absent_effects(candidates_of(with_effects(TWO, effects)))
        found = predicted_with(with_effects(TWO, effects), cause)
        np.testing.assert_allclose(found, predicted(TWO), atol=1e-9)


def test_a_shape_holds_what_the_file_states_instead_of_the_default() -> None:
    """Each shape put the stated lag back to 0, and no shape was late and filtered: the cause was unknown."""
    built = with_effects(TWO, {"knee": {"latency": {"delay": 0.02, "lag": 0.03}}})
    result = diagnose(with_effects(TWO, {"knee": {"latency": {"lag": 0.03}}}), recorded(built), Tolerance())
    assert (result.verdict, causes(result)) == ("effect", [("latency", "knee")])
    assert result.diagnosed.joints[1].effects["latency"] == pytest.approx({"delay": 0.02, "lag": 0.03}, rel=0.05)


def test_a_stated_form_may_also_be_another() -> None:
    """A delay in the place of the stated filter, not beside it."""
    built = with_effects(TWO, {"knee": {"latency": {"delay": 0.02}}})
    result = diagnose(with_effects(TWO, {"knee": {"latency": {"lag": 0.06}}}), recorded(built), Tolerance())
    assert causes(result) == [("latency", "knee")]
    assert result.diagnosed.joints[1].effects["latency"] == pytest.approx({"delay": 0.02}, rel=0.05)


def test_a_dry_friction_takes_the_place_of_a_stated_one_of_another_law() -> None:
    """It was added on top of the stated one, and the cause was unknown."""
    built = with_effects(TWO, {"knee": {"stribeck_friction": {"torque": 0.05, "fall": 0.8, "speed": 1.0}}})
    leg = with_effects(TWO, {"knee": {"coulomb_friction": {"torque": 0.05}}})
    result = diagnose(leg, recorded(built), Tolerance())
    assert (result.verdict, causes(result)) == ("effect", [("stribeck_friction", "knee")])
    assert result.diagnosed.joints[1].effects.keys() == {"stribeck_friction"}
    (told,) = [text for text in result.warnings if "leg file" in text]
    assert "in the place of the dry friction that the leg file states (torque 0.05 N·m)" in told


def test_a_mount_of_another_form_than_the_stated_one_is_simulated_with_both() -> None:
    """And with the stated sliding held, a candidate adds as many links as are simulated."""
    leg = with_effects(TWO, MOUNT)
    formed = [each for each in in_stated_forms(candidates_of(leg)) if each.key == ("base_compliance", "base")]
    assert sorted(each.links for each in formed) == [1, 1, 2, 2]
    for each in formed:
        assert np.isfinite(predicted_with(leg, each)).all()


def test_a_second_diagnosis_with_the_diagnosed_leg_finds_no_gap() -> None:
    trials = recorded(with_effects(TWO, BEND))
    first = diagnose(TWO, trials, Tolerance())
    assert causes(first) == [("link_flexibility", "hip")]
    again = diagnose(first.diagnosed, trials, Tolerance())
    assert (again.verdict, causes(again)) == ("none", [])
    assert again.as_designed.value == pytest.approx(first.after.value, rel=0.1)


def test_stated_counts_are_found_from_the_readings() -> None:
    leg = with_effects(TWO, {"knee": {"encoder_quantisation": {"step": math.radians(2.0)}}})
    assert causes(diagnose(leg, recorded(leg), Tolerance())) == [("encoder_quantisation", "knee")]


def test_ends_of_a_stop_do_not_cross_in_a_cause_beside_a_stated_one() -> None:
    """A lower end above the whole motion is a mistake; the diagnosed leg with the upper one found is read again."""
    leg = with_effects(TWO, {"knee": {"joint_stop": {"lower": 9.0, "stiffness": 5.0}}})
    (upper,) = [
        each
        for each in in_stated_forms(candidates_of(leg))
        if each.key == ("joint_stop", "knee") and "upper" in each.shape.free
    ]
    named = upper.named(upper.starts()[0])
    assert named["lower"] == named["upper"] < 9.0


@pytest.mark.slow  # compiles legs of seven links
def test_more_links_than_the_engine_has_are_refused_and_not_simulated() -> None:
    """A chain of eight links was zeros."""
    mount = {"base_compliance": {"stiffness": 400.0, "rocking_stiffness": 50.0}}
    six = Leg("six", tuple(replace(TWO.joints[1], name=f"j{k}") for k in range(6)), effects=mount)
    with pytest.raises(UserError, match="more than 7, the most that are simulated"):
        simulate(six, np.zeros(6), np.zeros(6), TRIAL.time)
    one = replace(six, effects={"base_compliance": {"stiffness": 400.0}})
    assert np.ptp(simulate(one, np.zeros(6), np.zeros(6), TRIAL.time)[:, 5]) > 0.1


def late(trials: Sequence[Trial], first: int = 12) -> list[Trial]:
    """The recordings without their first samples."""
    return [replace(t, time=t.time[first:] - t.time[first], angles=t.angles[first:]) for t in trials]


def test_a_stated_link_that_already_moves_when_the_recording_begins_is_no_gap() -> None:
    """Its angle and rate are estimated in each trial, as those of the candidate that found it were."""
    sliding = {"stiffness": 400.0, "mass": 0.3, "damping_ratio": 0.02}
    leg = with_effects(TWO, {"base": {"base_compliance": sliding}})
    result = diagnose(leg, late(recorded(leg)), Tolerance())
    assert (result.verdict, causes(result)) == ("none", [])
    assert result.before.value < 1.1 * result.noise_floor.value  # 20 if the mount starts as it was held


def test_a_cause_in_the_place_of_a_stated_structure_starts_as_one_beside_none() -> None:
    """From the initial states of its own links, whatever those of the stated structure are."""
    mount = next(c for c in candidates_of(TWO) if c.key == ("base_compliance", "base") and "arm" in c.shape.free)
    leg, tolerances = with_effects(TWO, MOUNT), Tolerances.of(TWO, Tolerance())
    unknowns = np.concatenate([np.zeros(tolerances.size), mount.starts()[0]])[:, None]
    begun, own, stated = first_state(TRIAL), [0.5, -0.3], [0.8, 0.7]
    over, alone = (
        Predictor(each, tolerances, 1e-9).predict(
            [TRIAL], [Block((mount,), unknowns, np.concatenate([begun, *more])[None, :, None])]
        )[0]
        for each, more in ((leg, [stated, own]), (TWO, [own]))
    )
    np.testing.assert_allclose(over, alone, atol=1e-9)
    kinds = [next(c for c in candidates_of(each) if c.key == mount.key and c.links == 1) for each in (leg, TWO)]
    assert [kind.replaced_links for kind in kinds] == [1, 0]  # states that the designed leg has are not charged again
