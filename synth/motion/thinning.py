"""Recordings sampled much faster than the motion: groups of neighbouring samples are averaged without loss.

The mean of a group of k samples has 1/sqrt(k) of the noise of one sample, and it contains all the information if the
motion is linear over the group. Curvature over a group's length T adds x'' T^2 / 24: an amplitude smaller by (w T)^2 /
24 at a frequency w, equal in every sample and absorbed by the initial state; frequency and decay are unchanged. A group
may be as long as this error is below the noise of its mean.

A channel with counts coarser than its noise is not averaged, since the mean of counts is not a count and looks more
certain than it is (see ``fit.rounding``): the middle sample represents the group, which is so short that the joint
moves by less than a count in it, so that no count is skipped.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

import numpy as np

from synth.arrays import Array, Mask
from synth.motion.counts import coarse_count
from synth.motion.group_spread import GroupSpread
from synth.noise import white_noise
from synth.sampling import own_moments, usual_step

UNTHINNED_SAMPLES = 6_000  # samples, up to which a recording is unchanged
LEAST_SAMPLES = 2_500  # samples that are kept at least
BENT = 0.5  # of a mean's noise, largest curvature error of all but the fastest 2 % of the samples
FASTEST = 98.0  # percentile of a stretch of the recording
STRETCHES = 20  # the fastest one counts: a long rest does not hide the swing before it
DIFFERENCE = 6  # order of differences that isolate noise, as in ``fit.sensor_noise``
LEAST_GOOD_SHARE = 0.7  # share of a group's samples that must be good
HOLE = 1.5  # times its usual length, above which a group contains a gap


@dataclass(frozen=True)
class ThinnedRecording:
    """``time`` (m,) s, ``angle`` (m, n) rad and ``lost`` (m, n); groups of ``group`` samples out of ``rows``.

    ``averaged`` (n,) : readings in each angle; 1 where the middle one of a group stands for it. ``spread`` : of the
    samples about the angles; None without thinning.
    """

    time: Array
    angle: Array
    lost: Mask
    group: int
    rows: int
    averaged: tuple[int, ...]
    spread: GroupSpread | None = None

    @property
    def sentence(self) -> str:
        """A sentence on the thinning; empty without thinning."""
        if self.group == 1:
            return ""
        step = usual_step(self.time, ~self.lost)
        return (
            f"{self.rows} samples over {self.time[-1] - self.time[0]:.3g} s are more than the motion needs: "
            f"groups of {self.group} are averaged, {len(self.time)} in total, {1e3 * step:.3g} ms apart"
        )


def thin_recording(time: Array, angle: Array, lost: Mask) -> ThinnedRecording:
    """A recording with as many samples as its motion needs.

    Parameters
    ----------
    time : (n,) s, rising; angle : (n, n_joint) rad; lost : (n, n_joint), from ``lost_samples``.
    """
    rows = len(time)
    if rows <= UNTHINNED_SAMPLES:
        return ThinnedRecording(time, angle, lost, 1, rows, angle.shape[1] * (1,))
    own = own_moments(time, ~lost)
    if not own.all():
        return _thin_apart(time, angle, lost, own)
    bridged = np.empty_like(angle)
    for j in range(angle.shape[1]):
        good = ~lost[:, j]
        bridged[:, j] = np.interp(time, time[good], angle[good, j]) if good.any() else 0.0
    noise = np.array([white_noise(bridged[:, j], DIFFERENCE) for j in range(angle.shape[1])])
    counts = np.array([coarse_count(angle[~lost[:, j], j], float(noise[j])) for j in range(angle.shape[1])])
    group = _odd_size(rows // LEAST_SAMPLES)
    while group > 1 and not _straight(bridged, noise, counts, group):
        group = _odd_size(group // 2)
    if group < 3:
        return ThinnedRecording(time, angle, lost, 1, rows, angle.shape[1] * (1,))
    return _group_means(time, bridged, lost, group, counts)


def _thin_apart(time: Array, angle: Array, lost: Mask, own: Mask) -> ThinnedRecording:
    """Of joints with moments of their own, ``own`` (n, n_joint): those that share them by themselves, then together."""
    columns = [np.flatnonzero((own == own[:, [j]]).all(axis=0)) for j in range(own.shape[1])]
    groups = [each for j, each in enumerate(columns) if each[0] == j]
    parts = [thin_recording(time[r], angle[r][:, j], lost[r][:, j]) for j in groups for r in [own[:, j[0]]]]
    every = np.unique(np.concatenate([part.time for part in parts]))
    together, missing = np.full((len(every), own.shape[1]), np.nan), np.ones((len(every), own.shape[1]), dtype=bool)
    averaged, spread = np.ones(own.shape[1], dtype=int), GroupSpread.single(len(every), own.shape[1])
    for j, part in zip(groups, parts, strict=True):
        at = np.ix_(np.searchsorted(every, part.time), j)
        together[at], missing[at], averaged[j] = part.angle, part.lost, part.averaged
        if part.spread is not None:
            spread.sums[:, at[0], at[1]] = part.spread.sums
    group = max(part.group for part in parts)
    thinned = spread if group > 1 else None
    return ThinnedRecording(every, together, missing, group, len(time), tuple(averaged.tolist()), thinned)


def _odd_size(group: int) -> int:
    """At most ``group``, with a middle sample."""
    return max(group - (1 - group % 2), 1)


def _straight(angle: Array, noise: Array, counts: Array, group: int) -> bool:
    """Whether the motion's curvature over a group is below the noise of its mean.

    Second differences of the means are x'' T^2, and their own noise. With coarse counts: whether it moves by less than
    one.
    """
    means = _means(angle, group)
    bend = _hardest(np.diff(means, 2, axis=0)) / 24.0 <= BENT * noise / sqrt(group) + 1e-9
    turn = _hardest(np.diff(angle[group // 2 :: group], axis=0)) <= 1.001 * counts  # one count, and its rounding
    return bool(np.all(np.where(counts > 0.0, turn, bend)))


def _hardest(change: Array) -> Array:
    """(n,) the ``FASTEST`` percentile of the sizes of changes (m, n) in the stretch where it is largest."""
    stretches = np.array_split(np.abs(change), STRETCHES)
    return np.asarray(np.max([np.percentile(part, FASTEST, axis=0) for part in stretches], axis=0))


def _means(values: Array, group: int) -> Array:
    """(m, ...) means of whole groups; an incomplete last group is dropped."""
    count = len(values) // group
    return np.asarray(values[: count * group].reshape(count, group, *values.shape[1:]).mean(axis=1))


def _group_means(time: Array, angle: Array, lost: Mask, group: int, counts: Array) -> ThinnedRecording:
    count = len(time) // group
    middle = group // 2 + group * np.arange(count)
    mean, few = _means(angle, group), _means(lost.astype(float), group) > 1.0 - LEAST_GOOD_SHARE
    for j in np.flatnonzero(counts > 0.0):
        mean[:, j], few[:, j] = angle[middle, j], lost[middle, j]
    length = time[group - 1 + group * np.arange(count)] - time[group * np.arange(count)]
    few |= (length > HOLE * np.median(length))[:, None]
    averaged = tuple(np.where(counts > 0.0, 1, group).tolist())
    middles = _means(time, group)
    spread = GroupSpread.of((time, angle, lost), (middles, mean), group)
    return ThinnedRecording(middles, mean, few, group, len(time), averaged, spread)
