"""Filters that the readings' noise went through: found by its spectrum, never in unfiltered motions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import butter, filtfilt, savgol_filter

from diagnosis.simulated_releases import TWO, recorded, with_effects
from synth.arrays import Array
from synth.diagnosis.check.channels import _filtered_findings
from synth.files.trial_list import Trial
from synth.fit.filtered_readings import filtered_words
from synth.fit.noise_spectrum import filter_with_ratio, filtered_noise
from synth.fit.recordings import Recording, recordings
from synth.fit.sensor_noise import AngleSensor, estimate_sensor
from synth.motion.low_pass import LowPass
from synth.noise import difference_scale
from synth.swing.leg_model import Leg

TIME = np.arange(0.0, 2.0, 0.005)  # 200 Hz, for a motion of some hertz
NOISE = np.radians(0.3)
Filter = Callable[[Array], Array]


def mean_of(points: int) -> Filter:
    weights = np.full(points, 1.0 / points)

    def run(angles: Array) -> Array:
        wide = np.pad(angles, ((points, points), (0, 0)), mode="reflect", reflect_type="odd")
        columns = [np.convolve(column, weights, "same")[points:-points] for column in wide.T]
        return np.stack(columns, axis=1)

    return run


def edge(order: int, cutoff: float) -> Filter:
    return lambda angles: filtfilt(*butter(order, 2.0 * cutoff), angles, axis=0)


def polynomial(points: int, order: int) -> Filter:
    return lambda angles: savgol_filter(angles, points, order, axis=0)


def read(filtered: Filter, noise: float = NOISE, leg: Leg = TWO, digits: int = 5) -> tuple[list[Recording], float]:
    """Recordings, and the RMS (rad) of the noise that the filter let through."""
    rng, parts, made = np.random.default_rng(7), [], []
    for trial in recorded(leg, noise=0.0, held_out=0, time=TIME):
        shaken = trial.angles + noise * rng.standard_normal(trial.angles.shape)
        parts.append(filtered(shaken) - filtered(trial.angles))
        made.append(replace(trial, angles=np.radians(np.round(np.degrees(filtered(shaken)), digits))))
    return list(recordings(TWO, made, ())), float(np.std(np.concatenate(parts)))


@pytest.mark.parametrize(
    "filtered",
    [
        *map(mean_of, (3, 5, 9, 15, 21)),
        *(edge(order, cutoff) for order in (2, 4) for cutoff in (1 / 4, 1 / 8)),
        *(polynomial(7, 2), polynomial(11, 3), polynomial(21, 3)),
    ],
)
def test_noise_behind_a_filter_is_what_it_let_through(filtered: Filter) -> None:
    """A mean of 9 leaves a ninth of the noise from one reading to the next: a quarter of it was believed."""
    made, truth = read(filtered)
    found = estimate_sensor(made)
    np.testing.assert_allclose(found.noise, truth, rtol=0.2)
    for j, one in enumerate(found.filters):
        assert one is not None
        (note,) = _filtered_findings("knee", j, found)
        assert "low-pass filtered" in note.text


@pytest.mark.parametrize("points", [3, 9, 21])
def test_a_mean_is_named_with_its_readings(points: int) -> None:
    made, _ = read(mean_of(points))
    found = filtered_noise(made, 1, np.radians(1e-5))
    assert found is not None
    assert found.filter == LowPass("mean", points=points)


@pytest.mark.parametrize("noise", [0.0, 1e-3, 1e-2, 0.3])
@pytest.mark.parametrize(
    "effects",
    [
        {},
        {"knee": {"coulomb_friction": {"torque": 0.1}}},
        {"knee": {"backlash": {"gap": np.radians(2.0)}}},
        {"hip": {"coulomb_friction": {"torque": 0.3}}},
    ],
)
@pytest.mark.parametrize("digits", [2, 5])
def test_an_unfiltered_motion_is_no_filter(noise: float, effects: dict[str, dict[str, object]], digits: int) -> None:
    """Its own curvature, and the corners that friction and backlash make, have no white spectrum either."""
    made, truth = read(lambda angles: angles, np.radians(noise), with_effects(TWO, effects) if effects else TWO, digits)
    found = estimate_sensor(made)
    assert found.by_spectrum == ()
    if noise:
        assert found.filters == (None, None)
        np.testing.assert_allclose(found.noise, np.hypot(truth, np.radians(10.0**-digits) / np.sqrt(12.0)), rtol=0.15)


@pytest.mark.parametrize("one", [LowPass("mean", points=9), LowPass("butterworth", order=2, cutoff=0.1, passes=2)])
def test_drawn_noise_is_as_filtered(one: LowPass) -> None:
    drawn = np.array([one.noise(401, np.random.default_rng(k)) for k in range(40)])
    assert np.std(drawn) == pytest.approx(1.0, rel=0.05)
    if one.kind == "mean":
        assert np.mean(drawn[:, 1:] * drawn[:, :-1]) == pytest.approx(8.0 / 9.0, abs=0.02)
    # So much is left in differences, from which the filter is read again where its spectrum is not seen.
    ratio = float(np.std(np.diff(drawn, 6)) / difference_scale(6))
    again = filter_with_ratio(ratio, 6)
    if one.kind == "butterworth":
        assert again is not None
        assert again.cutoff == pytest.approx(0.1, rel=0.3)
    assert filter_with_ratio(1.0, 6) is None


def test_a_slight_filter_is_noted_too() -> None:
    sensor = AngleSensor(np.ones(1), np.zeros(1), np.ones(1), filters=(LowPass("mean", points=3),), by_spectrum=(0,))
    (note,) = _filtered_findings("knee", 0, sensor)
    assert "a mean of 3 readings" in note.text
    assert _filtered_findings("knee", 0, replace(sensor, by_spectrum=())) == []


def test_steps_between_rests_are_no_filtered_noise() -> None:
    """The spectrum of a servo's log of steps is that of noise behind a slow filter: 10 deg were told, for 0.006."""
    time, noise, rng = np.arange(0.0, 20.0, 0.02), np.radians(0.006), np.random.default_rng(4)
    made = []
    for number in range(3):
        angles, told = np.zeros((len(time), 2)), np.r_[0.0, rng.uniform(-1.2, 1.2, 7)]
        for start, size in zip(np.arange(0.0, 20.0, 2.5), np.diff(told, prepend=0.0), strict=True):
            since = np.maximum(time - start, 0.0)
            settled = 1.0 - np.exp(-5.0 * since) * (np.cos(17.0 * since) + 5.0 / 17.0 * np.sin(17.0 * since))
            angles += size * settled[:, None]
        made.append(Trial(f"{number}.csv", time, angles + noise * rng.standard_normal(angles.shape)))
    sensor = estimate_sensor(list(recordings(TWO, made, ())))
    assert sensor.noise == pytest.approx(noise, rel=0.2)
    assert sensor.by_spectrum == ()


