"""Predictions that are integrated together do not influence one another."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from diagnosis.simulated_releases import TWO, recorded
from synth.diagnosis.angle_trials import AngleTrial, angle_trial, trials_together
from synth.diagnosis.lanes import Block
from synth.diagnosis.plants.swinging_chain.chain_candidates import Candidate, candidates, natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_predictor import Predictor
from synth.diagnosis.score import first_state
from synth.files.gap_project import Tolerance
from synth.fit.recordings import recordings
from synth.swing.chain import Conditions
from synth.swing.tolerances import Tolerances

(RECORDING,) = recordings(TWO, recorded(TWO, held_out=0)[:1], ())
TRIAL = angle_trial(RECORDING, held_out=False)
PREDICTOR = Predictor(TWO, Tolerances.of(TWO, Tolerance()))


def cause(effect: str, joint: str) -> Candidate:
    return next(c for c in candidates(TWO, [TRIAL], natural_sizes_of(TWO, [TRIAL])) if c.key == (effect, joint))


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


def driven_pieces() -> list[AngleTrial]:
    """Pieces of the recording as if a torque had driven its knee."""
    time = np.linspace(0.0, RECORDING.time[-1], 200)
    torque = np.stack([np.zeros(200), 0.02 * np.sin(30.0 * time)], axis=1)
    whole = angle_trial(replace(RECORDING, known_torque=(time, torque)), held_out=False)
    ends = np.linspace(0, len(whole.time), 6).astype(int).tolist()
    return [whole.piece(first, last) for first, last in pairwise(ends)]


def block_of(pieces: list[AngleTrial], effect: str, joint: str) -> Block:
    """The cause at its first start, each of the ``pieces`` from the state that it shows."""
    found = next(c for c in candidates(TWO, pieces, natural_sizes_of(TWO, pieces)) if c.key == (effect, joint))
    unknowns = np.concatenate([np.zeros(PREDICTOR.tolerances.size), found.starts()[0]])
    added = np.zeros(2 * found.links)
    states = np.array([np.concatenate([first_state(piece), added]) for piece in pieces])
    return Block((found,), unknowns[:, None], states[:, :, None])


def alone(block: Block, number: int) -> Block:
    return replace(block, state=block.state[number : number + 1])


CAUSES = ("torque_delay", "torque_offset", "latency", "spring_hysteresis", "coulomb_friction", "link_flexibility")


@pytest.mark.parametrize("effect", CAUSES)
def test_pieces_predicted_in_one_call_are_as_those_predicted_alone(effect: str) -> None:
    pieces = driven_pieces()
    joint = "knee" if effect.startswith("torque") else "hip"
    wanted, other = block_of(pieces, effect, joint), block_of(pieces, "encoder_scale", "knee")
    first = 0
    (found, _) = PREDICTOR.predict(pieces, [wanted, other])
    for number, piece in enumerate(pieces):
        last = first + len(piece.time)
        by_itself, _ = PREDICTOR.predict([piece], [alone(wanted, number), alone(other, number)])
        np.testing.assert_allclose(found[first:last], by_itself, atol=0.3 * PREDICTOR.tolerance)  # rounded times
        first = last
    assert first == len(found)


def test_a_lane_that_diverges_in_one_piece_leaves_all_others_unchanged() -> None:
    pieces = driven_pieces()
    wild, tame = block_of(pieces, "hardening_spring", "knee"), block_of(pieces, "encoder_scale", "hip")
    wild.unknowns[PREDICTOR.tolerances.size] = -400.0
    wild.state[[0, 1, 3, 4], :4] = 0.0  # at rest, unloaded: the third piece runs away
    (by_itself,) = PREDICTOR.predict(pieces, [tame])
    gone, beside = PREDICTOR.predict(pieces, [wild, tame])
    rows = np.cumsum([0, *[len(piece.time) for piece in pieces]])
    diverged = [not np.all(np.isfinite(gone[a:b])) for a, b in pairwise(rows)]
    assert diverged[2]
    np.testing.assert_allclose(beside, by_itself, atol=1e-6)


def test_only_neighbouring_pieces_with_the_same_torque_are_predicted_in_one_call() -> None:
    pieces = driven_pieces()
    known = pieces[3].recording.known_torque
    assert known is not None
    otherwise = replace(pieces[3].recording, known_torque=(known[0], 2.0 * known[1]))
    pieces[3] = replace(pieces[3], recording=otherwise)
    assert trials_together([TRIAL, *pieces, TRIAL]) == [
        range(1), range(1, 4), range(4, 5), range(5, 6), range(6, 7)
    ]  # fmt: skip


def test_trials_that_nothing_drives_are_predicted_in_one_call_as_alone() -> None:
    """Those with another joint locked, or of another time scale, in calls of their own."""
    trials = [angle_trial(each, held_out=False) for each in recordings(TWO, recorded(TWO, held_out=0), ())]
    assert trials_together(trials) == [range(len(trials))]
    held = replace(trials[1], recording=replace(trials[1].recording, conditions=Conditions(locked=(0,))))
    slow = trials[2].recording
    slower = replace(trials[2], recording=replace(slow, smoothed=replace(slow.smoothed, pace=9.0 * slow.smoothed.pace)))
    assert trials_together([trials[0], held, slower, trials[3]]) == [range(k, k + 1) for k in range(4)]
    wanted, fine = block_of(trials, "spring_hysteresis", "hip"), PREDICTOR.coarser(1e-10)  # another unit of time
    (found,) = fine.predict(trials, [wanted])
    ends = np.cumsum([0, *[len(trial.time) for trial in trials]]).tolist()
    for number, (trial, (first, last)) in enumerate(zip(trials, pairwise(ends), strict=True)):
        (by_itself,) = fine.predict([trial], [alone(wanted, number)])
        np.testing.assert_allclose(found[first:last], by_itself, atol=1e-7)
