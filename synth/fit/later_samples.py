"""Recordings without their first samples, and how much what remains tells of its noise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.fit.recordings import Recording

# In the recordings' unit of time, 1 s for limbs: s after the start of the comparison fit; external torques usually end
# within 0.2 s.
COMPARISON_START = 0.3
LEAST_SHARE = 0.4  # of the shortest recording, that must remain
LEAST_CUT = 9  # samples that a cut leaves: the weak form's windows, from which the fit starts, have so many
LEAST_COMPARED = 7  # samples of a joint for a comparison: smoothing needs so many
# Degrees of freedom of a joint's residuals, from which its noise is estimated. With three a torque must move the
# samples some ten times as far as beside a known noise to be told from it, with two fifty times.
LEAST_FREEDOM = 3
# The same, below which a torque must move the samples twice as far as beside a known noise.
ENOUGH_FREEDOM = 9.0
OWN_UNKNOWNS, RATES = 2, 2  # of a joint: in each recording its initial angle and rate; spring and damper rate


@dataclass(frozen=True)
class ResidualFreedom:
    """``samples`` (n,) of each joint that are fitted, and ``unknowns`` (n,) that were fitted to them.

    The degrees are those of independent residuals. Of noise that lasts there are fewer, see ``lasting_noise``.
    """

    samples: Array
    unknowns: Array

    @classmethod
    def of(cls, recordings: Sequence[Recording], spread: Array) -> ResidualFreedom:
        """Of a fit of springs and dampers to ``recordings``; ``spread`` (n,) rad of free angles, 0: a common one."""
        seen = np.array([recording.counts.sum(axis=0) for recording in recordings])
        trials = (seen > 0).sum(axis=0)
        unknowns = OWN_UNKNOWNS * trials + RATES + np.where(spread > 0.0, trials, 1)
        return cls(seen.sum(axis=0).astype(float), np.where(trials > 0, unknowns, 0).astype(float))

    @property
    def enlarged(self) -> Array:
        """(n,) the noise's variance over the mean square of the residuals; 1 for a joint without samples."""
        seen = self.samples > 0
        return np.where(seen, self.samples / np.where(seen, self.samples - self.unknowns, 1.0), 1.0)

    @property
    def fewest(self) -> float:
        """Degrees of the joint whose residuals have the fewest: each joint's noise is estimated from its own."""
        return float(np.min((self.samples - self.unknowns)[self.samples > 0], initial=np.inf))

    @property
    def enough(self) -> bool:
        """Whether every joint's residuals show its noise."""
        return self.fewest >= LEAST_FREEDOM


def recordings_from(recordings: Sequence[Recording], start: float, least: int = LEAST_CUT) -> list[Recording] | None:
    """The recordings from ``start`` s after their first sample; None if too little of one would remain.

    ``least`` : samples of each joint that moves.
    """
    cut = []
    for recording in recordings:
        first = int(np.searchsorted(recording.time, start))
        left = recording.time[-1] - start
        fewest = recording.known[first:, recording.free].sum(axis=0).min(initial=len(recording.time))
        # 1e-9: the comparison fit starts where just this share is left.
        if fewest < least or left < (LEAST_SHARE - 1e-9) * recording.time[-1]:
            return None
        cut.append(recording.later(first))
    return cut


def comparison_begin(recordings: Sequence[Recording]) -> float:
    """The start of the comparison fit, s after each recording's first sample."""
    shortest = min(float(recording.time[-1]) for recording in recordings)
    return min(COMPARISON_START * recordings[0].unit, shortest * (1.0 - LEAST_SHARE))


def untold_start(recordings: Sequence[Recording], spread: Array) -> list[str]:
    """A sentence where later samples are too few to show a torque at first, ``spread`` as in ``ResidualFreedom.of``."""
    begin = comparison_begin(recordings)
    later = recordings_from(recordings, begin, LEAST_COMPARED)
    if later is not None:
        left = ResidualFreedom.of(later, spread)
        if left.fewest >= ENOUGH_FREEDOM:
            return []
    count = min(int(np.sum(recording.time >= begin)) for recording in recordings)
    return [
        "release: these recordings cannot tell a torque of a hand or a muscle at first from springs and dampers: of "
        f"the shortest, {count} samples are left after {1e3 * begin:.3g} ms. The rates and intervals hold if the limb "
        "moves freely from each first sample. More samples a second, or longer recordings, would tell"
    ]
