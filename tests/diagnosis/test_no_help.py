"""Causes that reduce no error: at the noise none is missing (``../shared/FORMATS.md``), far from it none is nearest."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from diagnosis.test_cause_findings import StillPlant
from diagnosis.test_unseen import DRAG, FRICTION, OFFSET
from synth.diagnosis.cause_findings import find_causes
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.hypotheses import Assessment, Hypotheses
from synth.diagnosis.plants.swinging_chain.chain_candidates import Candidate
from synth.diagnosis.prediction_error import BLOCKS_A_TRIAL

TOLERANCES, AWAY = 4, 2.5  # number, and deviations of each by which the leg without causes follows the trials
NOISE = 0.001  # rad


def fitted(misfit: float, away: float, *causes: Candidate) -> Assessment[Any]:
    """``misfit`` : log-likelihood of the readings alone; every tolerance ``away``."""
    unknowns = np.concatenate([np.full(TOLERANCES, away), np.zeros(sum(cause.size for cause in causes))])
    return Assessment(
        EvaluatedHypothesis(causes, unknowns, ()), misfit + 0.5 * float(unknowns @ unknowns), 1.0 + 1e-3 * misfit
    )


class QuietPlant(StillPlant):
    """The leg follows a held-out trial to the noise, or to ``before`` times it; causes follow it to the noise.

    Each of the ``causes`` reduces the misfit of the fitted trials by ``gain``.
    """

    n_tolerance = TOLERANCES

    def __init__(self, before: float, gain: float, *causes: Candidate) -> None:
        super().__init__(0.0)
        self.before, self.gain, self.causes = before, gain, causes

    def search(self, say: object) -> Hypotheses[Any]:
        singles = tuple(fitted(10.0 + 0.1 * k, 0.0, cause) for k, cause in enumerate(self.causes))
        return Hypotheses(fitted(10.0 + self.gain, AWAY), singles, ())

    def doubts(self, *_: object) -> tuple[tuple[str, ...], float]:
        return ("the verdict depends on a trial",), 0.0

    def cause_text(self, cause: object) -> str:
        return "the leg has a cause"

    def covariance(self, fit: Any) -> Any:
        return 0.01 * np.eye(len(fit.unknowns))

    def bounds(self, fit: Any) -> Any:
        wide = np.full(len(fit.unknowns), 10.0)
        return -wide, wide

    def predict(self, fit: Any, trials: object) -> tuple[Any, ...]:
        return (fit,)

    def squares(self, predicted: Any) -> Any:
        (fit,) = predicted
        caused = fit is not None and len(fit.hypothesis) > 0
        return np.full((1, BLOCKS_A_TRIAL), 10 * (NOISE * (1.0 if caused else self.before)) ** 2)


class FarPlant(QuietPlant):
    """Far from the noise on fitted trials; with a cause the scored trial errs by ``times`` as much as without."""

    def __init__(self, times: float) -> None:
        super().__init__(20.0, 0.0, FRICTION)
        self.times = times

    def search(self, say: object) -> Hypotheses[Any]:
        none, caused = fitted(1000.0, 0.0), fitted(980.0, 0.0, FRICTION)
        return Hypotheses(replace(none, ratio=20.0), (replace(caused, ratio=19.6),), ())

    def squares(self, predicted: Any) -> Any:
        (fit,) = predicted
        times = self.times if fit is not None and len(fit.hypothesis) > 0 else 1.0
        return np.full((1, BLOCKS_A_TRIAL), 10 * (NOISE * self.before * times) ** 2)

    def addendum(self, *_: object) -> str:
        return ""

    def short_text(self, cause: object) -> str:
        return "friction"


@pytest.mark.parametrize(("times", "share"), [(3.0, 1.0), (1.0, 1.0), (0.8, 0.8)])
def test_more_than_the_gap_never_remains_unexplained(times: float, share: float) -> None:
    """A remainder of 234 % of the gap was that of three causes with which the unseen trials erred more than without."""
    found = find_causes(FarPlant(times), lambda text: None)
    assert found.judged.verdict == "unknown"
    assert found.remainder.share == pytest.approx(share, abs=1e-3)
    assert found.remainder.rms.value == pytest.approx(share * found.stages.errors.above_noise("before").value, rel=1e-3)
    assert found.stages.errors.shrink().value == pytest.approx(1.0 - share, abs=1e-3)
    assert (not found.causes) is (times >= 1.0)
    assert ("no explanation helps" in found.sentence) is (times >= 1.0)
    assert [entry.cause.effect for entry in found.ranked] == [FRICTION.key[0]]  # with what it does alone


@pytest.mark.parametrize(
    ("before", "gain", "causes", "verdict"),
    [
        (1.0, 0.0, (FRICTION, OFFSET, DRAG), "none"),
        (1.01, 1.0, (FRICTION, OFFSET), "none"),
        (1.2, 0.0, (FRICTION, OFFSET), "tie"),  # they reduce the error of the held-out trial
        (1.0, 20.0, (FRICTION, OFFSET), "tie"),  # they reduce that of the fitted ones: it may show only there
        (1.0, 0.0, (FRICTION,), "effect"),  # a sure one: the leg would need four numbers far off their tolerances
    ],
)
def test_causes_that_reduce_no_error_are_not_tied(
    before: float, gain: float, causes: tuple[Candidate, ...], verdict: str
) -> None:
    found = find_causes(QuietPlant(before, gain, *causes), lambda text: None)
    assert found.judged.verdict == verdict
    assert (not found.causes) is (verdict == "none")
    assert (not found.warnings) is (verdict == "none")
    if verdict == "none":
        assert found.best is found.found.none.fit
        assert found.judged.none < 0.5  # the odds are told as they are
        assert "cannot show whether an effect is missing" in found.sentence
