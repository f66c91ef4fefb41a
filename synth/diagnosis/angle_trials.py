"""Preparation of trials for the diagnosis: thin samples, pieces, trials that are predicted together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array, Mask
from synth.fit.recordings import Recording
from synth.sampling import every_nth
from synth.swing.time_unit import time_unit

MOST_PACE_RATIO = 4.0  # most ratio of the time scales of trials that are simulated together
MOST_SAMPLES_TOGETHER = 4000  # samples of the trials that one call predicts: the readings of 250 legs then take 24 MB
SAMPLES_A_TRIAL = 700  # per trial: enough for the fastest joint, few enough to be fast


@dataclass(frozen=True)
class AngleTrial:
    """One trial, thinned: ``time`` (m,) s from 0, ``measured`` (m, n) rad in the sense of q, ``counts`` (m, n).

    ``relative`` (m, n): standard deviation of a sample relative to its channel's noise; None if all are equal.
    ``part_of`` : the trial that it is a piece of, None for a whole recording; ``share`` : of that one's samples;
    ``begin`` : s, where it begins in that one. ``moments`` (m, n) as of the recording; None: all rows of each joint.
    """

    recording: Recording
    time: Array
    measured: Array
    counts: Mask
    held_out: bool
    relative: Array | None = None
    part_of: AngleTrial | None = None
    share: float = 1.0
    begin: float = 0.0
    moments: Mask | None = None

    @property
    def whole(self) -> AngleTrial:
        """The recording that it is a piece of, or itself."""
        return self.part_of or self

    @property
    def kind(self) -> object:
        """What was done to the leg: joints locked, tip, tilt, another leg; equal for trials of one kind."""
        return self.recording.conditions, id(self.recording.leg)

    @cached_property
    def free(self) -> list[int]:
        """Joints that are not locked."""
        return self.recording.free

    @cached_property
    def rate_prior(self) -> tuple[Array, Array]:
        """Mean and standard deviation of the initial rates of the free joints, rad/s."""
        mean, deviation = self.recording.initial_rate
        return mean[self.free], deviation[self.free]

    @cached_property
    def time_unit(self) -> float:
        """Time scale of the simulation, s, from the trial's own motion."""
        return time_unit(self.recording.smoothed.pace)

    @cached_property
    def counted(self) -> Array:
        """(n,) number of samples that count."""
        return np.asarray(self.counts.sum(axis=0), dtype=float)

    def piece(self, first: int, last: int) -> AngleTrial:
        """The samples from ``first`` to before ``last``, from an initial state of their own."""
        begin, part = float(self.time[first]), slice(first, last)
        relative = None if self.relative is None else self.relative[part]
        return replace(
            self,
            recording=self.recording.between(begin, float(self.time[last - 1])),
            time=self.time[part] - begin,
            measured=self.measured[part],
            counts=self.counts[part],
            relative=relative,
            moments=None if self.moments is None else self.moments[part],
            part_of=self,
            share=(last - first) / len(self.time),
            begin=begin,
        )

    def thinner(self, samples: int) -> AngleTrial:
        """The trial with about ``samples`` of the samples, evenly spaced."""
        own = np.ones_like(self.counts) if self.moments is None else self.moments
        kept = every_nth(own, samples, round)
        some = kept.any(axis=1)
        return replace(
            self,
            time=self.time[some],
            measured=self.measured[some],
            counts=(self.counts & kept)[some],
            relative=None if self.relative is None else self.relative[some],
            moments=kept[some],
        )


def trials_together(trials: Sequence[AngleTrial]) -> list[range]:
    """Indices of the trials that one call predicts: neighbours under the same conditions and the same drive, if any.

    At most ``MOST_SAMPLES_TOGETHER`` samples, unless one trial has more.
    """
    found: list[range] = []
    samples = 0
    for index, trial in enumerate(trials):
        samples += len(trial.time)
        if index and samples <= MOST_SAMPLES_TOGETHER and _same_equations(trials[index - 1], trial):
            found[-1] = range(found[-1].start, index + 1)
        else:
            found.append(range(index, index + 1))
            samples = len(trial.time)
    return found


