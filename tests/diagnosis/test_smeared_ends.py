"""Filtered recordings in a diagnosis: what the filter smears is left out and told; others are as they were."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, filtfilt

from diagnosis.simulated_releases import TWO, recorded
from synth.diagnosis.plants.swinging_chain.smeared_ends import without_smeared_ends
from synth.fit.recordings import Recording, recordings

TIME, HELD = np.arange(0.0, 2.0, 0.005), 100  # s; samples in which the leg is held before its release


def read(cutoff: float) -> list[Recording]:
    """Releases from rest that went through a filter, Hz, together with the time before; 0 for none."""
    rng, made = np.random.default_rng(5), []
    for trial in recorded(TWO, noise=0.0, held_out=0, time=TIME):
        whole = np.vstack([np.repeat(trial.angles[:1], HELD, axis=0), trial.angles])
        whole = whole + np.radians(0.1) * rng.standard_normal(whole.shape)
        if cutoff:
            whole = filtfilt(*butter(2, cutoff / 100.0), whole, axis=0)
        made.append(replace(trial, angles=whole[HELD:]))
    return list(recordings(TWO, made, ()))


def test_what_a_filter_smears_is_left_out_and_told() -> None:
    """Of a leg as designed the verdict was unknown, with a moving base first: the filter rounds off the release."""
    made = read(20.0)
    cut, (remark,) = without_smeared_ends(TWO, made)
    reach = 0.5 * (made[0].time[-1] - cut[0].time[-1])
    assert 1.0 / 20.0 < reach < 3.0 / 20.0
    assert "low-pass filtered" in remark
    told = re.search(r"the first and last (\d+) ms", remark)
    assert told is not None
    assert 1e-3 * float(told[1]) == pytest.approx(reach, abs=0.005)  # a sample
    for whole, inner in zip(made, cut, strict=True):
        first = round(reach / 0.005)
        np.testing.assert_array_equal(inner.rotation, whole.rotation[first : first + len(inner.time)])
        assert len(inner.smoothed.time) >= len(inner.time) - 1
        assert inner.name == whole.name


def test_raw_readings_are_as_they_were() -> None:
    made = read(0.0)
    cut, remarks = without_smeared_ends(TWO, made)
    assert all(a is b for a, b in zip(made, cut, strict=True))
    assert remarks == []
