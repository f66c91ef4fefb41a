"""What takes the remainder of an explanation but too little of the gap to be named: told, and in the intervals."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from diagnosis.simulated_releases import AWAY, ONE, TIME, recorded, with_effects
from diagnosis.test_cause_findings import StillPlant
from diagnosis.test_unseen import FRICTION, OFFSET
from synth.diagnosis.cause_findings import find_causes
from synth.diagnosis.diagnosis_result import Cause
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.hypotheses import Assessment, Hypotheses
from synth.diagnosis.plants.swinging_chain.chain_candidates import Candidate
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.diagnosis.prediction_error import BLOCKS_A_TRIAL
from synth.files.gap_project import Tolerance

NOISE = 0.001  # rad


def found_fit(cost: float, ratio: float, *points: tuple[Candidate, float]) -> Assessment[Any]:
    """Causes whose whitened unknowns are all at a point."""
    unknowns = np.concatenate([np.zeros(0), *[np.full(cause.size, at) for cause, at in points]])
    return Assessment(EvaluatedHypothesis(tuple(cause for cause, _ in points), unknowns, ()), cost, ratio)


class PulledPlant(StillPlant):
    """A gap of 20 noise floors of which friction leaves 1.4; with a shifted reading too, ``left`` times the noise.

    ``pair`` : cost of both, if they were tried.
    """

    def __init__(self, pair: float | None, left: float = 1.0) -> None:
        super().__init__(0.0)
        self.pair, self.left, self.motion = pair, left, np.inf

    def search(self, say: object) -> Hypotheses[Any]:
        alone = found_fit(390.0, 1.7, (FRICTION, 0.5))
        pairs = [] if self.pair is None else [found_fit(self.pair, 1.0, (FRICTION, 0.7), (OFFSET, 0.3))]
        return Hypotheses(found_fit(1700.0, 20.0), (alone,), tuple(pairs))

    def covariance(self, fit: Any) -> Any:
        return 1e-4 * np.eye(len(fit.unknowns))

    def bounds(self, fit: Any) -> Any:
        wide = np.full(len(fit.unknowns), 10.0)
        return -wide, wide

    def doubts(self, *_: object) -> tuple[tuple[str, ...], float]:
        return (), 0.0

    def predict(self, fit: Any, trials: object) -> tuple[Any, ...]:
        return (fit,)

    def squares(self, predicted: Any) -> Any:
        (fit,) = predicted
        floors = (20.0, 1.7, self.left)[0 if fit is None else len(fit.hypothesis)]
        return np.full((1, BLOCKS_A_TRIAL), 10 * (NOISE * floors) ** 2)

    def cause_text(self, cause: Any) -> str:
        return f"the {cause.joint} has {cause.effect}"


def torque_interval(cause: Cause) -> tuple[float, float, float]:
    torque = cause.parameters["torque"]
    assert torque.low is not None
    assert torque.high is not None
    return torque.low, torque.value, torque.high


def test_the_interval_of_a_cause_reaches_its_value_beside_what_takes_the_rest() -> None:
    alone, pulled = (find_causes(PulledPlant(cost), lambda text: None) for cost in (None, 215.0))
    assert [cause.effect for cause in pulled.causes] == ["coulomb_friction"]
    low, value, high = torque_interval(alone.causes[0])
    told = torque_interval(pulled.causes[0])
    (beside,) = [single.unknowns for single in [found_fit(0.0, 1.0, (FRICTION, 0.7)).fit]]
    assert told[:2] == (low, value)
    assert told[2] > FRICTION.named(beside)["torque"] > high
    assert torque_interval(pulled.ranked[0].cause) == told


@pytest.mark.parametrize(
    ("pair", "left", "said"),
    [
        (
            215.0,
            1.0,
            "would vanish in the noise if the knee has encoder_offset (that takes too little of the gap to be named); "
            "then the hip has coulomb_friction.",
        ),
        (215.0, 1.7, "No effect in the library explains the remaining 0.079°"),  # no better on the held-out trial
        (389.0, 1.0, "No effect in the library explains the remaining 0.079°"),  # worse odds than friction alone
        (None, 1.0, "Beside it no further cause was tried for the remaining 0.079°"),
    ],
)
def test_no_effect_explains_the_rest_is_said_only_where_all_were_tried(
    pair: float | None, left: float, said: str
) -> None:
    assert said in find_causes(PulledPlant(pair, left), lambda text: None).sentence


def test_a_damper_far_off_its_tolerance_does_not_pull_the_friction_out_of_its_interval() -> None:
    """A damper five tolerances off, which takes under a tenth: friction of 0.05 N m was said to be at most 0.049."""
    (joint,) = ONE.joints
    assert joint.damper is not None
    damper = replace(joint.damper, rate=1.25 * joint.damper.rate)
    built = with_effects(ONE.with_joints(knee={"damper": damper}), {"knee": {"coulomb_friction": {"torque": 0.05}}})
    result = diagnose(ONE, recorded(built, AWAY[:3], noise=np.radians(0.05), time=TIME[:151]), Tolerance())
    assert [cause.effect for cause in result.explanation] == ["coulomb_friction"]
    low, _, high = torque_interval(result.explanation[0])
    assert low < 0.05 < high
    assert "the knee's damper is 24 % stronger than designed" in result.sentence
