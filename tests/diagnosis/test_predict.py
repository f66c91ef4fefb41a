"""Predictions that are integrated together do not influence one another."""

from __future__ import annotations

import numpy as np

from diagnosis.simulated_releases import TWO, recorded
from synth.diagnosis.angle_trials import angle_trial
from synth.diagnosis.lanes import Block
from synth.diagnosis.plants.swinging_chain.chain_candidates import Candidate, candidates, scales
from synth.diagnosis.plants.swinging_chain.chain_predictor import Predictor
from synth.diagnosis.score import first_state
from synth.files.gap_project import Tolerance
from synth.fit.recordings import recordings
from synth.swing.tolerances import Tolerances

(RECORDING,) = recordings(TWO, recorded(TWO, held_out=0)[:1], ())
TRIAL = angle_trial(RECORDING, False)
PREDICTOR = Predictor(TWO, Tolerances.of(TWO, Tolerance()))


def cause(effect: str, joint: str) -> Candidate:
    return next(c for c in candidates(TWO, [TRIAL], scales(TWO, [TRIAL])) if c.key == (effect, joint))


def block(candidate: Candidate, rate: float = 0.0) -> Block:
    """The candidate at its first start, the knee thrown at a rate."""
    state = first_state(TRIAL)
    state[3] += rate
    unknowns = np.concatenate([np.zeros(PREDICTOR.tolerances.size), candidate.starts()[0]])
    return Block((candidate,), unknowns[:, None], state[None, :, None])


def test_a_diverging_lane_leaves_the_others_unchanged() -> None:
    spring, stop = cause("hardening_spring", "knee"), cause("encoder_scale", "hip")
    wild = block(spring)
    wild.unknowns[PREDICTOR.tolerances.size] = -400.0  # a spring that pushes away, the more the farther
    tame = [block(stop), block(spring)]
    (alone,) = PREDICTOR.predict([TRIAL], [tame[0]])
    beside, gone, other = PREDICTOR.predict([TRIAL], [tame[0], wild, tame[1]])
    assert not np.all(np.isfinite(gone))
    assert np.all(np.isfinite(other))
    np.testing.assert_allclose(beside, alone, atol=1e-6)
