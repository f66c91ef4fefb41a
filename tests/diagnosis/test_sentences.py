"""The sentence of a diagnosis: what all tied explanations contain is said once."""

from __future__ import annotations

import math
from dataclasses import replace

from synth.diagnosis.sentences import ErrorWording, sentence
from synth.estimation.intervals import Estimate

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


def test_tied_explanations_without_a_common_cause() -> None:
    said = sentence("tie", ["the knee has backlash"], [["the hip sticks"], ["the hip slips"]], 0.5, TOLD)
    assert said.startswith("Either the knee has backlash, or the hip sticks, or the hip slips: these trials cannot")


def test_a_common_cause_is_said_once_and_first() -> None:
    common = replace(TOLD, common=["the knee has backlash"])
    said = sentence("tie", ["the hip sticks"], [["the hip slips"]], 0.5, common)
    assert said.startswith("The knee has backlash, and either the hip sticks, or the hip slips: these trials cannot")
