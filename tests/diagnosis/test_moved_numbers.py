"""A stated number that a fit moves far within its tolerance, and so closes the gap, is told."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from diagnosis.simulated_releases import TWO
from diagnosis.test_stated_numbers import BY_CURRENT, current_driven
from synth.arrays import Array
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.plant import Plant
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.diagnosis.plants.swinging_chain.moved_numbers import (
    MovedNumber,
    moved_numbers,
    sentence_of_numbers,
    with_moved_numbers,
)
from synth.diagnosis.prediction_error import BLOCKS_A_TRIAL, PredictionErrors
from synth.estimation.intervals import Estimate
from synth.files.gap_project import Tolerance
from synth.remarks import severity_of
from synth.swing.tolerances import QUANTITIES, Tolerances

USUAL = Tolerances.of(TWO, Tolerance())
COUNTS = np.full((2, BLOCKS_A_TRIAL), 25.0)
NOISE, GAP = 0.001, 0.07  # rad


def told(x: Array, need: float, hypothesis: tuple[Any, ...] = ()) -> Any:
    """Numbers of a fit whose error grows by ``need`` rad for each tolerance that is put back."""

    def squares(predicted: Array) -> Array:
        return np.asarray((NOISE**2 + predicted**2) * COUNTS)

    plant: Any = SimpleNamespace(
        scored=(),
        predict=lambda fit, _: need * float(np.linalg.norm(fit.unknowns - x)),
        as_read=lambda predicted: predicted,
        squares=squares,
        samples=lambda: (COUNTS, NOISE**2 * COUNTS),
    )
    plant.rms = lambda predicted: Plant.rms(plant, predicted)
    errors = PredictionErrors({"as_designed": GAP**2 * COUNTS}, COUNTS, NOISE**2 * COUNTS, seed=0)
    fit = replace(EvaluatedHypothesis((), x, ()), hypothesis=hypothesis)
    return moved_numbers(plant, TWO, USUAL, fit, errors)


def one_moved(quantity: str, count: float) -> Array:
    x = np.zeros(USUAL.size)
    x[2 * QUANTITIES.index(quantity) + 1] = count  # at the knee
    return x


@pytest.mark.parametrize(
    ("quantity", "count", "need", "words"),
    [
        ("mass", 2.0, 0.03, "knee: link mass 2 % above the stated one, 2 of your tolerances: with the stated one the"),
        (
            "mass",
            -2.5,
            0.03,
            "knee: link mass 2.5 % below the stated one, 2.5 of your tolerances, the most that is tried",
        ),
        ("rest", 2.0, 0.03, "knee: free angle 1° "),
        ("mass", 1.4, 0.03, ""),  # to be expected
        ("mass", 2.0, 0.001, ""),  # it takes next to nothing
        ("mass", 2.5, 0.001, "knee: link mass 2.5 % above"),  # more than the noise, and the true one may be further off
        ("mass", 2.5, 0.0001, ""),
    ],
)
def test_a_number_is_told_that_is_moved_far_and_matters(quantity: str, count: float, need: float, words: str) -> None:
    found = told(one_moved(quantity, count), need)
    assert len(found) == bool(words)
    for item in found:
        assert item.remark.startswith(words)
        assert (severity_of(item.remark) == "check") == item.at_limit == (abs(count) == 2.5)
        assert item.as_json()["tolerances"] == count


def test_a_number_that_a_cause_changes_too_is_told_with_the_cause() -> None:
    cause: Any = SimpleNamespace(key=("link_mass", "knee"))
    other: Any = SimpleNamespace(key=("link_mass", "hip"))
    assert not told(one_moved("mass", 2.0), 0.03, (cause,))
    assert told(one_moved("mass", 2.0), 0.03, (other,))


@pytest.mark.parametrize("verdict", ["none", "effect"])
def test_the_sentence_holds_the_numbers_where_no_cause_is_named(verdict: str) -> None:
    x = one_moved("mass", 2.0) + one_moved("com", 2.0) + one_moved("length", -2.0)
    fields = with_moved_numbers({"verdict": verdict, "sentence": "So.", "warnings": ("odd",)}, told(x, 0.03))
    assert len(fields["warnings"]) == 4
    assert ("2 of your tolerances" in fields["sentence"]) == (verdict == "none")
    assert fields["sentence"].endswith(", and 1 more." if verdict == "none" else "So.")


def test_a_motor_constant_that_closes_the_gap_is_told() -> None:
    """A constant 30 % higher, known to 10 %, of a motor whose current is recorded: no cause, and said nowhere."""
    result = diagnose(BY_CURRENT, current_driven(1.28), Tolerance())
    share = result.diagnosed.joints[1].effects["torque_gain"]["share"]
    assert share == pytest.approx(0.28, abs=0.03)
    if result.verdict == "none":
        assert "the knee's torque constant 2" in result.sentence
        assert result.moved_numbers[0].stated.value > 3.0 * result.moved_numbers[0].left.value
        assert result.as_json()["moved_numbers"][0]["quantity"] == "torque_constant"
    else:
        assert {cause.effect for cause in result.explanation} == {"torque_gain"}


@pytest.mark.parametrize(("stated", "written"), [(1.74, False), (1.76, True)])
def test_errors_are_told_only_where_they_differ_as_written(stated: float, written: bool) -> None:
    """Not "1.7°, not 1.7°"."""
    both = (Estimate(float(np.radians(error)), "deg") for error in (1.7, stated))
    item = MovedNumber("hip", "mass", -0.025, -2.5, True, *both)
    assert ("with the stated one the error is 1.8°, not 1.7°" in item.remark) == written
    assert ("with the stated one" in item.remark) == written
    assert ("as stated it leaves 1.8°" in sentence_of_numbers([item])) == written
    assert ("as stated" in sentence_of_numbers([item])) == written
    assert "measure it, or state a larger tolerance" in item.remark
