"""A wrong number is stated in the user's tolerances, and is not called a mechanism."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.simulated_releases import TWO, heavier, recorded
from synth.diagnosis.diagnosis_result import Cause
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.diagnosis.plants.swinging_chain.tolerance_words import count_of_tolerances, number_words
from synth.estimation.intervals import Estimate
from synth.files.gap_project import Tolerance
from synth.swing.tolerances import Tolerances

USUAL = Tolerances.of(TWO, Tolerance())


def cause(effect: str, parameter: str, value: float, joint: str = "knee") -> Cause:
    return Cause(effect, joint, {parameter: Estimate(value, "1")})


@pytest.mark.parametrize(
    ("found", "words"),
    [
        (cause("link_mass", "share", 0.031), "three of your tolerances"),
        (cause("link_mass", "share", -0.05), "five of your tolerances"),
        (cause("spring_rate", "rate", 4 * 0.03 * 1.5), "four of your tolerances"),
        (cause("viscous_damping", "rate", -2 * 0.05 * 0.015), "two of your tolerances"),
        (cause("spring_preload", "shift", np.radians(3.0)), "six of your tolerances"),
        (cause("link_mass", "share", 0.4), ""),
        (cause("link_mass", "share", 0.01), ""),
        (cause("coulomb_friction", "torque", 0.01), ""),
        (cause("base_tilt", "tilt", 0.01, "base"), ""),
    ],
)
def test_a_wrong_number_is_stated_in_tolerances(found: Cause, words: str) -> None:
    assert count_of_tolerances(found, TWO, USUAL) == words


def test_a_mass_error_is_stated_as_a_share() -> None:
    told = number_words(cause("link_mass", "share", 0.031), "plain", TWO, USUAL)
    assert told == "the knee's link is 3.1 % heavier than designed, three of your tolerances"


@pytest.mark.parametrize(
    ("found", "words"),
    [
        (cause("spring_rate", "rate", -4 * 0.03 * 1.5), "the knee's spring is 12 % softer than designed, four of your"),
        (cause("viscous_damping", "rate", 0.8 * 0.015), "the knee's damper is 80 % stronger than designed"),
        (cause("viscous_damping", "rate", 1.396 * 0.015), "the knee's damper is 140 % stronger than designed"),
        (cause("spring_preload", "shift", np.radians(3.0)), "plain, six of your tolerances"),
    ],
)
def test_a_part_is_compared_with_the_designed_one(found: Cause, words: str) -> None:
    assert number_words(found, "plain", TWO, USUAL).startswith(words)


def test_a_damper_where_none_was_designed_is_no_share() -> None:
    without = replace(TWO, joints=(TWO.joints[0], replace(TWO.joints[1], damper=None)))
    assert (
        number_words(cause("viscous_damping", "rate", 0.01), "plain", without, Tolerances.of(without, Tolerance()))
        == "plain"
    )


def test_a_mass_off_by_four_tolerances_is_named_with_that_figure() -> None:
    """A user who is sure to 1 % of a mass and wrong by 4 %: the mass is named, in his tolerances, and no mechanism."""
    built = heavier(TWO, "knee", 0.04)
    result = diagnose(TWO, recorded(built, noise=np.radians(0.01)), Tolerance(com=0.002, inertia=0.002, spring=0.002))
    assert result.verdict == "effect"
    assert (result.explanation[0].effect, result.explanation[0].joint) == ("link_mass", "knee")
    assert "four of your tolerances" in result.sentence
