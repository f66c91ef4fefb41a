"""The response of each cause in these trials, minus the part that tolerances and initial states can reproduce.

All inner products use the metric of the remaining part: with whitened derivatives ``S`` by the tolerances
(prior: standard normal) and each trial's initial state projected out, ``<a, b> = a' (I + S S')^-1 b``. The norm
is the signal-to-remainder ratio of a cause; the angle between two responses says how similar two causes
are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array
from synth.diagnosis.check.level_sizes import (
    Level,
    distinct_starts,
    is_level,
    level_rungs,
    rungs_from_designed,
    strength_places,
    with_point,
)
from synth.diagnosis.effect_shape import ShapedEffect, has_size
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.hypotheses import Key
from synth.diagnosis.screening import DIVERGED_RESIDUAL, ScreeningFrame
from synth.diagnosis.workbench import Workbench

# A cause is visible if its gain in log-likelihood, half the squared signal, exceeds the penalty of one unknown in the
# odds (4, see ``verdict.Calibration``): 2.8, rounded up.
VISIBLE_SIGNAL = 3.0
# Signal, before subtracting the tolerances' part, at which causes are compared: small, so that the tolerances' part is
# subtracted to second order too. The integrator must then be finer than for finding sizes only.
COMPARED_SIGNAL, COMPARISON_TOLERANCE = 3.0, 1e-7
# Further steps: the signal of a single link 9 % too heavy is 17, then 2.9, then 2.8, where it stays. They are taken
# from a signal on that is near a visible one, where the tolerances take more than half of the response.
RELINEARISED, LEAST_RELINEARISED, TAKEN_RATIO = 2, 1.0, 2.0


@dataclass(frozen=True)
class ResponseProducts:
    """Sums over trials of products between ``k`` responses and derivatives by ``p`` tolerances, states projected out.

    ``own`` (k, k), ``across`` (p, k), ``tolerances`` (p, p).
    """

    own: Array
    across: Array
    tolerances: Array

    def __add__(self, other: ResponseProducts) -> ResponseProducts:
        """The responses with further trials."""
        return ResponseProducts(self.own + other.own, self.across + other.across, self.tolerances + other.tolerances)

    def of(self, columns: Sequence[int]) -> ResponseProducts:
        """Those of some responses and derivatives, in this order."""
        chosen = list(columns)
        return ResponseProducts(self.own[np.ix_(chosen, chosen)], self.across[:, chosen], self.tolerances)

    @property
    def gram(self) -> Array:
        """(k, k) inner products in the metric of the part that tolerances cannot reproduce."""
        inner = np.eye(len(self.tolerances)) + self.tolerances
        return np.asarray(self.own - self.across.T @ np.linalg.solve(inner, self.across))


@dataclass(frozen=True)
class CauseResponse:
    """One cause in one shape from one start: ``fit`` at the size of comparison, and its smallest visible size.

    ``visible`` (n_unknown,) whitened unknowns at the smallest visible size, or None; ``columns`` : indices of its
    response and of its derivatives among all; ``implausible`` : the smallest visible size where it is no plausible one,
    see ``is_plausible``; ``visible`` is None then. ``level`` : its ladder, if its strengths have no zero.
    """

    fit: EvaluatedHypothesis
    visible: Array | None
    columns: tuple[int, ...] = ()
    implausible: Array | None = None
    level: Level | None = None

    @property
    def key(self) -> Key:
        """Effect and place."""
        return self.fit.keys[0]

    @property
    def candidate(self) -> ShapedEffect:
        """The cause in its shape."""
        return self.fit.hypothesis[0]


def response_products(
    bench: Workbench, at: EvaluatedHypothesis, responses: Sequence[Sequence[Array]]
) -> ResponseProducts:
    """Responses (k, M), one list per trial, at a linearised fit; non-finite values count as diverged."""
    ground = ScreeningFrame.of(bench, at)
    count = len(responses[0])
    own, across = np.zeros((count, count)), np.zeros((len(ground.matrix), count))
    for i, rows in enumerate(responses):
        left = ground.left(i, rows)
        own += left @ left.T
        across += ground.slopes[i].T @ left.T
    return ResponseProducts(own, across, ground.matrix)


def responses_of(
    bench: Workbench, at: EvaluatedHypothesis, candidates: Sequence[ShapedEffect]
) -> tuple[list[CauseResponse], ResponseProducts]:
    """Every candidate from every start at a small size, and the products of responses and derivatives."""
    starts = [
        EvaluatedHypothesis((candidate,), np.concatenate([at.unknowns, start]), at.states)
        for candidate in candidates
        for start in distinct_starts(candidate)
    ]
    return responses_for_comparison(bench, at, with_columns_numbered(_responses_with_sizes(bench, at, starts)))


def with_columns_numbered(responses: Sequence[CauseResponse]) -> list[CauseResponse]:
    """The responses, their columns numbered in this order: of each itself, then its derivatives."""
    made, count = [], 0
    for response in responses:
        size = 1 + response.candidate.size
        made.append(replace(response, columns=tuple(range(count, count + size))))
        count += size
    return made


def responses_for_comparison(
    bench: Workbench, at: EvaluatedHypothesis, responses: Sequence[CauseResponse]
) -> tuple[list[CauseResponse], ResponseProducts]:
    """The responses evaluated at their size of comparison, in the order of their columns, and the products of these."""
    finer = replace(bench, predictor=bench.predictor.coarser(COMPARISON_TOLERANCE))
    base, *fits = finer.evaluate([at, *(response.fit for response in responses)])
    rows: list[list[Array]] = [[] for _ in bench.trials]
    for fit in fits:
        for i, (residual, columns) in enumerate(zip(fit.residuals, fit.columns, strict=True)):
            rows[i] += [residual - base.residuals[i], *columns.T]
    placed = [replace(response, fit=fit) for response, fit in zip(responses, fits, strict=True)]
    return placed, response_products(bench, at, rows)


def _responses_with_sizes(
    bench: Workbench, at: EvaluatedHypothesis, starts: Sequence[EvaluatedHypothesis]
) -> list[CauseResponse]:
    """For each start the size of comparison, and the smallest visible size, from a ladder of sizes."""
    first = bench.n_tolerance
    leveled = [is_level(start.hypothesis[0]) for start in starts]
    ladders = [
        level_rungs(start, first) if level else rungs_from_designed(start, first)
        for start, level in zip(starts, leveled, strict=True)
    ]
    signals, raw = _signals_of_ladders(bench, at, ladders)
    made = [
        None if level else _response_from_zero(start, ladder, here, bare, first)
        for start, level, ladder, here, bare in zip(starts, leveled, ladders, signals, raw, strict=True)
    ]
    levels = [k for k, level in enumerate(leveled) if level]
    found = _levels(bench, at, [ladders[k] for k in levels], [signals[k] for k in levels])
    for k, level in zip(levels, found, strict=True):
        made[k] = None if level is None else _response_of_level(starts[k], level, first)
    return [response for response in made if response is not None]


def _response_from_zero(
    start: EvaluatedHypothesis, ladder: Sequence[EvaluatedHypothesis], here: Array, bare: Array, first: int
) -> CauseResponse | None:
    """From the signals (n_rung,) of a ladder, after and before subtraction; None if it acts nowhere."""
    candidate, sizes = start.hypothesis[0], np.array([rung.unknowns[first:] for rung in ladder])
    acts = np.isfinite(here) & (bare > 0.0)
    if has_size(candidate):  # at no size, where a bound leads, only the integrator's own error is left of it
        acts &= np.any((sizes - candidate.absent)[:, strength_places(candidate)] != 0.0, axis=1)
    good = np.flatnonzero(acts)
    if not len(good):
        return None
    best = int(good[np.argmin(np.abs(np.log(bare[good] / COMPARED_SIGNAL)))])
    shown = _smallest_visible(start, sizes[good], here[good], first)
    size = candidate.strengthened(sizes[best], COMPARED_SIGNAL / bare[best]) if has_size(candidate) else sizes[best]
    plausible = shown is None or is_plausible(candidate, shown)
    seen, unlikely = (shown, None) if plausible else (None, shown)
    return CauseResponse(_at_point(start, size, first), seen, implausible=unlikely)


def _levels(
    bench: Workbench,
    at: EvaluatedHypothesis,
    ladders: Sequence[Sequence[EvaluatedHypothesis]],
    signals: Sequence[Array],
) -> list[Level | None]:
    """The ladders of causes without a zero, finer where the smallest visible size is."""
    first = bench.n_tolerance
    places = [strength_places(ladder[0].hypothesis[0])[0] for ladder in ladders]
    points = [np.array([rung.unknowns[first:] for rung in ladder]) for ladder in ladders]
    coarse = [Level.of(*each) for each in zip(points, signals, places, strict=True)]
    more = [[] if level is None else level.between(VISIBLE_SIGNAL) for level in coarse]
    fine = [[with_point(ladder[0], first, point) for point in each] for ladder, each in zip(ladders, more, strict=True)]
    later, _ = _signals_of_ladders(bench, at, fine)
    return [
        Level.of(np.vstack([points[k], *more[k]]), np.r_[signals[k], later[k]], place) for k, place in enumerate(places)
    ]


def _response_of_level(start: EvaluatedHypothesis, level: Level, first: int) -> CauseResponse | None:
    """Of a cause whose strengths have no zero; None if it acts nowhere.

    It is compared at its smallest visible size: its response at a smaller one is another, not a part of it.
    """
    if not np.any(level.signals > 0.0):
        return None
    shown = level.at_signal(VISIBLE_SIGNAL)
    plausible = shown is None or _can_be_as_strong(start.hypothesis[0], shown, level)
    seen, unlikely = (shown, None) if plausible else (None, shown)
    point = _at_point(start, level.rung_with_signal(VISIBLE_SIGNAL), first)
    return CauseResponse(point, seen, implausible=unlikely, level=level)


def _can_be_as_strong(candidate: ShapedEffect, unknowns: Array, level: Level) -> bool:
    """As ``is_plausible``: of a limit, all lower ones are visible too, and only a very low one is not plausible."""
    beyond = np.asarray(unknowns)[strength_places(candidate)] * (-1.0 if level.falls else 1.0)
    return bool(np.max(beyond) < VISIBLE_SIGNAL)


def _at_point(start: EvaluatedHypothesis, size: Array, first: int) -> EvaluatedHypothesis:
    point = np.clip(size, *start.hypothesis[0].bounds())
    return replace(start, unknowns=np.concatenate([start.unknowns[:first], point]))


def _signals_of_ladders(
    bench: Workbench, at: EvaluatedHypothesis, ladders: Sequence[Sequence[EvaluatedHypothesis]]
) -> tuple[list[Array], list[Array]]:
    """Signals (n_rung,) of each ladder, after and before subtracting the tolerances' part."""
    flat = [rung for ladder in ladders for rung in ladder]
    signals, raw = _signals(bench, at, flat) if flat else (np.zeros(0), np.zeros(0))
    ends = np.cumsum([len(ladder) for ladder in ladders])[:-1]
    return np.split(signals, ends), np.split(raw, ends)


