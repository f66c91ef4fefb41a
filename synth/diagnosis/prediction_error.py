"""Prediction errors summed in blocks: RMS errors with intervals, and the shrink, for swings and jumps."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array, Mask
from synth.diagnosis.hypotheses import Key
from synth.estimation.intervals import NORMAL90, Estimate, student, student95

NOMINAL_LABELS = ("as_designed", "before")  # labels of the nominal leg, of which no cause is known
BLOCKS_A_TRIAL = 4  # blocks of time per trial
RESAMPLES = 500  # a 5 % quantile then rests on 25 of them
LEAST_GAP = 0.05  # of the squared noise floor; a smaller gap has no meaningful share
NO_BETTER_RATIO = 1.1  # ratio of the squared errors with and without the explanation: 5 % worse in RMS
AT_NOISE = 1.25  # RMS over the noise floor up to which no effect is missing: ``clean`` of the ``Calibration``
SHRINK_IF_DOUBLED = -1.0  # shrink of an error that doubles: how much worse an explanation might be tells nothing
# A part with less than a hundredth of the parts' mean gap, and less than three noise floors (ten squared ones), tells
# nothing of a shrink, as where a leg stands between steps (``tests/diagnosis/test_shrink.py``).
QUIET_SHARE, QUIET_FLOORS = 0.01, 10.0
# Of an RMS error in truth and as seen: that a mean square is over 20 times its expectation has a probability below 5 %,
# whatever its distribution (Markov's inequality).
LEAST_RATIO = 0.05**0.5
ROUNDING_SHARE = 1e-9  # of the squared errors: beyond rounding, and no prediction's error
Picks = NDArray[np.int64]


@dataclass(frozen=True)
class PredictionErrors:
    """Of scored trials.

    ``squares`` : label -> (n_trial, BLOCKS_A_TRIAL) summed squared errors in rad^2, under "as_designed", "before",
    "after" and each single cause's ``label_of_causes``; ``counts`` (n_trial, BLOCKS_A_TRIAL) samples; ``noise``
    (n_trial, BLOCKS_A_TRIAL) sum expected from noise alone; ``noise_as_read`` the same about predictions with the
    direct causes applied, of all labels but the ``NOMINAL_LABELS``; None: as ``noise``. ``seed`` : of the resampling.
    """

    squares: Mapping[str, Array]
    counts: Array
    noise: Array
    seed: int
    noise_as_read: Array | None = None

    @property
    def explanations(self) -> tuple[str, ...]:
        """Labels of all hypotheses: none, the accepted causes, and the others."""
        return tuple(name for name in self.squares if name != "as_designed")

    def of_trials(self, which: NDArray[np.bool_]) -> PredictionErrors:
        """The errors of the trials ``which`` (n_trial,) alone."""
        read = self.noise_as_read
        return replace(
            self,
            squares={name: squares[which] for name, squares in self.squares.items()},
            counts=self.counts[which],
            noise=self.noise[which],
            noise_as_read=None if read is None else read[which],
        )

    def figure(self, label: str) -> Estimate:
        """RMS error in rad, shown in deg, with its 90 % interval over trials, or over the blocks of a single one.

        It contains the noise: its low end is not below that, or not below the quietest part that was seen. Nor below
        ``LEAST_RATIO`` of the figure: over two trials, of a Student's distribution of one degree, it was at the noise.
        """
        found = self._estimate(lambda pick: _rms(self.squares[label], self.counts, pick), "deg")
        squares, counts = (self._parts(cells) for cells in (self.squares[label], self.counts))
        least = min(float(self._floor(label, None)), float(np.sqrt(np.min(squares / np.maximum(counts, 1.0)))))
        assert found.low is not None
        low = max(found.low, min(least, found.value), LEAST_RATIO * found.value)
        return replace(found, low=low)

    def above_noise(self, label: str) -> Estimate:
        """RMS error above the noise, quadratically subtracted, in rad, shown in deg."""

        def figure(pick: Picks | None) -> Array:
            above = _rms(self.squares[label], self.counts, pick) ** 2 - self._floor(label, pick) ** 2
            return np.sqrt(np.maximum(above, 0.0))

        return self._estimate(figure, "deg")

    @property
    def best_possible(self) -> Estimate:
        """RMS of the best explanation, regardless of its probability."""
        return min((self.figure(name) for name in self.explanations), key=lambda estimate: estimate.value)

    @property
    def floor(self) -> Estimate:
        """RMS of the noise on the same samples, about the explanation."""
        return Estimate(float(self._floor("after", None)), "deg")

    def _floor(self, label: str, pick: Picks | None) -> Array:
        """RMS of the noise about the predictions of a label, see ``_rms``."""
        noise = self.noise if label in NOMINAL_LABELS or self.noise_as_read is None else self.noise_as_read
        return _rms(noise, self.counts, pick)

    def shrink(self, label: str = "after") -> Estimate:
        """1 - after/before of the RMS above the noise floor, subtracted quadratically; 0 without a gap.

        Also 0 for a gap at the noise of which the trials allow any share: 0 over 0, which came out as 1 as often.
        The interval is over the parts that hold some of the gap; one alone does not tell how they differ. Its low end
        is that of ``_most_left``.
        """
        telling = self._telling
        left = self._estimate(lambda pick: 1.0 - self._shrink(label, pick), "1", telling)
        assert left.low is not None
        assert left.high is not None
        value, high = 1.0 - left.value, 1.0 - left.low
        low = max(1.0 - max(left.value, self._most_left(label, telling, left.high)), SHRINK_IF_DOUBLED)
        if telling.sum() < 2:
            low, high = SHRINK_IF_DOUBLED, 1.0
        at_noise = _rms(self.squares["before"], self.counts, None) <= AT_NOISE * self._floor("before", None)
        if at_noise and low <= SHRINK_IF_DOUBLED and high >= 1.0:
            return Estimate(0.0, "1", low, high)
        return Estimate(value, "1", min(low, value), high)

    def chance_below(self, share: float, least: float) -> float:
        """Probability that the explanation shrinks the gap by less than ``share``.

        By Student's distribution of ``log(left / allowed)``, squared errors with the explanation over those at which
        the shrink is ``share``, with its jackknife deviation over whole trials as in ``_estimate`` (over blocks of time
        of a single one): blocks of one trial share its error, and counted as trials they would make the probability
        far too sure (``tests/diagnosis/test_shrink.py``).
        0 if the gap is less than ``least`` noise floors: too small to tell.
        """
        if _rms(self.squares["before"], self.counts, None) < least * self._floor("before", None):
            return 0.0
        read = self.noise if self.noise_as_read is None else self.noise_as_read
        left, allowed = self.squares["after"], read + (1.0 - share) ** 2 * (self.squares["before"] - self.noise)
        if len(left) > 1:
            left, allowed = left.sum(axis=1), allowed.sum(axis=1)
        return _chance_above(left.ravel(), allowed.ravel())

    def _shrink(self, label: str, pick: Picks | None) -> Array:
        floor = self._floor("before", pick) ** 2
        before = _rms(self.squares["before"], self.counts, pick) ** 2 - floor
        after = _rms(self.squares[label], self.counts, pick) ** 2 - self._floor(label, pick) ** 2
        some = before > LEAST_GAP * floor
        return np.where(some, 1.0 - np.sqrt(np.maximum(after, 0.0) / np.where(some, before, 1.0)), 0.0)

    def _most_left(self, label: str, telling: Mask, as_ratio: float) -> float:
        """95 % point of the share of the gap's RMS that a label leaves, over the ``telling`` parts; 0 without two.

        Errors before and after are paired: Student's distribution about the ratio of the sums of squares above the
        noise, with its jackknife deviation over the parts (Efron and Tibshirani, An introduction to the bootstrap,
        1993, chapter 11). Moved away as a ratio, what is next to nothing in one of two trials and ten times that in the
        other reached a doubled error. That end, ``as_ratio``, counts up to one deviation of the noise's own sum: so far
        what is left says as little as its logarithm.
        """
        number = int(telling.sum())
        if number < 2:
            return 0.0
        read = self.noise if label in NOMINAL_LABELS or self.noise_as_read is None else self.noise_as_read
        left = np.maximum(self._parts(self.squares[label] - read)[telling], 0.0)
        gap = np.maximum(self._parts(self.squares["before"] - self.noise)[telling], 0.0)
        if gap.sum() <= LEAST_GAP * self._parts(self.noise)[telling].sum():
            return 0.0 if gap.sum() <= 0.0 and left.sum() <= 0.0 else 1.0 - SHRINK_IF_DOUBLED
        without = (left.sum() - left) / np.maximum(gap.sum() - gap, ROUNDING_SHARE * gap.sum())
        spread = _jackknife_deviation(without)
        noise, counts = (self._parts(cells)[telling] for cells in (read, self.counts))
        of_noise = float(np.sqrt(np.sum(2.0 * noise**2 / np.maximum(counts, 1.0)))) / gap.sum()
        paired = left.sum() / gap.sum() + student95(number - 1) * spread
        return float(np.sqrt(max(paired, min(as_ratio**2, of_noise))))

    @property
    def _resampled(self) -> int:
        """Number of parts that are resampled: whole trials, or the blocks of a single one."""
        return len(self.counts) if len(self.counts) > 1 else self.counts.size

    def _parts(self, cells: Array) -> Array:
        """(n_part,) sums of the cells (n_trial, BLOCKS_A_TRIAL) of each part that is resampled."""
        return np.asarray(cells.reshape(self._resampled, -1).sum(axis=1))

    @property
    def _telling(self) -> Mask:
        """(n_part,) True for parts that tell how much a gap shrinks; all, if there is no gap."""
        gap, noise = self._parts(self.squares["before"] - self.noise), self._parts(self.noise)
        if gap.sum() <= 0.0:
            return np.ones(len(gap), dtype=bool)
        return np.asarray((gap >= QUIET_SHARE * gap.mean()) | (gap >= QUIET_FLOORS * noise))

    def _resamples(self, telling: Mask) -> Picks:
        """(RESAMPLES, n_cell) cells of each resample, fewer if some hold no part that is ``telling``."""
        number = self._resampled
        blocks = self.counts.size // number
        picked = np.random.default_rng(self.seed).integers(0, number, (RESAMPLES, number))
        picked = picked[telling[picked].any(axis=1)]
        rows = len(picked)
        return np.asarray((picked[:, :, None] * blocks + np.arange(blocks)).reshape(rows, -1))

    def _estimate(self, figure: Callable[[Picks | None], Array], unit: str, telling: Mask | None = None) -> Estimate:
        """A figure, at least 0, with its 90 % interval; of a ratio, only some parts may be ``telling``.

        Whole trials are resampled, because what a trial is off by in one stretch it is off by in the next: blocks are
        not independent, and intervals over them too narrow. A single trial has only its blocks: its interval is that of
        the same trial longer, not of another one. The percentiles of few parts are too near the value: a resample's
        variance is ``(n - 1) / n`` of the parts', and Student's distribution is wider than the normal. Ends are moved
        away by that, as ratios, since the figures are errors: ``tests/diagnosis/test_shrink.py``. Parts that tell
        nothing are no further ones of these few, and resamples of them alone are left out.
        """
        telling = np.ones(self._resampled, dtype=bool) if telling is None else telling
        ends = np.percentile(figure(self._resamples(telling)), [5.0, 95.0])  # 90 % interval
        value = float(figure(None))
        number = int(telling.sum())
        if number > 1:
            wider = np.sqrt(number / (number - 1.0)) * student95(number - 1) / NORMAL90
            ends = value * (ends / value) ** wider if value > 0.0 else wider * ends
        return Estimate(value, unit, min(float(ends[0]), value), max(float(ends[1]), value))


def _rms(squares: Array, counts: Array, pick: Picks | None) -> Array:
    """RMS of the cells, or (n_resample,) of each row of picked cells (n_resample, n_cell)."""
    total, number = squares.ravel(), counts.ravel()
    if pick is not None:
        total, number = total[pick], number[pick]
    return np.asarray(np.sqrt(total.sum(axis=-1) / np.maximum(number.sum(axis=-1), 1.0)))


def _jackknife_deviation(without: Array) -> float:
    """Standard deviation of an estimate from those (n,) without each part (Efron 1982, chapter 3)."""
    return float(np.sqrt(len(without) - 1.0) * np.std(without))


def _chance_above(left: Array, allowed: Array) -> float:
    """Probability that the sum of errors (n,) is above an allowed one, see ``PredictionErrors.chance_below``."""
    count = len(left)
    sums = np.array([np.append(each.sum(), each.sum() - each) for each in (left, allowed)])  # all, and without each
    whole, *without = np.subtract(*np.log(np.maximum(sums, ROUNDING_SHARE * sums[1, 0])))
    spread = _jackknife_deviation(np.array(without))
    if spread <= ROUNDING_SHARE:  # all alike, or only one
        return float(whole > 0.0)
    return student(float(whole) / spread, count - 1)


def label_of_causes(keys: Sequence[Key]) -> str:
    """One text for a set of causes."""
    return " + ".join(sorted(f"{effect} @ {joint}" for effect, joint in keys))


def shrink_of_best(before: float, after: float, best: float, floor: float) -> float | None:
    """The shrink as a share of the best possible with the library's effects; None if these achieve nothing.

    All RMS errors in one unit; the noise floor is subtracted quadratically.
    """
    above = [float(np.sqrt(max(rms**2 - floor**2, 0.0))) for rms in (before, after, best)]
    return (above[0] - above[1]) / (above[0] - above[2]) if above[0] > above[2] else None
