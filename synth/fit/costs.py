"""The thesis' costs: the difference between a candidate's motion and the recordings, joint by joint.

``trajectory``: squared angle errors over all samples. ``transient``: the same, but samples after the first 0.2 s have a
tenth of the weight, since a leg is judged by its first swing. ``characteristics``: rise time, damping ratio by the
logarithmic decrement, and damped frequency, each as a difference from the recording's (relative, the ratio absolute);
one that only one of the two motions shows counts as 1. From E. Krnacik's thesis on damped biomimetic legs (Portland
State University, sections 2.2 and 4.1; its scripts in the public repository
Agile-and-Adaptive-Robotics/Published-Data): the knee there is judged by decrement and frequency, the hip by rise time,
the ankle by squared errors of the first 0.2 s.

``weight``: ``noise`` weighs each joint by its own residual (half the samples times the log of the mean
square, the likelihood with the noise eliminated); ``amplitude`` divides each trial's errors by the joint's amplitude
in it, and gives characteristics of large motions, which are less noisy, more weight; ``equal`` adds unweighted
squares.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from synth.arrays import Array
from synth.fit.recordings import Recording, relative_amplitudes
from synth.motion.characteristics import Characteristics, characteristics
from synth.motion.rest import last_tenth

TRANSIENT = 0.2  # s, in the recordings' unit of time: the first swing, as in the thesis
LATER_STRIDE = 10  # after that one sample of so many of each joint counts
DIVERGED = 1e12  # larger than the cost of any finite motion


def emphasise_transient(recordings: Sequence[Recording]) -> list[Recording]:
    """The recordings for the cost ``transient``: after the first 0.2 s only every tenth sample counts."""
    found = []
    for recording in recordings:
        own = recording.moments
        every = own & ((np.cumsum(own, axis=0) - 1) % LATER_STRIDE == 0)
        counted = recording.counts & (every | (recording.time <= TRANSIENT * recording.unit)[:, None])
        found.append(replace(recording, counts=counted, left_out=recording.known & ~counted))
    return found


@dataclass(frozen=True)
class Cost:
    """One of the costs over some recordings. ``name`` trajectory, transient or characteristics; ``weight`` see above.

    ``terms`` : the characteristics that count at each joint; None for all three.
    """

    name: str
    recordings: tuple[Recording, ...]
    weight: str = "noise"
    terms: tuple[tuple[str, ...], ...] | None = None

    @cached_property
    def counted_recordings(self) -> tuple[Recording, ...]:
        """The recordings with the samples that count."""
        return tuple(emphasise_transient(self.recordings)) if self.name == "transient" else self.recordings

    @cached_property
    def _relative(self) -> Array:
        n = self.recordings[0].rotation.shape[1]
        return (
            relative_amplitudes(self.recordings) if self.weight == "amplitude" else np.ones((len(self.recordings), n))
        )

    @cached_property
    def _recorded_characteristics(self) -> list[list[Characteristics | None]]:
        """The recordings' own characteristics, from the smoothed curves; None for a locked joint."""
        found: list[list[Characteristics | None]] = []
        for r in self.recordings:
            smoothed, n = r.smoothed, r.rotation.shape[1]
            found.append(
                [
                    _characteristics(smoothed.time, smoothed.angle[:, j], float(smoothed.noise[j]))
                    if j in r.free
                    else None
                    for j in range(n)
                ]
            )
        return found

    def of(self, motions: Sequence[Array]) -> Array:
        """(c, n) costs of candidates by joint, from their motions (m, n, c) rad per trial; large if one diverged."""
        found = self._characteristics(motions) if self.name == "characteristics" else self._squares(motions)
        return np.where(np.isfinite(found), found, DIVERGED)

    def _squares(self, motions: Sequence[Array]) -> Array:
        n, c = motions[0].shape[1:]
        total, count = np.zeros((n, c)), np.zeros(n)
        for recording, motion, relative in zip(self.counted_recordings, motions, self._relative, strict=True):
            error = (motion - recording.rotation[:, :, None]) / relative[:, None]
            total += (np.where(recording.counts[:, :, None], error, 0.0) ** 2).sum(axis=0)
            count += recording.counts.sum(axis=0)
        if self.weight == "equal":
            return total.T
        mean = total / np.maximum(count, 1.0)[:, None]
        return np.asarray(0.5 * count * np.log(mean + 1e-18).T) * (count > 0)

    def _characteristics(self, motions: Sequence[Array]) -> Array:
        n, c = motions[0].shape[1:]
        total = np.zeros((c, n))
        zipped = zip(self.recordings, motions, self._recorded_characteristics, self._relative, strict=True)
        for recording, motion, wanted, relative in zipped:
            for j in recording.free:
                known, noise = wanted[j], float(recording.smoothed.noise[j])
                assert known is not None
                terms = self.terms[j] if self.terms is not None else TERMS
                for k in range(c):
                    curve = motion[:, j, k]
                    if not np.all(np.isfinite(curve)):
                        total[k, j] = np.inf
                        continue
                    total[k, j] += relative[j] * summed_differences(
                        known, _characteristics(recording.time, curve, noise), terms
                    )
        return total


def _characteristics(time: Array, angle: Array, noise: float) -> Characteristics:
    """About the mean of the last tenth of recording and candidate alike: like is compared with like."""
    return characteristics(time, angle, noise, rest=last_tenth(angle))


TERMS = ("rise_time", "damping_ratio", "damped_frequency")


def summed_differences(wanted: Characteristics, found: Characteristics, terms: Sequence[str] = TERMS) -> float:
    """The sum of differences of some characteristics; 1 for one that only one of the two shows."""
    total = 0.0
    for term in terms:
        one, other = getattr(wanted, term), getattr(found, term)
        if one is None and other is None:
            continue
        if one is None or other is None:
            total += 1.0
        else:
            total += abs(other - one) if term == "damping_ratio" else abs(other - one) / one
    return total