def _signals(bench: Workbench, at: EvaluatedHypothesis, fits: Sequence[EvaluatedHypothesis]) -> tuple[Array, Array]:
    """Signal (n_fit,) of each after subtracting the tolerances' part, and before; nan if the motion diverged.

    The tolerances' part is linear. Of a response that they nearly make, such as that of a heavier link, what bends in
    it would stay and count as signal: there the subtraction is repeated about where tolerances and states have moved.
    """
    signals, raw, moved = _step_of_tolerances(bench, at, fits)
    current = np.arange(len(fits))
    for _ in range(RELINEARISED):
        again = (signals[current] > LEAST_RELINEARISED) & (raw[current] > TAKEN_RATIO * signals[current])
        current, chosen = current[again], [fit for fit, wanted in zip(moved, again, strict=True) if wanted]
        if not chosen:
            break
        later, _, moved = _step_of_tolerances(bench, at, chosen)
        signals[current] = np.fmin(signals[current], later)  # a step may lead too far
    return signals, raw


def _step_of_tolerances(
    bench: Workbench, at: EvaluatedHypothesis, fits: Sequence[EvaluatedHypothesis]
) -> tuple[Array, Array, list[EvaluatedHypothesis]]:
    """Signals (n_fit,) after and before one Gauss-Newton step of tolerances and states, and the fits after it.

    Half its square is what residuals and the tolerances' priors cost then, by the derivatives at ``at``.
    """
    ground, first = ScreeningFrame.of(bench, at), bench.n_tolerance
    assert at.frame is not None
    trials = at.frame.trials
    here = np.array([fit.unknowns[:first] - at.unknowns for fit in fits]).T
    squares, across = np.sum(here**2, axis=0), here.copy()
    broken, along = np.zeros(len(fits), dtype=bool), []
    for i, rows in enumerate(bench.residuals(fits)):
        found = np.array(rows)
        broken |= ~np.isfinite(found.sum(axis=1)) | (np.abs(found).max(axis=1) >= DIVERGED_RESIDUAL)
        found[broken] = 0.0
        found -= np.where(broken[:, None], 0.0, at.residuals[i])
        left = ground.project(i, found)
        squares += np.einsum("fm,fm->f", left, left)
        across += ground.slopes[i].T @ left.T
        along.append(trials[i].q.T @ found.T)
    step = -np.linalg.solve(np.eye(first) + ground.matrix, across)
    lessened = squares + np.sum(across * step, axis=0)
    low, high = (bound[:first, None] for bound in bench.bounds(()))
    step = np.clip(here + step, low, high) - here
    changes = [-np.linalg.solve(t.r, own + t.along @ step) for t, own in zip(trials, along, strict=True)]
    moved = [
        replace(
            fit,
            unknowns=np.concatenate([fit.unknowns[:first] + step[:, f], fit.unknowns[first:]]),
            states=bench.moved_states(fit, [change[:, f] for change in changes]),
        )
        for f, fit in enumerate(fits)
    ]
    signals = np.where(broken, np.nan, np.sqrt(np.maximum(lessened, 0.0)))
    return signals, np.where(broken, np.nan, np.sqrt(squares)), moved


