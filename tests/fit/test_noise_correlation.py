"""How much less a joint's samples tell whose noise is correlated, where only some of the rows are its own."""

from __future__ import annotations

import numpy as np
import pytest

from synth.arrays import Array, Mask
from synth.files.project_options import FitOptions
from synth.files.trial_list import Trial
from synth.fit.costs import emphasise_transient
from synth.fit.fit_options import LegFitOptions
from synth.fit.methods import fit_by
from synth.fit.misfits import misfits
from synth.fit.recordings import Recording, recordings
from synth.fit.uncertainty import correlation_times
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

STEP, ROWS = 0.0025, 3000
TIME = STEP * np.arange(ROWS)
NOISE = np.radians(0.3)
LEG = Leg(
    "two",
    (
        Joint("hip", Link(0.25, 0.6, 0.11, 4e-3), 0.4, 1, None, Spring(6.0, 0.5), Damper(0.08)),
        Joint("knee", Link(0.22, 0.35, 0.09, 2e-3), 2.0, -1, None, Spring(1.5, 1.8), Damper(0.015)),
    ),
)
RELEASES = ((0.5, -0.7), (-0.5, 0.4), (0.3, 0.7), (-0.4, -0.6))  # rad from the free angles, hip and knee
ALL = np.ones(ROWS, dtype=bool)
EVERY_FOURTH = np.arange(ROWS) % 4 == 0


def wandering(a: float, seed: int) -> Array:
    """(m, 2) rad, noise correlated by ``a`` from row to row."""
    noise = np.random.default_rng(seed).normal(0.0, NOISE * np.sqrt(1.0 - a**2), (ROWS, 2))
    noise[0] /= np.sqrt(1.0 - a**2)
    for k in range(1, ROWS):
        noise[k] += a * noise[k - 1]
    return noise


def trials(a: float, known: Mask) -> list[Trial]:
    """Releases whose knee is read in the rows ``known`` (m,)."""
    made = []
    for seed, apart in enumerate(RELEASES):
        rotation = simulate(LEG, LEG.rest + np.array(apart), [0.0, 0.0], TIME)
        angle = LEG.to_measured(rotation + wandering(a, seed))
        angle[~known, 1] = np.nan
        made.append(Trial(f"{seed}.csv", TIME, angle))
    return made


def of_mean(a: float, counts: Mask) -> float:
    """Variance of the mean of the values that count over that of as many independent ones."""
    places = np.flatnonzero(counts)
    return float(np.mean(np.sum(a ** np.abs(places[:, None] - places), axis=1)))


def times_about_the_truth(made: list[Recording]) -> Array:
    """(2,) factors of the joints, alike in all trials."""
    truth = [simulate(LEG, LEG.rest + np.array(apart), [0.0, 0.0], TIME) for apart in RELEASES]
    found = correlation_times(made, truth)
    assert np.all(found == found[0])
    return found[0]


def test_of_a_joint_that_is_read_in_every_fourth_row() -> None:
    """It was 1 at the knee, whatever the noise."""
    hip, knee = times_about_the_truth(recordings(LEG, trials(0.8, EVERY_FOURTH)))
    assert hip == pytest.approx(of_mean(0.8, ALL), rel=0.25)
    assert knee == pytest.approx(of_mean(0.8, EVERY_FOURTH), rel=0.25)


def test_of_the_samples_that_the_transient_cost_counts() -> None:
    made = emphasise_transient(recordings(LEG, trials(0.9, ALL)))
    assert times_about_the_truth(made) == pytest.approx(of_mean(0.9, made[0].counts[:, 0]), rel=0.25)


def test_the_transient_cost_counts_every_tenth_sample_of_each_joint() -> None:
    """Of a joint that is read in the rows between, no later sample counted: every tenth row was the other's."""
    in_turn = np.arange(ROWS)[:, None] % 2 == np.arange(2)
    (made,) = recordings(LEG, [Trial("1.csv", TIME, np.where(in_turn, trials(0.0, ALL)[0].angles, np.nan))])
    (thin,) = emphasise_transient([made])
    later = TIME > 0.2
    np.testing.assert_array_equal(thin.counts[~later], made.counts[~later])
    assert thin.counts[later].sum(axis=0) == pytest.approx(0.1 * made.counts[later].sum(axis=0), abs=1)
    np.testing.assert_array_equal(thin.known, made.known)
    np.testing.assert_array_equal(thin.moments, made.moments)
    assert thin.step == made.step
    some = thin.thinned(100)
    assert np.all(some.counts.sum(axis=0) >= 50)
    assert not np.any(some.known[:, 0] & some.known[:, 1])
    assert len(thin.later(100).known) == ROWS - 100


def test_intervals_are_those_of_the_same_samples_without_the_rows_between() -> None:
    """With empty cells between, they were a fifth as wide and held the free angle in 17 % of 60 data sets."""
    pendulum = Leg("one", LEG.joints[:1])
    bare = pendulum.with_joints(hip={"spring": None, "damper": None})
    between, beside = [], []
    for seed, (apart, _) in enumerate(RELEASES):
        angle = pendulum.to_measured(simulate(pendulum, pendulum.rest + apart, [0.0], TIME))
        angle += wandering(0.97, seed)[:, :1]
        between.append(Trial(f"{seed}.csv", TIME, np.where(EVERY_FOURTH[:, None], angle, np.nan)))
        beside.append(Trial(f"{seed}.csv", TIME[EVERY_FOURTH], angle[EVERY_FOURTH]))
    options = LegFitOptions("common", release="recorded", laws="linear")
    fits = [fit_by(bare, recordings(bare, given), options, FitOptions()).joints["hip"] for given in (between, beside)]
    ends = [
        [(each.low, each.high) for each in (fit.spring_rate, fit.damper_rate, fit.free_angle) if each is not None]
        for fit in fits
    ]
    np.testing.assert_allclose(*ends, rtol=1e-4)


def test_a_residual_above_the_samples_scatter_may_be_noise_that_lasts() -> None:
    """Of 40 simulated legs with markers that err alike for 150 ms 8 hips were said to lack an effect; none did."""
    rms, scatter = {"hip": np.radians(0.6)}, {"hip": np.radians(0.1)}
    (text,) = misfits(rms, scatter, np.array([True]), LegFitOptions(), np.array([False]))
    assert "the model lacks an effect at this joint or next to it, or its readings err alike" in text
