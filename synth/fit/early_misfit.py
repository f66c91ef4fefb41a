"""Do the first samples lie off a fit by more than the later ones scatter about their own fit?

The predictive test of a change in a regression (Chow, Econometrica 28 (1960) 591), on means over blocks: a torque
that the leg does not produce shifts neighbouring samples alike, the sensor's noise does not, so that in the sum of
squares fewer independent terms hold the same shift. Parameters that are not known exactly shift the blocks of all
recordings together: their covariance is added to that of the noise.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array, Mask
from synth.estimation.f_distribution import square_above
from synth.fit.later_samples import ResidualFreedom
from synth.fit.recordings import Recording
from synth.fit.uncertainty import clipped_rms, correlation_times, sample_scatter

BLOCK = 0.025  # s, in the recordings' unit of time: a sixth of a hand's usual duration
# Mean square of the blocks, in units of that expected, up to which any probability counts as agreement: many samples
# make a small error of the links' linearised effect improbable too, while a hand's torque moves the leg by several
# deviations. Between the two it is a choice; ``make laws`` fits legs with a hand and free ones.
AGREEING_SQUARE = 2.5
# times the samples' scatter: if later samples lie farther off their own fit, the leg has another law
EXPLAINED_SCATTER = 2.0

# samples, whose median shows what a torque makes: a wrong reading and its like beside it do not move it
MEDIAN_SAMPLES = 5
WRONG_READING = 6.0  # deviations from it of a wrong reading, as in ``clipped_rms``


@dataclass(frozen=True)
class LaterScatter:
    """``deviation`` (n_recording, n) rad of the later samples about their own fit, enlarged where they are correlated.

    ``explained`` : whether that fit comes near the samples' own scatter, so that the law holds there. ``freedom`` :
    degrees of a joint's residuals in that fit, from which its deviation is estimated, the fewest of all joints.
    """

    deviation: Array
    explained: bool
    freedom: float = np.inf

    @classmethod
    def of(
        cls, recordings: Sequence[Recording], predictions: Sequence[Array], left: ResidualFreedom | None = None
    ) -> LaterScatter:
        """From the later samples and their fit (m, n) rad a recording; ``left`` to its residuals, None: very many."""
        rms = clipped_rms(recordings, predictions)
        explained = bool(np.all((rms < EXPLAINED_SCATTER * sample_scatter(recordings)) | np.isnan(rms)))
        deviation = rms * np.sqrt(correlation_times(recordings, predictions))
        if left is None:
            return cls(deviation, explained)
        return cls(deviation * np.sqrt(left.enlarged), explained, left.fewest)

    def agreement(
        self,
        recordings: Sequence[Recording],
        predictions: Sequence[Array],
        until: float,
        errors: Sequence[Array] = (),
    ) -> float:
        """The probability that samples before ``until`` s lie so far off ``predictions``; 1 if that is not far.

        ``errors`` : (k, n, c) rad a recording, change of these samples' predictions per standard deviation of each
        parameter that is not known exactly: links of the leg file, whose errors all recordings share.
        """
        if not self.explained:
            return 1.0
        errors = errors or [np.zeros((int(np.sum(r.time < until)), r.rotation.shape[1], 0)) for r in recordings]
        blocks = [
            block
            for t, (recording, prediction, error) in enumerate(zip(recordings, predictions, errors, strict=True))
            for block in _blocks(recording, prediction, until, error, self.deviation[t])
        ]
        off, shared = np.concatenate([block[:, 0] for block in blocks]), np.vstack([block[:, 1:] for block in blocks])
        # The square in units of unit noise and shared errors together, by the matrix inversion lemma.
        pulled = shared.T @ off
        explained = pulled @ np.linalg.solve(np.eye(len(pulled)) + shared.T @ shared, pulled)
        total, count = float(off @ off - explained), len(off)
        return square_above(count, total, self.freedom) if total > AGREEING_SQUARE * count else 1.0


def _blocks(recording: Recording, prediction: Array, until: float, error: Array, deviation: Array) -> Iterator[Array]:
    """(b, 1 + c) for each free joint: sums over blocks of misfit and errors, over the sum's own deviation.

    ``deviation`` : (n,) rad of a sample.
    """
    early = recording.time < until
    block = (recording.time[early] / (BLOCK * recording.unit)).astype(np.intp)
    for j in recording.free:
        misfit = prediction[early, j] - recording.rotation[early, j]
        good = recording.counts[early, j] & ~_contradicted_samples(misfit, recording.counts[early, j], deviation[j])
        columns = np.column_stack([misfit, error[:, j]])[good]
        size = np.bincount(block[good])
        filled = size > 0
        sums = np.column_stack([np.bincount(block[good], weights=column) for column in columns.T])
        yield sums[filled] / (deviation[j] * np.sqrt(size[filled]))[:, None]


def _contradicted_samples(misfit: Array, counts: Mask, deviation: float) -> Mask:
    """(m,) samples that their neighbours contradict: readings that are wrong, which no torque makes."""
    found, at = np.zeros(len(misfit), dtype=bool), np.flatnonzero(counts)
    if len(at) >= MEDIAN_SAMPLES:
        windows = np.lib.stride_tricks.sliding_window_view(
            np.pad(misfit[at], MEDIAN_SAMPLES // 2, mode="reflect"), MEDIAN_SAMPLES
        )
        found[at] = np.abs(misfit[at] - np.median(windows, axis=1)) > WRONG_READING * deviation
    return found