def _smallest_visible(start: EvaluatedHypothesis, sizes: Array, signals: Array, first: int) -> Array | None:
    """Whitened unknowns at the smallest visible size, interpolated between the ladder's rungs.

    ``sizes`` (n_rung, n_unknown) rising within each sense, ``signals`` (n_rung,).
    """
    candidate = start.hypothesis[0]
    if not has_size(candidate):
        return sizes[int(np.argmax(signals))] if signals.max() >= VISIBLE_SIGNAL else None
    strong = (sizes - candidate.absent)[:, strength_places(candidate)]
    magnitude = np.linalg.norm(strong, axis=1)
    shown = np.flatnonzero(signals >= VISIBLE_SIGNAL)
    if not len(shown):
        return None
    k = int(shown[np.argmin(magnitude[shown])])
    sense = np.sign(strong[:, 0])
    below = [i for i in range(len(sizes)) if sense[i] == sense[k] and magnitude[i] < magnitude[k]]
    if below:
        b = max(below, key=lambda i: magnitude[i])
        share = np.log(VISIBLE_SIGNAL / signals[b]) / max(np.log(signals[k] / signals[b]), 1e-9)
        factor = float((magnitude[b] / magnitude[k]) ** (1.0 - np.clip(share, 0.0, 1.0)))
    else:
        factor = VISIBLE_SIGNAL / float(signals[k])
    return candidate.strengthened(sizes[k], factor)


def is_plausible(candidate: ShapedEffect, unknowns: Array) -> bool:
    """Whether a diagnosis could name a cause of its smallest visible size, by the prior of its strengths.

    The size gains half of ``VISIBLE_SIGNAL`` squared in log-likelihood, and its prior takes half of the squared
    deviations. Both grow with the square of the size: where the prior takes as much, no size of the cause pays.
    """
    if not has_size(candidate):
        return True
    point = np.asarray(unknowns) - (candidate.absent if candidate.designed else 0.0)
    return float(np.linalg.norm(point[strength_places(candidate)])) < VISIBLE_SIGNAL
