"""Gaps that a program filled by lines or cubics are no readings; motions and coarse counts are kept."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from synth.motion.filled_gaps import filled_gaps
from synth.motion.importers.cleaning import remarks
from synth.motion.smoothing import lost_samples
from synth.swing.leg_model import Joint, Leg, Link

TIME = np.arange(0.0, 1.2, 0.005)
MOTION = np.radians(105.0 + 25.0 * np.exp(-2.5 * TIME) * np.cos(2 * np.pi * 2.0 * TIME))


def read(seed: int, noise: float = 0.1) -> np.ndarray:
    """(240,) rad, a swing with white noise of so many deg, written with four decimals of a degree."""
    found = MOTION + np.radians(noise) * np.random.default_rng(seed).normal(size=len(TIME))
    return np.asarray(np.radians(np.round(np.degrees(found), 4)))


@pytest.mark.parametrize("cubic", [False, True])
@pytest.mark.parametrize("at", [30, 66, 150])
@pytest.mark.parametrize("length", [8, 24])
def test_what_a_program_filled_is_lost(length: int, at: int, cubic: bool) -> None:
    angle, known = read(at), np.ones(len(TIME), dtype=bool)
    known[at : at + length] = False
    filled = CubicSpline(TIME[known], angle[known])(TIME) if cubic else np.interp(TIME, TIME[known], angle[known])
    angle = np.radians(np.round(np.degrees(filled), 4))
    angle[200] = np.nan  # a frame that is missing, and an outlier, leave the rest of the channel to be searched
    angle[210] += 0.5
    lost = np.flatnonzero(lost_samples(TIME, angle[:, None])[:, 0])
    expected = {*range(at, at + length), 200, 210}
    assert expected <= set(lost.tolist())
    assert len(lost) <= len(expected) + 1  # a measured sample may lie on the cubic by chance
    told = " ".join(
        remarks(TIME, angle[:, None], Leg("shank", (Joint("knee", Link(0.2, 0.2, 0.1, 1e-3)),), gravity=9.81))
    )
    assert "samples lie on straight lines or cubics (first at" in told
    assert "1 sample is an outlier (at 1.050 s)" in told


def test_readings_are_no_filled_gaps() -> None:
    """White noise, a motion without any, one that is filtered, counts of a coarse encoder, and a joint at a stop."""
    generator, kept = np.random.default_rng(0), np.ones(16) / 16.0
    for seed in range(200):
        assert not filled_gaps(TIME, read(seed)).any()
        smooth = np.convolve(generator.normal(size=len(TIME) + 15), kept, "valid")
        assert not filled_gaps(TIME, MOTION + np.radians(0.3) * smooth).any()
    assert not filled_gaps(TIME, MOTION).any()
    for count in (0.01, 0.1, 0.5):
        rounded = np.radians(np.round(np.degrees(MOTION) / count) * count)
        assert not filled_gaps(TIME, rounded).any()
    assert not filled_gaps(TIME, np.minimum(read(0), np.radians(110.0))).any()
