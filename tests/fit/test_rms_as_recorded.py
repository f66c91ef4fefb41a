"""The stated RMS is over the samples as recorded, where a recording is thinned too."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fit.test_moments_apart import LEG, NOISE
from synth.arrays import Array
from synth.files.trial_list import Trial
from synth.fit.estimate import fit_leg
from synth.fit.recordings import Recording, recordings
from synth.fit.uncertainty import rms_as_recorded, root_mean_square, sample_scatter, scatter_as_recorded
from synth.swing.chain import simulate

START = np.array([0.5, 0.7])


def moved(time: Array, slower: float = 1.0) -> Array:
    """The leg's rotations (m, 2) rad at these times, or of a motion ``slower`` times as slow."""
    from_zero = np.r_[0.0, time / slower] if time[0] > 0.0 else time / slower
    return simulate(LEG, LEG.rest + START, [0.0, 0.0], from_zero)[-len(time) :]


def trial(rate: float, seconds: float, *, count: float = 0.0, lost: float = 0.0, seed: int = 1) -> Trial:
    """A release with noise, in counts of ``count`` rad, and a share ``lost`` of its samples missing."""
    time, turn = np.arange(0.0, seconds, 1.0 / rate), np.random.default_rng(seed)
    angles: Array = LEG.to_measured(moved(time)) + turn.normal(0.0, NOISE, (len(time), 2))
    angles = np.round(angles / count) * count if count else angles
    angles[turn.random(angles.shape) < lost] = np.nan
    return Trial(f"{seed}.csv", time, angles)


def of_all_samples(given: Trial) -> Array:
    """(2,) rad, RMS of the motion over the trial's samples, without the program's reading."""
    return np.asarray(np.sqrt(np.nanmean((given.angles - LEG.to_measured(moved(given.time))) ** 2, axis=0)))


def of_groups(recording: Recording, given: Trial, slower: float = 1.0) -> Array:
    """The program's figure, at the groups' own times."""
    begin = given.time[: len(given.time) // len(recording.time)].mean()
    return rms_as_recorded([recording], [moved(recording.time + begin * slower, slower)])


@pytest.mark.parametrize(
    ("count", "lost"), [(0.0, 0.0), (0.0, 0.02), (np.radians(0.36), 0.0)], ids=["means", "lost samples", "counts"]
)
def test_a_motions_rms_over_a_thinned_recording_is_that_over_all_its_samples(count: float, lost: float) -> None:
    given = trial(10_000, 0.8, count=count, lost=lost)
    (found,) = recordings(LEG, [given])
    assert len(found.time) < 3_000
    np.testing.assert_allclose(of_groups(found, given), of_all_samples(given), rtol=5e-3)


def test_it_stays_so_for_slowed_and_cut_recordings() -> None:
    given = trial(10_000, 0.8)
    (found,) = recordings(LEG, [given])
    whole = of_groups(found, given)
    np.testing.assert_allclose(of_groups(found.stretched(2.0), given, 2.0), whole, rtol=1e-3)
    halves = [found.between(0.0, 0.4), found.later(len(found.time) // 2)]
    for half in halves:
        assert half.spread is not None
        assert half.spread.sums.shape[1:] == half.rotation.shape


def test_the_fit_states_it_for_trials_of_any_rate_and_beside_it_the_samples_scatter() -> None:
    """A fast trial's means had 0.03 deg beside a slow one's 0.05, and the joint's figure mixed both."""
    trials = [trial(10_000, 0.8), trial(120, 3.0, seed=2)]
    read = recordings(LEG, trials)
    found = fit_leg(LEG, read)
    for name in LEG.joint_names:
        assert found.rms[name] == pytest.approx(NOISE, rel=0.06)
        assert found.noise[name] == pytest.approx(NOISE, rel=0.15)
        assert found.averaged_rms[name] < 0.8 * NOISE
    for each in found.trials:
        np.testing.assert_allclose(each.rms, NOISE, rtol=0.08)


def test_recordings_that_are_not_thinned_have_the_plain_figures() -> None:
    read = recordings(LEG, [trial(500, 1.0), trial(200, 1.0, seed=2)])
    predictions = [moved(each.time) for each in read]
    np.testing.assert_array_equal(rms_as_recorded(read, predictions), root_mean_square(read, predictions))
    scatter = sample_scatter(read)
    assert scatter_as_recorded(read, scatter) is scatter
    none = [replace(each, counts=np.zeros_like(each.counts)) for each in recordings(LEG, [trial(10_000, 0.8)])]
    assert np.isnan(rms_as_recorded(none, [each.rotation for each in none])).all()