def _same_equations(a: AngleTrial, b: AngleTrial) -> bool:
    """Whether two trials of one leg under the same conditions are not driven, or are pieces driven by one torque.

    They are simulated in the first one's unit of time, so their paces are alike too.
    """
    first, second = a.recording, b.recording
    if first.leg is not second.leg or first.conditions != second.conditions:
        return False
    if not 1.0 / MOST_PACE_RATIO <= a.time_unit / b.time_unit <= MOST_PACE_RATIO:
        return False
    if not (_is_driven(first) or _is_driven(second)):
        return True
    if a.part_of is None or a.part_of is not b.part_of:
        return False
    one, other = first.known_torque, second.known_torque
    return one is other if one is None or other is None else one[1] is other[1]


def _is_driven(recording: Recording) -> bool:
    return recording.known_torque is not None or recording.signals is not None


@dataclass(frozen=True)
class Whitener:
    """Converts predictions of trials into whitened residuals of the samples that count, one row per lane.

    ``index`` : indices of these samples in a flat (m n,) array of all trials; ``measured`` and ``scale`` (count,)
    theirs; ``each`` : where each trial's are among them.
    """

    index: NDArray[np.intp] | slice
    measured: Array
    scale: Array
    each: tuple[slice, ...]

    @classmethod
    def of(cls, trials: Sequence[AngleTrial], sigmas: Sequence[Array]) -> Whitener:
        """``sigmas`` (n,) or (m, n) rad of each trial."""
        counts = np.concatenate([trial.counts for trial in trials])
        index = slice(None) if counts.all() else np.flatnonzero(counts)
        measured = np.concatenate([trial.measured for trial in trials]).reshape(-1)[index]
        pairs = zip(trials, sigmas, strict=True)
        scale = np.concatenate([1.0 / np.broadcast_to(sigma, trial.measured.shape) for trial, sigma in pairs])
        ends = np.cumsum([0, *[trial.counts.sum() for trial in trials]]).tolist()
        each = tuple(slice(first, last) for first, last in pairwise(ends))
        return cls(index, measured, scale.reshape(-1)[index], each)

    @property
    def count(self) -> int:
        """Number of samples that count."""
        return len(self.measured)

    def lanes(self, prediction: Array) -> Array:
        """(n_lane, count) from predictions (m, n, n_lane) rad."""
        taken = prediction.reshape(-1, prediction.shape[2])[self.index].T
        found = np.empty(taken.shape)
        np.subtract(taken, self.measured, out=found)
        found *= self.scale
        return found


def angle_trial(recording: Recording, *, held_out: bool) -> AngleTrial:
    """Thin a recording to evenly spaced samples."""
    thin = recording.thinned(SAMPLES_A_TRIAL)
    return AngleTrial(recording, thin.time, thin.rotation, thin.counts, held_out, moments=thin.moments)


def first_of_kinds(trials: Sequence[AngleTrial], order: Sequence[int]) -> list[int]:
    """Index of the first trial of each kind in an ``order`` of indices, in that order."""
    kinds: dict[object, int] = {}
    for index in order:
        kinds.setdefault(trials[index].kind, index)
    return list(kinds.values())


def largest_of_kinds(trials: Sequence[AngleTrial]) -> list[int]:
    """Indices of all trials: one of each kind first, then the others, both from the largest motion to the least."""
    order = sorted(range(len(trials)), key=lambda i: -float(np.ptp(trials[i].measured, axis=0).max()))
    first = first_of_kinds(trials, order)
    return [*first, *[i for i in order if i not in set(first)]]


def spread_over_kinds(trials: Sequence[AngleTrial], most: int) -> tuple[list[AngleTrial], list[AngleTrial]]:
    """At most ``most`` of the trials, and the rest: one of each kind, then evenly over the others in their order."""
    if len(trials) <= most:
        return list(trials), []
    first = first_of_kinds(trials, range(len(trials)))[:most]
    others = [index for index in range(len(trials)) if index not in set(first)]
    even = np.arange(most - len(first)) * len(others) // max(most - len(first), 1)
    taken = {*first, *(others[place] for place in even)}
    return (
        [trial for index, trial in enumerate(trials) if index in taken],
        [trial for index, trial in enumerate(trials) if index not in taken],
    )
