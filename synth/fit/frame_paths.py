"""Which frame is each sample? Lost frames as steps of a recording's time, from a fit's motion and its sensitivities.

A camera's file without time stamps has the number of its frames over the frame rate as time. Where frames were lost the
motion is ahead by whole frames from there on, at all joints alike. Given the fitted motion the most probable steps
are the cheapest path through the number of frames lost so far (dynamic programming: Viterbi, IEEE Trans. Inf. Theory 13
(1967) 260). A fit that takes steps for motion bends towards them, and hides them from that; so each single step is
weighed too with all unknowns of the fit estimated anew, to first order.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.fit.free_angle import WIDE
from synth.fit.least_squares import HUBER, Solution
from synth.fit.recordings import Recording
from synth.fit.trajectories import Evaluation, Local, TrajectoryModel

Frames = NDArray[np.intp]  # (m,) frames lost so far, at each sample

# Most frames lost in one recording, and at once: a camera that loses more shows it otherwise.
MOST_LOST, MOST_AT_ONCE = 60, 5
LOST_SHARE = 0.1  # of the samples, most frames lost in one recording
FIRST_ROW = 3  # of a step: before it a step and another initial state look alike
# In units of a log-likelihood, of each step beside the logarithm of the samples: where it is, and its size.
STEP_PRICE = 2.0
LEAST_INFORMATION = 1e-9  # of the largest of a trial's own unknowns, added so that what it does not tell is no pole


@dataclass(frozen=True)
class FrameStep:
    """``lost`` frames before sample ``row``; ``gain`` of it in a log-likelihood."""

    row: int
    lost: int
    gain: float = 0.0


def steps_of(path: Frames) -> list[FrameStep]:
    """The steps of a path (m,)."""
    rows = np.flatnonzero(np.diff(path)) + 1
    return [FrameStep(int(row), int(path[row] - path[row - 1])) for row in rows]


def price(recording: Recording) -> float:
    """The cost of one step, in units of a log-likelihood: the criterion of Schwarz, Ann. Stat. 6 (1978) 461."""
    return float(np.log(len(recording.time))) + STEP_PRICE


def timed(recording: Recording, path: Frames) -> Recording:
    """The recording of an even clock with the time of a path (m,)."""
    return replace(recording, time=np.asarray(recording.step * (np.arange(len(path)) + path), dtype=np.float64))


def most_lost(recording: Recording) -> int:
    """Frames that may have been lost in a recording."""
    return min(MOST_LOST, round(LOST_SHARE * len(recording.time)))


def best_path(model: TrajectoryModel, recording: Recording, values: Array, local: Local, scatter: Array) -> Frames:
    """(m,) the cheapest path, given the common unknowns (p,), the trial's own, and the samples' ``scatter`` (n,) rad.

    ``recording`` : with its even clock. No step where the motion diverges.
    """
    count, most = len(recording.time), most_lost(recording)
    longer = timed(recording, np.zeros(count + most, dtype=np.intp))
    motion = model.predictions(longer, values[:, None], local, local.shift[:, None])[:, :, 0]
    if not np.isfinite(motion).all():
        return np.zeros(count, dtype=np.intp)
    ahead = np.stack([motion[k : k + count] for k in range(most + 1)])
    off = np.where(recording.counts, np.abs(recording.rotation - ahead), 0.0) / scatter
    each = np.where(off < HUBER, 0.5 * off**2, HUBER * (off - 0.5 * HUBER)).sum(axis=2).T
    return _cheapest(np.ascontiguousarray(each), price(recording))


def _cheapest(each: Array, step: float) -> Frames:
    """(m,) the path of least cost: ``each`` (m, k) of a sample with k frames lost, and ``step`` of one that rises."""
    count, states = each.shape
    none = np.arange(states)
    came = np.zeros((count, states), dtype=np.intp)
    cost = np.full(states, np.inf)
    cost[0] = each[0, 0]
    for row in range(1, count):
        below = np.full(states, np.inf)
        source = none.copy()
        for rise in range(1, min(MOST_AT_ONCE, states - 1) + 1):
            better = cost[:-rise] < below[rise:]
            below[rise:][better] = cost[:-rise][better]
            source[rise:][better] = none[:-rise][better]
        risen = (below + step < cost) & (row >= FIRST_ROW)
        came[row] = np.where(risen, source, none)
        cost = np.where(risen, below + step, cost) + each[row]
    path, at = np.zeros(count, dtype=np.intp), int(np.argmin(cost))
    for row in range(count - 1, -1, -1):
        path[row] = at
        at = came[row, at]
    return path


@dataclass(frozen=True)
class _Columns:
    """Of one trial, over the samples' scatter: residuals and what a frame turns (m, n), sensitivities (m, n, p or l).

    ``cross`` (p, l) and ``own`` (l, l) of its normal equations.
    """

    off: Array
    frame: Array
    common: Array
    local: Array
    cross: Array
    own: Array

    @classmethod
    def of(cls, recording: Recording, found: Evaluation, scatter: Array) -> _Columns:
        """Of an evaluation with Jacobians at the time of ``recording``; free angles shift by some degrees."""
        assert found.common is not None
        assert found.local is not None
        weight = np.where(recording.counts, 1.0 / scatter, 0.0)
        frame = np.gradient(found.prediction, recording.time, axis=0) * recording.step * weight
        common, local = found.common * weight[:, :, None], found.local * weight[:, :, None]
        own = np.einsum("tjk,tjl->kl", local, local)
        precision = np.full(len(own), LEAST_INFORMATION * float(np.trace(own)) + 1e-12)
        precision[2 * len(recording.free) :] += WIDE**-2
        cross = np.einsum("tjp,tjl->pl", common, local)
        off = (found.prediction - recording.rotation) * weight
        return cls(off, frame, common, local, cross, own + np.diag(precision))

    @cached_property
    def share(self) -> Array:
        """(p, l) by which the trial's own unknowns follow the common ones."""
        return np.asarray(np.linalg.solve(self.own, self.cross.T).T, dtype=np.float64)

    @property
    def reduced(self) -> Array:
        """(p, p) information on the common unknowns, its own eliminated."""
        return np.asarray(np.einsum("tjp,tjq->pq", self.common, self.common) - self.share @ self.cross.T)

    def slope(self, off: Array) -> Array:
        """(p,) of the cost by the common unknowns with these residuals (m, n), its own eliminated."""
        own = np.einsum("tjl,tj->l", self.local, off)
        return np.asarray(np.einsum("tjp,tj->p", self.common, off) - self.share @ own)


