"""A speed that is told late: that of an encoder counted over a window, or of a driver's low-pass.

A window of 10 ms tells the speed of 5 ms before. Beside a current and a voltage of now the rotor seems heavier and the
winding of more resistance: a run-up's time constant of 17 ms gave a resistance 8 % too large, with a 90 % interval of
3 %. The lag is one more unknown, common to all runs, found as the others by least squares of the simulated response.
It shows in recordings that begin before the switch-on: between the current's rise and the speed's. Without that rest
the state at the first sample is free, and a lag is the same as a larger inductance and a heavier rotor.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array
from synth.estimation.correlation import correlation_factors_by_step
from synth.hopper.fit_motor_response import LEAST_NOISE, ResponseFit, ResponsePoint, ResponseRun, fit_response

# Gain of the log-likelihood from which a lag is believed: by chance one more number gains so much once in 130 000 fits.
LEAST_GAIN = 10.0
LONGEST_SHARE = 0.1  # of the shortest run: a speed told later than that is of another run-up's part


@dataclass(frozen=True)
class SpeedLag:
    """``seconds`` by which the speed is told late; 0: it is not, or the runs do not show it."""

    seconds: float = 0.0

    @property
    def sentence(self) -> str:
        """What is done about it, for the user; empty where nothing is."""
        if self.seconds == 0.0:
            return ""
        return (
            f"the speed is told {1e3 * self.seconds:.3g} ms late, as one counted over a window of twice that, or "
            "behind a filter, is: it is compared as of that much before. Where this is not short beside a run-up, "
            "constants are off by some per cent all the same: count over a shorter window"
        )

    def undone(self, run: ResponseRun) -> ResponseRun:
        """The run with each speed at its own time, without the last samples, of which none is told."""
        if self.seconds == 0.0:
            return run
        time, (current, speed) = run.time, run.measured.T
        kept = time + self.seconds <= time[-1] + 1e-9
        moved = np.interp(time[kept] + self.seconds, time, speed)
        measured = np.column_stack([current[kept], moved])
        return replace(run, time=time[kept], voltage=run.voltage[kept], measured=measured)


@dataclass(frozen=True, eq=False)
class FittedLag:
    """A fit of the response with a speed so late; ``misfit``: of a sample, less its log-likelihood."""

    lag: SpeedLag
    fit: ResponseFit
    best: ResponsePoint
    misfit: float
    counted: float  # samples of both columns, those that are correlated as fewer


def fit_with_lag(runs: Sequence[ResponseRun], near: Array) -> FittedLag:
    """The fit of the runs' response from constants ``near`` (6,) SI, with the speed's lag if they show one."""
    step = min(float(np.median(np.diff(run.time))) for run in runs)
    most = int(LONGEST_SHARE * min(float(np.ptp(run.time)) for run in runs) / step)
    tried: dict[int, FittedLag] = {}

    def misfit(samples: int) -> float:
        if samples not in tried:
            tried[samples] = _fitted(runs, near, SpeedLag(samples * step))
        return tried[samples].misfit

    misfit(0)
    if all(run.after_rest is None for run in runs):
        return tried[0]
    found = _least(misfit, most)
    if tried[found].counted * (tried[0].misfit - tried[found].misfit) < LEAST_GAIN:
        return tried[0]
    before, here, after = (misfit(found + side) for side in (-1, 0, 1))
    off = float(np.clip(0.5 * (before - after) / max(before - 2.0 * here + after, 1e-300), -0.5, 0.5))
    return _fitted(runs, near, SpeedLag((found + off) * step))


def _least(misfit: Callable[[int], float], most: int) -> int:
    """The number of samples, 0 to ``most``, of the least misfit, which falls up to it and rises beyond."""
    low, best, high = 0, 0, 1
    while high <= most and misfit(high) < misfit(best):
        low, best, high = best, high, 2 * high
    high = min(high, most)
    while high - low > 2:
        between = (low + best) // 2 if best - low >= high - best else (best + high) // 2
        if misfit(between) < misfit(best):
            low, best, high = (low, between, best) if between < best else (best, between, high)
        else:
            low, high = (between, high) if between < best else (low, between)
    return best


def _fitted(runs: Sequence[ResponseRun], near: Array, lag: SpeedLag) -> FittedLag:
    responses = [lag.undone(run) for run in runs]
    fit, best = fit_response(responses, near)
    left = fit.residuals(best)
    noise = np.sqrt(np.mean(np.concatenate(left) ** 2, axis=0))
    whole = np.sqrt(np.mean(np.concatenate([part.measured for part in responses]) ** 2, axis=0))
    misfit = float(np.sum(np.log(np.maximum(noise, LEAST_NOISE * np.maximum(whole, 1e-300)))))
    steps = [float(np.median(np.diff(part.time))) for part in responses]
    counted = sum(map(len, left)) / float(np.max(correlation_factors_by_step(left, steps)))
    return FittedLag(lag, fit, best, misfit if np.isfinite(best.cost) else np.inf, counted)
