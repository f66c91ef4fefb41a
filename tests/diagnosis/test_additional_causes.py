"""Two and three causes: searched only where fewer leave an error above the noise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import Bounds, minimize

from diagnosis.simulated_releases import TWO, causes, off, recorded, with_effects
from synth.arrays import Array
from synth.diagnosis.angle_search import as_designed, search
from synth.diagnosis.angle_trials import angle_trial
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.odds import CALIBRATED
from synth.diagnosis.plants.swinging_chain.chain_candidates import Candidate, candidates, compatible, natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import EFFECTIVE_SAMPLES, diagnose
from synth.diagnosis.plants.swinging_chain.chain_predictor import Predictor
from synth.diagnosis.screening import ScreeningFrame, costs_after_step, costs_by_secant, scale_strengths
from synth.diagnosis.search_limits import LARGEST_TOLERANCE
from synth.diagnosis.workbench import Workbench
from synth.files.gap_project import Tolerance
from synth.fit.recordings import recordings
from synth.fit.sensor_noise import estimate_sensor
from synth.swing.leg_model import Leg
from synth.swing.tolerances import Tolerances

FRICTION_AND_OFFSET = {"hip": {"coulomb_friction": {"torque": 0.15}}, "knee": {"encoder_offset": {"offset": 0.08}}}


def bench_of(built: Leg, seed: int = 3) -> tuple[Workbench, list[Candidate]]:
    """What a diagnosis would work on, and its candidates."""
    made = recordings(TWO, recorded(built, seed=seed), ())
    trials = tuple(angle_trial(recording, held_out=False) for recording in made)
    noise = estimate_sensor([trial.recording for trial in trials]).noise
    bench = Workbench(Predictor(TWO, Tolerances.of(TWO, Tolerance())), trials, noise, EFFECTIVE_SAMPLES)
    return bench, candidates(TWO, trials, natural_sizes_of(TWO, trials))


def candidate_of(found: list[Candidate], effect: str, joint: str) -> Candidate:
    return next(candidate for candidate in found if candidate.key == (effect, joint))


def test_friction_and_an_encoder_offset_are_found_together() -> None:
    result = diagnose(TWO, recorded(with_effects(off(TWO, 4), FRICTION_AND_OFFSET), seed=2), Tolerance())
    assert set(causes(result)) == {("coulomb_friction", "hip"), ("encoder_offset", "knee")}
    by_name = {cause.effect: cause.parameters for cause in result.explanation}
    assert by_name["coulomb_friction"]["torque"].value == pytest.approx(0.15, rel=0.15)
    assert by_name["encoder_offset"]["offset"].value == pytest.approx(0.08, rel=0.15)
    assert result.shrink.value > 0.9


def test_three_causes_are_tried_and_leave_only_noise() -> None:
    three = {
        "hip": {"coulomb_friction": {"torque": 0.15}},
        "knee": {"encoder_offset": {"offset": 0.08}, "quadratic_damping": {"coefficient": 0.008}},
    }
    bench, found = bench_of(with_effects(off(TWO, 4), three))
    best = min(search(bench, found, CALIBRATED).several, key=lambda assessed: assessed.cost)
    assert len(best.keys) == 3
    assert best.ratio < 1.1


def test_no_second_cause_is_searched_when_one_leaves_only_noise() -> None:
    bench, found = bench_of(with_effects(off(TWO, 4), {"hip": FRICTION_AND_OFFSET["hip"]}))
    assert search(bench, found, CALIBRATED).several == ()


def test_incompatible_causes_are_not_combined() -> None:
    _, found = bench_of(TWO)
    coulomb = candidate_of(found, "coulomb_friction", "hip")
    assert not compatible(coulomb, coulomb)
    assert not compatible(coulomb, candidate_of(found, "stribeck_friction", "hip"))
    assert compatible(coulomb, candidate_of(found, "stribeck_friction", "knee"))
    assert compatible(candidate_of(found, "base_compliance", "base"), candidate_of(found, "link_flexibility", "hip"))


def test_the_secant_estimates_the_effects_strength() -> None:
    bench, found = bench_of(with_effects(TWO, {"knee": {"encoder_offset": {"offset": 0.04}}}))
    designed = as_designed(bench)
    candidate = candidate_of(found, "encoder_offset", "knee")
    unknowns = np.concatenate([designed.unknowns, candidate.starts()[0]])
    start = EvaluatedHypothesis((candidate,), unknowns, designed.states)
    ((cost, times),) = costs_by_secant(bench, [start], designed)
    right = scale_strengths(start, len(designed.unknowns), times)
    assert candidate.named(right.unknowns[len(designed.unknowns) :])["offset"] == pytest.approx(0.04, rel=0.3)
    assert cost < 0.4 * designed.cost
    assert costs_after_step(bench, [right], designed)[0] == pytest.approx(cost, rel=0.3)


@pytest.mark.parametrize("friction_torque", [0.1, 0.2])
def test_screening_promises_the_least_linearised_cost_within_the_tolerances_bounds(friction_torque: float) -> None:
    """Beside friction fitted for itself, too weak: its unknowns and the tolerances follow, these to their bounds."""
    bench, found = bench_of(with_effects(TWO, {"hip": {"coulomb_friction": {"torque": friction_torque}}}))
    designed = as_designed(bench)
    friction = candidate_of(found, "coulomb_friction", "hip")
    weak = EvaluatedHypothesis((friction,), np.concatenate([designed.unknowns, friction.starts()[0]]), designed.states)
    here = bench.evaluate([weak])[0]
    here = replace(here, frame=bench.frame(here))
    nothing = candidate_of(found, "encoder_offset", "knee")
    start = EvaluatedHypothesis((friction, nothing), np.concatenate([here.unknowns, [0.0]]), here.states)
    (promised,) = costs_after_step(bench, [start], here)
    ground = ScreeningFrame.of(bench, here)
    left = [ground.project(i, residual) for i, residual in enumerate(here.residuals)]

    def cost(step: Array) -> float:
        squares = sum(float(np.sum((e + s @ step) ** 2)) for e, s in zip(left, ground.slopes, strict=True))
        return bench.unknown_size.cost(squares, here.unknowns + step)

    low, high = (np.append(bound, [side, side]) for bound, side in zip(bench.bounds(()), (-20.0, 20.0), strict=True))
    best = minimize(cost, np.zeros(len(low)), bounds=Bounds(low - here.unknowns, high - here.unknowns))
    assert promised < 0.8 * here.cost
    assert promised == pytest.approx(best.fun, rel=1e-3)
    at_bound = np.isclose(np.abs(here.unknowns + best.x)[: bench.n_tolerance], LARGEST_TOLERANCE)
    assert at_bound.any() == (friction_torque == 0.2)
