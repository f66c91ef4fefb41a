"""How far: RMS errors on scored trials as designed, before and after, with intervals, and the shrink."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from synth.fit.result import Estimate
from synth.gap.counts import Coarse, rounded
from synth.gap.data import GapTrial
from synth.gap.result import TrialGap
from synth.gap.score import score
from synth.gap.search import Assessed, Search
from synth.gap.solve import Fit, Normal, Workbench
from synth.gap.where import Missing, phases
from synth.model.leg import Array, Leg

BLOCKS = 4  # a trial's errors are resampled in so many pieces of time
RESAMPLES = 500
Key = tuple[str, str]
Picks = NDArray[np.int64]


@dataclass(frozen=True)
class Gap:
    """Predictions (m, n) rad of each scored trial, and what they miss.

    ``squares``: label -> (n_trial, BLOCKS) summed squared misses in rad^2; ``counts`` (n_trial, BLOCKS) samples;
    ``noise`` (n_trial, BLOCKS) what the noise alone would sum to.
    """

    trials: tuple[GapTrial, ...]
    as_designed: tuple[Array, ...]
    before: tuple[Array, ...]
    after: tuple[Array, ...]
    squares: Mapping[str, Array]
    counts: Array
    noise: Array
    seed: int

    @property
    def explanations(self) -> tuple[str, ...]:
        """Labels of all that was tried: nothing, the accepted causes, and the others."""
        return tuple(name for name in self.squares if name != "as_designed")

    def figure(self, label: str) -> Estimate:
        """RMS miss in deg with its 90 % interval over trials and pieces of time."""
        return self._estimate(lambda pick: _rms(self.squares[label], self.counts, pick), "deg")

    @property
    def floor(self) -> Estimate:
        """RMS of the noise on the same samples."""
        return Estimate(_rms(self.noise, self.counts, None), "deg")

    def shrink(self, label: str = "after") -> Estimate:
        """1 - after/before of the RMS above the noise floor, quadratically subtracted; 0 where there is no gap."""
        return self._estimate(lambda pick: self._shrink(label, pick), "1")

    def _shrink(self, label: str, pick: Picks | None) -> float:
        floor = _rms(self.noise, self.counts, pick) ** 2
        before = _rms(self.squares["before"], self.counts, pick) ** 2 - floor
        after = _rms(self.squares[label], self.counts, pick) ** 2 - floor
        if before <= 0.05 * floor:
            return 0.0
        return float(1.0 - np.sqrt(max(after, 0.0) / before))

    def _estimate(self, figure: Callable[[Picks | None], float], unit: str) -> Estimate:
        generator = np.random.default_rng(self.seed)
        cells = self.counts.size
        picks = generator.integers(0, cells, (RESAMPLES, cells))
        drawn = np.array([figure(pick) for pick in picks])
        low, high = np.percentile(drawn, [5.0, 95.0])
        value = figure(None)
        return Estimate(value, unit, min(float(low), value), max(float(high), value))


def _rms(squares: Array, counts: Array, pick: Picks | None) -> float:
    total, number = squares.ravel(), counts.ravel()
    if pick is not None:
        total, number = total[pick], number[pick]
    return float(np.sqrt(total.sum() / max(number.sum(), 1.0)))


def predictions(bench: Workbench, found: Assessed, trials: Sequence[GapTrial], held_out: bool) -> tuple[Array, ...]:
    """(m, n) rad a trial: of trials that took no part, or else of each trial by a fit without it."""
    if held_out or len(trials) == 1:
        return score(bench, found.fit, trials).predictions
    frame = found.fit.frame or bench.frame(found.fit)
    normal = Normal.of(bench, found.fit, frame)
    low, high = bench.bounds(found.fit.hypothesis)
    made = []
    for index, trial in enumerate(trials):
        moved = np.clip(found.fit.unknowns + normal.without(index), low, high)
        made.append(score(bench, replace(found.fit, unknowns=moved), [trial]).predictions[0])
    return tuple(made)


def measure(
    bench: Workbench,
    trials: Sequence[GapTrial],
    found: Search,
    accepted: Assessed,
    others: Sequence[Assessed],
    coarse: Sequence[Coarse],
    usual: Array,
    held_out: bool,
    seed: int,
) -> Gap:
    """Predict the scored trials as designed, before, after, and with each of the ``others``.

    ``usual`` (n,) rad: each channel's noise without coarse counts. Squares of the others stand under their keys joined
    by " + ".
    """
    leg = bench.predictor.leg
    designed = Fit((), np.zeros(bench.n_tolerance), ())
    as_designed = score(bench, designed, trials).predictions
    before = predictions(bench, found.none, trials, held_out)

    def told(predicted: Sequence[Array]) -> tuple[Array, ...]:
        return tuple(rounded(leg, trial, p, coarse) for trial, p in zip(trials, predicted, strict=True))

    after = told(before if accepted is found.none else predictions(bench, accepted, trials, held_out))
    squares = {
        "as_designed": _squares(trials, as_designed),
        "before": _squares(trials, before),
        "after": _squares(trials, after),
    }
    for other in others:
        alone = after if other is accepted else told(predictions(bench, other, trials, held_out))
        squares[label(other.keys)] = _squares(trials, alone)
    counts = _squares(trials, [np.ones_like(t.measured) + t.measured for t in trials])
    noise = _squares(trials, [t.measured + usual for t in trials])
    return Gap(tuple(trials), as_designed, before, after, squares, counts, noise, seed)


def label(keys: Sequence[Key]) -> str:
    """One text for a set of causes."""
    return " + ".join(sorted(f"{effect} @ {joint}" for effect, joint in keys))


def _squares(trials: Sequence[GapTrial], predicted: Sequence[Array]) -> Array:
    """(n_trial, BLOCKS) summed squared misses."""
    found = np.zeros((len(trials), BLOCKS))
    for i, (trial, prediction) in enumerate(zip(trials, predicted, strict=True)):
        away = np.where(np.isfinite(prediction), prediction - trial.measured, np.pi)
        square = np.where(trial.counts, away**2, 0.0).sum(axis=1)
        found[i] = [part.sum() for part in np.array_split(square, BLOCKS)]
    return found


def trial_gaps(
    nominal: Leg, gap: Gap, missing: Sequence[Missing], held_out: bool, noise: Array
) -> tuple[TrialGap, ...]:
    """Scored trials in measured angles, for the report and the files."""
    made = []
    rest = np.array([j.sign * (j.spring.free_angle - j.zero) if j.spring else 0.0 for j in nominal.joints])
    for index, trial in enumerate(gap.trials):
        smoothed, found = trial.recording.smoothed, missing[index]
        nearest = np.clip(np.searchsorted(smoothed.time, trial.time), 0, len(smoothed.time) - 1)
        torque = np.full((len(trial.time), len(rest)), np.nan)
        inside = (trial.time >= found.time[0]) & (trial.time <= found.time[-1]) if len(found.time) else None
        for j in range(len(rest)):
            if inside is not None:
                torque[inside, j] = nominal.sign[j] * np.interp(trial.time[inside], found.time, found.torque[:, j])
        measured = np.where(trial.counts, nominal.to_measured(trial.measured), np.nan)
        made.append(
            TrialGap(
                name=trial.recording.name,
                time=trial.time,
                measured=measured,
                as_designed=nominal.to_measured(gap.as_designed[index]),
                before=nominal.to_measured(gap.before[index]),
                after=nominal.to_measured(gap.after[index]),
                missing_torque=torque,
                speed=nominal.sign * smoothed.rate[nearest],
                deflection=nominal.sign * (smoothed.angle[nearest] - rest),
                phase=phases(trial, noise),
                held_out=held_out,
                scored=True,
            )
        )
    return tuple(made)
