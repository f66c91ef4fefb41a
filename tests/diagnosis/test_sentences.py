"""The sentence of a diagnosis: what all tied explanations contain is said once."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from synth.commands import answers
from synth.diagnosis.diagnosis_result import Cause
from synth.diagnosis.remainder import Remainder
from synth.diagnosis.sentences import (
    LEAST_MENTIONED,
    SURE_OF_NONE,
    ErrorWording,
    PartedErrors,
    reason_for_next_trial,
    sentence,
    stated_parameters,
)
from synth.estimation.intervals import Estimate
from synth.reports.sections.gap_which import LARGEST_AT_NOISE, SURE_PROBABILITY
from synth.swing.effects import effect_named

TOLD = ErrorWording(
    nominal="the nominal leg",
    error="the error",
    on="unseen releases",
    falls_from="2.1°",
    before=Estimate(math.radians(2.1), "deg"),
    after=Estimate(math.radians(0.3), "deg"),
    floor=Estimate(math.radians(0.01), "deg"),
    takes=0.86,
)


LITTLE, FAR = (Remainder(Estimate(math.radians(0.123), "deg"), 1.0, times, {}, {}) for times in (0.2, 87.0))


def test_tied_explanations_without_a_common_cause() -> None:
    said = sentence("tie", ["the knee has backlash"], [["the hip sticks"], ["the hip slips"]], 0.5, TOLD)
    assert said.startswith("Either the knee has backlash, or the hip sticks, or the hip slips: these trials cannot")


def test_a_common_cause_is_said_once_and_first() -> None:
    common = replace(TOLD, common=["the knee has backlash"])
    said = sentence("tie", ["the hip sticks"], [["the hip slips"]], 0.5, common)
    assert said.startswith("The knee has backlash, and either the hip sticks, or the hip slips: these trials cannot")


@pytest.mark.parametrize(
    ("ends", "said"), [((0.0580, 0.0605), "0.0593"), ((0.02, 0.11), "0.059"), ((None, 0.0605), "0.0593")]
)
def test_a_parameter_has_no_digits_beyond_its_uncertainty(ends: tuple[float | None, float], said: str) -> None:
    cause = Cause("coulomb_friction", "knee", {"torque": Estimate(0.05931, "N*m", *ends)})
    assert stated_parameters(cause, effect_named("coulomb_friction")) == f"torque {said} N·m"


@pytest.mark.parametrize(("takes", "fitted", "told"), [(0.43, 0.72, True), (0.43, 0.40, False), (0.86, 0.9, False)])
def test_the_share_by_which_the_verdict_is_given_is_told_where_the_other_is_less(
    takes: float, fitted: float, told: bool
) -> None:
    """The verdict asks 68 % of the fitted trials; the page stated 43 % of the unseen ones alone."""
    wording = replace(TOLD, takes=takes, takes_fitted=fitted, asked=0.68)
    said = sentence("effect", ["the hip sticks"], [], 0.72, wording)
    assert (
        f"noise 0.01°. On the trials that the explanation is fitted to it takes {100 * fitted:.0f} %." in said
    ) == told


def test_a_large_number_in_a_sentence_has_no_power_of_ten() -> None:
    cause = Cause("stribeck_friction", "knee", {"speed": Estimate(2.0, "deg/s", 1.0, 3.0)})
    assert stated_parameters(cause, effect_named("stribeck_friction")).endswith("speed 110°/s")
    said = sentence("effect", ["the hip sticks"], [], 0.8, replace(TOLD, after=degrees(116.0)))
    assert "rises from 2.1° to 120°" in said


def degrees(value: float) -> Estimate:
    return Estimate(math.radians(value), "deg")


def test_tied_explanations_are_told_with_the_range_of_their_own_errors() -> None:
    told = replace(TOLD, falls_from="0.2°", before=degrees(0.2), after=degrees(0.13), each=[degrees(0.047)])
    said = sentence("tie", ["the hip sticks"], [["the hip slips"]], 0.5, told)
    assert "With any of them the error on unseen releases falls from 0.2° to between 0.047° and 0.13°, noise" in said
    said = sentence("tie", ["the hip sticks"], [["the hip slips"]], 0.5, replace(told, each=[degrees(0.1301)]))
    assert "falls from 0.2° to 0.13°, noise" in said
    said = sentence("tie", ["the hip sticks"], [["the hip slips"]], 0.5, replace(told, each=[degrees(0.3)]))
    assert "goes from 0.2° to between 0.13° and 0.3°, noise" in said


def test_a_nearest_explanation_that_takes_most_is_unsure_not_absent() -> None:
    """A pair that took 86 % of the gap, with an unknown cause at 51 %: "no effect explains most of the gap"."""
    told = replace(TOLD, nearest="backlash (knee)")
    assert sentence("unknown", ["the knee has backlash"], [], 0.4, told).startswith("No explanation is sure enough to")
    little = sentence("unknown", ["the knee has backlash"], [], 0.4, replace(told, takes=0.3))
    assert little.startswith("No effect in the library explains most of the gap: ")


@pytest.mark.parametrize(
    ("after", "takes", "words"),
    [
        (0.24, -0.09, "it does not reduce the gap: the error on unseen releases rises from 0.22° to 0.24°"),
        (0.2199, 0.001, "it does not reduce the gap: the error on unseen releases stays at 0.22°"),
        (0.02, 0.91, "it takes 91 % of the gap: the error on unseen releases falls from 0.22° to 0.02°"),
    ],
)
def test_an_error_falls_only_where_it_does(after: float, takes: float, words: str) -> None:
    told = replace(TOLD, falls_from="0.22°", before=degrees(0.22), after=degrees(after), takes=takes)
    assert f"The hip sticks, 80 %; {words}, noise" in sentence("effect", ["the hip sticks"], [], 0.8, told)


def test_a_gap_at_the_noise_shows_no_share() -> None:
    """A gear loss of a jumping leg, which its tolerances imitated in the angle: "94 %; it does not reduce the gap"."""
    told = replace(TOLD, falls_from="0.11°", before=degrees(0.11), after=degrees(0.1), floor=degrees(0.11), takes=0.0)
    said = sentence("effect", ["the hip sticks"], [], 0.94, told)
    assert said.startswith("The hip sticks, 94 %. The error on unseen releases falls from 0.11° to 0.1°, noise 0.11°: ")
    assert "is at the noise already, and shows no share" in said
    assert "not reduce" not in said


@pytest.mark.parametrize(
    ("shrink", "cell"),
    [
        ({"value": 0.0, "interval90": [-1.0, 1.0]}, "unknown"),
        ({"value": 0.0, "interval90": [-0.1, 0.2]}, "0%"),
        ({"value": 0.9, "interval90": [-1.0, 1.0]}, "90%"),
        (None, "-"),
    ],
)
def test_a_share_of_which_the_trials_tell_nothing_is_unknown(shrink: dict[str, object] | None, cell: str) -> None:
    entry = {"effect": "backlash", "joint": "hip", "probability": 0.9, "shrink": shrink}
    content = {"verdict": "effect", "ranked": [entry], "explanation": [entry], "probability_none": 0.1,
               "probability_unknown": 0.0}  # fmt: skip
    row = next(line for line in answers.gap_text(content).splitlines() if line.startswith("backlash"))
    assert row.split()[-1] == cell


def test_the_reason_of_another_trial_says_as_the_headline_whether_a_cause_is_near() -> None:
    assert "not sure enough to be named" in reason_for_next_trial("unknown", [""], FAR, takes=0.74)
    assert "effect is unknown" in reason_for_next_trial("unknown", [""], FAR, takes=0.04)


def test_a_gap_within_the_accuracy_is_not_told_as_no_missing_effect() -> None:
    assert reason_for_next_trial("none", [""], LITTLE).startswith("These trials show no missing effect")
    within = reason_for_next_trial("none", [""], LITTLE, within=True)
    assert "below the required accuracy" in within
    assert "no missing effect" not in within


DRAG = {"coefficient": 0.0015, "speed": 20.0}
MOUNT = {"stiffness": 1e3, "mass": 1.0, "rocking_stiffness": 9.0, "arm": 0.2, "inertia": 0.1}
STATED = [
    ("stribeck_friction", {"torque": 0.06, "fall": 0.6, "speed": 2.0, "presliding": 3e-4}, "torque fall speed"),
    ("quadratic_damping", {**DRAG, "exponent": 2.1}, "coefficient exponent"),
    ("quadratic_damping", {**DRAG, "exponent": 2.6}, "coefficient exponent speed"),
    ("gear_friction", {"torque": 0.01, "share": 0.3, "fall": 0.4, "speed": 1.0}, "share torque fall"),
    ("base_compliance", MOUNT, "stiffness rocking_stiffness mass"),
    ("viscous_damping", {"rate": 0.1}, "change_of_rate"),
]


@pytest.mark.parametrize(("name", "values", "wanted"), STATED)
def test_a_sentence_states_the_few_parameters_that_carry_a_cause(
    name: str, values: dict[str, float], wanted: str
) -> None:
    """The reference speed of a drag does not matter where its exponent may be 2."""
    effect = effect_named(name)
    unit = {parameter.name: parameter.unit for parameter in effect.parameters}
    found = {key: Estimate(value, unit[key], 0.9 * value, 1.1 * value) for key, value in values.items()}
    text = stated_parameters(Cause(name, "knee", found), effect)
    words = [key.replace("_", " ") for key in wanted.split()]
    assert all(each.startswith(f"{word} ") for each, word in zip(text.split(", "), words, strict=True)), text


def test_shares_and_relative_changes_are_told_in_per_cent_as_on_the_page() -> None:
    """The sentence had "change of com 0.81, change of inertia 0.33" beside a table with +81 % and +33 %."""
    found = {"com": Estimate(0.81, "1", 0.6, 1.0), "inertia": Estimate(-0.33, "1", -0.5, -0.2)}
    text = stated_parameters(Cause("link_inertia", "ankle", found), effect_named("link_inertia"))
    assert text == "change of com +81 %, change of inertia -33 %"
    fall = {"torque": Estimate(0.06, "N*m", 0.05, 0.07), "fall": Estimate(0.6, "1", 0.5, 0.7)}
    told = stated_parameters(Cause("stribeck_friction", "knee", fall), effect_named("stribeck_friction"))
    assert "fall 60 %" in told


def test_the_error_on_trials_that_need_other_tolerances_is_not_mixed_with_that_on_the_others() -> None:
    """One tip mass that only a held-out trial carries hid that friction takes three quarters of the gap elsewhere."""
    parted = PartedErrors((degrees(0.14), degrees(0.064)), (degrees(0.37), degrees(0.46)), (3, 1), 0.77)
    told = replace(TOLD, takes=-0.07, moved=degrees(0.063), parted=parted)
    said = sentence("effect", ["the knee has dry friction"], [], 0.95, told)
    assert said == (
        "The knee has dry friction, 95 %. On 3 of 4 unseen releases the error falls from 0.14° to 0.064° (takes 77 % "
        "of the gap), noise 0.01°. On the other one it rises from 0.37° to 0.46°, which may be due to the tolerances: "
        "moved within them, as far as the training trials allow, the explanation follows all to 0.063°."
    )
    either = sentence("tie", ["the knee has dry friction"], [["the knee has backlash"]], 0.5, told)
    assert "With the first of them, on 3 of 4 unseen releases the error falls" in either


def test_no_missing_effect_is_said_only_where_it_is_probable() -> None:
    """One cut trial, friction in it: a probability of 46 % was told as "these trials show no missing effect"."""
    unsure = sentence("none", [], [], 0.1, replace(TOLD, none=0.46))
    assert unsure.startswith(
        "These trials cannot show whether an effect is missing (probability that none is 46 %): within tolerances the "
        "nominal leg has an error of 2.1° on unseen releases"
    )
    assert sentence("none", [], [], 0.1, replace(TOLD, none=0.9)).startswith("These trials show no missing effect")
    assert "To show whether an effect is missing" in reason_for_next_trial("none", [""], LITTLE, none=0.46)
    assert SURE_OF_NONE == SURE_PROBABILITY  # the page, which imports nothing of the program, says the same


def test_an_error_far_above_the_noise_is_not_told_as_no_missing_effect() -> None:
    said = sentence("none", [], [], 0.1, replace(TOLD, none=0.93, left=FAR))
    assert said.startswith("No effect in the library improves the prediction")
    assert said.endswith(" 0.12° remains unexplained.")
    assert reason_for_next_trial("none", [""], FAR).startswith("No effect in the library improves the prediction; in")
    assert LEAST_MENTIONED == LARGEST_AT_NOISE == answers.LARGEST_AT_NOISE  # page and screen draw the line there too
