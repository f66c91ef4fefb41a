"""What a cause says whose parameter ends at a limit of its search, and delays of recordings in pieces."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from diagnosis.simulated_releases import TWO, recorded
from synth.diagnosis.angle_trials import angle_trial
from synth.diagnosis.cause_intervals import _cause_with_intervals
from synth.diagnosis.plants.swinging_chain.chain_candidates import Candidate, candidates, natural_sizes_of
from synth.diagnosis.search_limits import limit_sentences, parameters_at_limits
from synth.fit.recordings import recordings

TRIALS = [angle_trial(recording, held_out=False) for recording in recordings(TWO, recorded(TWO), ())]
FOUND = candidates(TWO, TRIALS, natural_sizes_of(TWO, TRIALS))


def candidate(effect: str, *free: str) -> Candidate:
    return next(each for each in FOUND if each.effect.name == effect and each.shape.free == free)


def test_a_delay_at_the_limit_of_its_search_has_no_upper_end() -> None:
    late = candidate("latency", "delay")
    high = late.bounds()[1]
    assert parameters_at_limits(late, high) == {"delay": True}
    cause = _cause_with_intervals(late, late.named, high, np.array([1.0]))
    delay = cause.parameters["delay"]
    assert delay.high == np.inf
    assert delay.low is not None
    assert 0.0 < delay.low < delay.value
    assert delay.as_json()["interval90"][1] is None
    (sentence,) = limit_sentences("latency (hip)", late, high, cause)
    assert "is the largest value that the search tries; the true one may be larger" in sentence


def test_a_parameter_within_its_search_has_both_ends_and_no_warning() -> None:
    late = candidate("latency", "delay")
    inside = 0.5 * late.bounds()[1]
    cause = _cause_with_intervals(late, late.named, inside, np.array([0.01]))
    assert np.isfinite([cause.parameters["delay"].low, cause.parameters["delay"].high]).all()
    assert limit_sentences("latency (hip)", late, inside, cause) == []


def test_where_a_parameter_itself_ends_is_no_limit_of_the_search() -> None:
    """A delay of 0, and friction that loses its whole share at speed; a softest spring is one."""
    assert parameters_at_limits(candidate("latency", "delay"), np.zeros(1)) == {}
    rubs = next(each for each in FOUND if each.effect.name == "stribeck_friction")
    k = rubs.shape.free.index("fall")
    x = 0.5 * sum(rubs.bounds())
    x[k] = rubs.bounds()[1][k]
    assert parameters_at_limits(rubs, x) == {}


def test_an_unknown_that_falls_as_its_parameter_rises_opens_the_right_end() -> None:
    """A stiffness is searched by its reciprocal: its highest unknown is the softest hinge."""
    bends = next(each for each in FOUND if each.effect.name == "link_flexibility")
    k = bends.shape.free.index("stiffness")
    x = 0.5 * sum(bends.bounds())
    x[k] = bends.bounds()[1][k]
    assert parameters_at_limits(bends, x) == {"stiffness": False}


def test_natural_sizes_of_pieces_are_those_of_the_recordings() -> None:
    """A fifth of a second of a swing shows its own length, not the swing's period."""
    count = len(TRIALS[0].time)
    begins = [*range(0, count - 20, 20), count]
    pieces = [trial.piece(a, b) for trial in TRIALS for a, b in pairwise(begins)]
    whole, cut = natural_sizes_of(TWO, TRIALS), natural_sizes_of(TWO, pieces)
    for name in ("angle", "speed", "torque", "middle", "half", "settled", "time"):
        np.testing.assert_array_equal(getattr(cut, name), getattr(whole, name))