class StepGains:
    """What single steps gain if all unknowns of a fit follow them, to first order.

    ``recordings`` : with the time of ``solution``, near its optimum; ``scatter`` (n,) rad.
    """

    def __init__(
        self, model: TrajectoryModel, recordings: Sequence[Recording], solution: Solution, scatter: Array
    ) -> None:
        found = model.evaluate_all(recordings, solution.values, solution.locals)
        self._trials = [_Columns.of(r, one, scatter) for r, one in zip(recordings, found, strict=True)]
        whole = np.diag(model.unknowns.prior[1]) + np.sum([each.reduced for each in self._trials], axis=0)
        self._inverse = np.linalg.pinv(whole, hermitian=True)
        self._slope = np.sum([each.slope(each.off) for each in self._trials], axis=0)

    def best(self, trial: int) -> FrameStep | None:
        """The step of a trial that gains most; None for none that gains."""
        return _largest(*self._gains(trial, None))

    def instead(self, trial: int, step: FrameStep) -> FrameStep | None:
        """A step that gains more in the place of one that the trial's time has, by how much; None for none."""
        gain, lost = self._gains(trial, step)
        found = _largest(gain - gain[step.row], lost)
        return found if found is not None and found.row != step.row else None

    def _gains(self, trial: int, without: FrameStep | None) -> tuple[Array, Array]:
        """(m,) of a step before each sample, and its frames (m,); ``without`` one that the time has."""
        at, slope = self._trials[trial], self._slope
        off = at.off
        if without is not None:
            back = np.where(np.arange(len(off)) >= without.row, -without.lost, 0)[:, None] * at.frame
            off, slope = off + back, slope + at.slope(back)
        square = _later(at.frame**2)
        with_common, with_own = (_later(at.frame[:, :, None] * each) for each in (at.common, at.local))
        inner = np.linalg.solve(at.own, with_own.T).T
        rest = with_common - inner @ at.cross.T
        pull = _later(off * at.frame) - inner @ np.einsum("tjl,tj->l", at.local, off) - rest @ self._inverse @ slope
        left = square - np.sum(with_own * inner, axis=1) - np.einsum("tp,pq,tq->t", rest, self._inverse, rest)
        lost = np.clip(np.round(-pull / np.maximum(left, 1e-12)), 1, MOST_AT_ONCE)
        gain = -lost * pull - 0.5 * lost**2 * left
        gain[:FIRST_ROW] = -np.inf
        return gain, lost


def _later(terms: Array) -> Array:
    """(m, ...) sums from each sample to the end, of all joints: of terms (m, n, ...)."""
    return np.asarray(np.cumsum(terms.sum(axis=1)[::-1], axis=0)[::-1])


def _largest(gain: Array, lost: Array) -> FrameStep | None:
    row = int(np.argmax(gain))
    return FrameStep(row, int(lost[row]), float(gain[row])) if gain[row] > 0.0 else None
