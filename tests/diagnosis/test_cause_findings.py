"""What is the same for all plants: from hypotheses to findings, on a plant that only tells what it was asked."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from synth.diagnosis.cause_findings import MOST_RANKED, _rank_causes, find_causes
from synth.diagnosis.diagnosis_result import Cause
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.hypotheses import Assessment, Hypotheses
from synth.diagnosis.plant import Plant
from synth.diagnosis.prediction_error import BLOCKS_A_TRIAL
from synth.diagnosis.sentences import ErrorWording
from synth.diagnosis.verdict import Judgement
from synth.estimation.intervals import Estimate


class StillPlant(Plant[Any, Any, Any]):
    """One recording that is held out, 0.02 rad off the nominal leg, and no candidate."""

    scored, scored_names, held_out, seed, warnings, n_tolerance = ("trial",), ("trial",), True, 0, (), 0

    def __init__(self, accuracy: float) -> None:
        self.accuracy, self.motion, self.own_motion = accuracy, 7.0, 400.0
        self.weighed_by: list[float] = []

    def search(self, say: object) -> Hypotheses[Any]:
        fit = EvaluatedHypothesis((), np.zeros(0), ())
        return Hypotheses(Assessment(fit, 100.0, 20.0), (), ())

    def doubts(self, found: object, judged: object, motion: float) -> tuple[tuple[str, ...], float]:
        self.weighed_by.append(motion)
        return (), 0.0

    def designed(self) -> object:
        return None

    normal = bounds = forecast = designed

    def remainder(self, fit: object) -> float:
        return 1.0

    def predict(self, fit: object, trials: object) -> tuple[str, ...]:
        return ("still",)

    def squares(self, predicted: object) -> Any:
        return np.full((1, BLOCKS_A_TRIAL), 10 * 0.02**2)

    def samples(self, unread: object = ()) -> tuple[Any, Any]:
        return np.full((1, BLOCKS_A_TRIAL), 10.0), np.full((1, BLOCKS_A_TRIAL), 10 * 0.001**2)

    def left_where(self, predicted: object, unread: object = ()) -> tuple[dict[str, float], dict[str, float]]:
        return {}, {}

    def wording(self, errors: Any) -> ErrorWording:
        before, after = errors.figure("before"), errors.figure("after")
        return ErrorWording("the nominal leg", "the error", "unseen trials", "1.1°", before, after, errors.floor)

    def cause_text(self, cause: object) -> str:
        return ""

    short_text = cause_text

    def worse(self, errors: object, moved: object, words: str = "") -> tuple[str, ...]:
        return ()

    def menu(self) -> tuple[()]:
        return ()


@pytest.mark.parametrize(("accuracy", "within", "motion"), [(0.0, False, 7.0), (0.01, False, 7.0), (0.05, True, 400.0)])
def test_a_plant_is_the_same_after_its_diagnosis(accuracy: float, within: bool, motion: float) -> None:
    """Within the accuracy that is required, causes are weighed as if none were; a second run begins as the first."""
    plant = StillPlant(accuracy)
    state = {**vars(plant), "weighed_by": None}
    found = [find_causes(plant, lambda text: None) for _ in range(2)]
    assert [each.within_accuracy for each in found] == [within, within]
    assert plant.weighed_by == [motion, motion]
    assert {**vars(plant), "weighed_by": None} == state
    assert found[0].sentence == found[1].sentence
    assert found[0].judged.none == found[1].judged.none


def test_every_cause_of_a_tie_is_ranked() -> None:
    """The sentence named a spring 43 % too soft as a rival, and no table had it: it was fitted beside another only."""

    def assessed(*effects: str) -> Assessment[Any]:
        hypothesis = tuple(SimpleNamespace(key=(effect, "ankle")) for effect in effects)
        return Assessment(cast(Any, SimpleNamespace(hypothesis=hypothesis)), 100.0, 2.0)

    first, rival, weak = assessed("bends", "heavy"), assessed("bends", "soft"), assessed("bends", "weak")
    names = ("bends", "heavy", *(f"cause {k}" for k in range(MOST_RANKED)), "weak")
    singles = tuple((assessed(name), 0.5 / 2**k) for k, name in enumerate(names))
    weighed = ((first, 0.5), (rival, 0.2), (weak, 0.1))
    judged = Judgement("tie", first, (rival, weak), singles, 0.0, 0.3, weighed)
    told = {id(item): tuple(Cause(*key, {}) for key in item.keys) for item in (first, rival, weak)}
    told |= {id(item): (Cause(*item.keys[0], {}),) for item, _ in singles}
    plant, errors = SimpleNamespace(direct_causes=()), SimpleNamespace(shrink=lambda label: Estimate(0.3, "1"))
    ranked = {entry.cause.effect: entry for entry in _rank_causes(cast(Any, plant), judged, cast(Any, errors), told)}
    assert {"bends", "heavy", "soft", "weak"} <= {*ranked}
    assert (ranked["soft"].probability, ranked["soft"].shrink) == (pytest.approx(0.7 * 0.2), None)
    assert ranked["weak"].shrink is not None  # it was fitted alone too, and counts little there
    assert "cause 7" not in ranked
