"""A ladder of sizes that meets a bound where its cause is absent: only rungs with a size tell the response."""

from __future__ import annotations

import numpy as np

from diagnosis.simulated_releases import TWO, off, recorded
from synth.diagnosis.check.cause_responses import COMPARED_SIGNAL, _response_from_zero
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.plants.swinging_chain.chain_candidates import candidates, natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import scene_of
from synth.files.gap_project import Tolerance


def test_the_integrator_s_own_error_at_no_size_is_no_response() -> None:
    """With 30 kg stated for 30 g at the foot it was taken as the response: a latency of 0, and a traceback."""
    scene, _ = scene_of(TWO, recorded(off(TWO, 3), seed=1), Tolerance(), 0)
    every = candidates(TWO, scene.given, natural_sizes_of(TWO, scene.given), scene.legs)
    late = next(each for each in every if each.key == ("latency", "hip") and each.size == 1)
    first = scene.bench.n_tolerance
    ladder = [
        EvaluatedHypothesis((late,), np.concatenate([np.zeros(first), [size]]), ()) for size in (0.005, 0.05, 0.0, 0.2)
    ]
    signal = COMPARED_SIGNAL * np.array([4.0, 9.0, 1.0, 28.0])
    found = _response_from_zero(ladder[1], ladder, signal, signal, first)
    assert found is not None
    assert found.fit.unknowns[first] > 0.0