def test_a_filter_near_the_motion_is_told() -> None:
    """At 6 Hz, near the motion's own frequencies, neither a plateau of noise is left nor scatter: nothing was told."""
    made, _ = read(edge(2, 0.03), np.radians(0.02), digits=3)
    found = estimate_sensor(made)
    assert [bool(filtered_words(j, found)) for j in range(2)] == [True, True]
    raw, _ = read(lambda angles: angles, np.radians(0.02), digits=3)
    assert [filtered_words(j, estimate_sensor(raw)) for j in range(2)] == ["", ""]


@pytest.mark.parametrize(("rate", "cutoff", "noise"), [(60.0, 0.1, 0.01), (60.0, 0.2, 0.002), (80.0, 0.1, 0.01)])
def test_where_the_motion_reaches_the_edge_joints_of_one_sensor_have_one_noise(
    rate: float, cutoff: float, noise: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Differences gave 0.017 and 0.043 of it (60 Hz, 0.01 deg), 0.007 and 0.29 (80 Hz): the first joint ruled alone."""
    monkeypatch.setattr("diagnosis.test_low_pass.TIME", np.arange(0.0, 2.0, 1.0 / rate))
    made, true = read(edge(2, cutoff), np.radians(noise))
    found = estimate_sensor(made).noise
    assert found[0] == pytest.approx(found[1])
    assert 0.15 * true < found[0] < 2.6 * true
