"""Search for the best sets of parts: every set is simulated if feasible, else sets are screened first.

Screening approximates the motion, not the error. The motion of a set is the motion of a base set plus the change caused
by each joint's part alone, which was simulated: ``q(o_1, ..., o_n) = q(b) + sum_j (q(b with o_j) - q(b))``. Large
changes at one joint are exact; only interactions between changes at different joints are neglected (cut-HDMR of first
order, Rabitz & Alis, J. Math. Chem. 25, 1999). The squared error of such a sum is a sum of inner products over pairs of
joints. These are computed once, so a set costs a few additions.

The base moves to the best simulated set until it no longer changes. Sets are then simulated in the order of their
screened errors until no remaining set can be better. The bound for this comes from the errors of the screening on the
sets simulated so far, many of them drawn at random and along the order. The screening is most accurate near the base,
where parts differ little from the base's and interact little.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.design.part_lanes import Index, PartLanes

MANY = 512  # sets among which others are looked for where the best ones are not allowed
EXHAUSTIVE = 20_000  # trajectories (sets times releases) that are simulated without screening: some seconds
SAMPLES = 6_000  # of the motions used for screening: enough to rank sets, a choice
BATCH = 256  # sets simulated together: sixteen groups of lanes
DRAWN = 512  # sets drawn at random, to measure the screening's errors
MOST_SIMULATED = 6_000  # sets simulated at most: bounds the time, see `bench_parts`
MOST_BASES = 5  # rounds of screening, each about a better base set
SCREENED = 8_192  # best screened sets that are kept
NEAR_BEST = 3.0  # times the best error: up to this the screening's errors are evaluated
SAFETY = 1.3  # factor on the observed errors of the screening
AT_BEST = 0.05  # multiples of the best error, below it, at which the bound on the screening's error starts
PREFIXES = 2_048  # combinations of all joints but the last that are screened at a time


@dataclass(frozen=True)
class Mistake:
    """A bound on the screening's error: zero at the best set, growing in proportion away from it.

    ``slope``: possible relative error of the screening, per multiple of the ``best`` error (rad) above it. ``ratio``:
    the lowest observed ratio of true to screened error, which limits the bound.
    """

    best: float
    slope: float
    ratio: float

    def least(self, guess: Array) -> Array:
        """Lower bound (rad) on the true errors of sets with these screened errors ``guess`` (rad)."""
        share = 1.0 - self.slope * (guess / self.best - 1.0 + AT_BEST)
        return guess * np.maximum(share, self.ratio)


@dataclass(frozen=True)
class FoundSets:
    """The best sets, best first.

    ``index`` (m, n) option numbers, ``error`` (m,) rad. ``n_simulated`` of ``n_set`` sets were simulated. ``mistake``:
    bound on the screening's error, None without screening. ``complete``: whether, by that bound, every set that was not
    simulated is worse than the last of these.
    """

    index: Index
    error: Array
    n_set: int
    n_simulated: int
    mistake: Mistake | None
    complete: bool

    @property
    def exhaustive(self) -> bool:
        """Whether every set was simulated."""
        return self.n_simulated >= self.n_set


def best_sets(
    lanes: PartLanes, start: Sequence[int], keep: int = 16, *, exhaustive: int = EXHAUSTIVE, seed: int = 0
) -> FoundSets:
    """The ``keep`` sets with the lowest response errors.

    Parameters
    ----------
    start
        option number of each joint: the first base set.
    exhaustive
        number of trajectories up to which every set is simulated.
    """
    if lanes.n_set * len(lanes.releases) <= exhaustive:
        index = _all_combinations(lanes.counts)
        error = lanes.errors(index)
        order = np.argsort(error, kind="stable")[:keep]
        return FoundSets(index[order], error[order], len(index), len(index), None, True)
    return _Screening(lanes, keep, np.random.default_rng(seed)).run(np.array(start, dtype=np.int64))


def best_allowed(
    lanes: PartLanes, keep: int, allows: Callable[[Sequence[int]], bool], *, seed: int = 0
) -> tuple[FoundSets, list[list[int]]]:
    """The best ``keep`` sets, and those that are allowed: among them, or else the first ones among ``MANY``."""
    start = [0] * len(lanes.counts)
    found = more = best_sets(lanes, start, keep, seed=seed)
    allowed = [row for row in found.index.tolist() if allows(row)]
    if not allowed:
        more = best_sets(lanes, start, MANY, seed=seed)
        allowed = [row for row in more.index.tolist() if allows(row)][:keep]
    return found, allowed


def _all_combinations(counts: Sequence[int]) -> Index:
    """(n_set, n) every combination, the last joint's option changing fastest."""
    return np.stack(np.unravel_index(np.arange(int(np.prod(counts))), counts), axis=1).astype(np.int64)


class _Screening:
    """The state of one search: the simulated errors by the set's number."""

    def __init__(self, lanes: PartLanes, keep: int, generator: np.random.Generator) -> None:
        self.lanes, self.keep, self.generator = lanes, keep, generator
        self.known: dict[int, float] = {}
        self.every = max(1, sum(m.size for m in lanes.motions) // SAMPLES)

    def run(self, base: Index) -> FoundSets:
        for _ in range(MOST_BASES):
            screen = _Screen(self.lanes, base, self.every)
            numbers, guess = screen.best(SCREENED)
            self.simulate(numbers[:BATCH])
            best = self.index(min(self.known, key=lambda number: (self.known[number], number)))
            if np.array_equal(best, base):
                break
            base = best
        drawn = self.generator.integers(0, self.lanes.n_set, DRAWN)
        self.simulate(drawn)
        self.simulate(numbers[np.unique(np.geomspace(BATCH, len(numbers) - 1, DRAWN).astype(int))])
        done, complete = BATCH, False
        while True:
            mistake = self.mistake(screen)
            bound = float(np.partition(list(self.known.values()), self.keep - 1)[self.keep - 1])
            may_be_better = np.flatnonzero(mistake.least(guess) <= bound)
            reach = int(may_be_better[-1]) + 1 if len(may_be_better) else 0
            complete = done >= reach and (reach < len(numbers) or len(numbers) == self.lanes.n_set)
            if done >= reach or len(self.known) >= MOST_SIMULATED:
                break
            self.simulate(numbers[done : done + BATCH])
            done += BATCH
        found = sorted(self.known.items(), key=lambda item: (item[1], item[0]))[: self.keep]
        index = np.stack([self.index(number) for number, _ in found])
        error = np.array([value for _, value in found])
        return FoundSets(index, error, self.lanes.n_set, len(self.known), mistake, complete)

    def index(self, numbers: int | Index) -> Index:
        return np.stack(np.unravel_index(numbers, self.lanes.counts), axis=-1).astype(np.int64)

    def simulate(self, numbers: Index) -> None:
        new = [int(number) for number in np.unique(numbers) if int(number) not in self.known]
        if new:
            errors = self.lanes.errors(self.index(np.array(new)))
            self.known.update(zip(new, errors.tolist(), strict=True))

    def mistake(self, screen: _Screen) -> Mistake:
        """Bound on the true error below the screened one, from the sets that were simulated."""
        numbers = np.array(list(self.known))
        true = np.array(list(self.known.values()))
        guess = np.maximum(screen.errors(self.index(numbers)), 1e-12)
        best = float(true.min())
        near = np.minimum(true, guess) <= NEAR_BEST * best
        short = np.maximum(1.0 - true[near] / guess[near], 0.0)
        slope = SAFETY * float(np.max(short / (guess[near] / best - 1.0 + AT_BEST), initial=0.0))
        return Mistake(best, slope, max(0.0, 1.0 - SAFETY * float(short.max(initial=0.0))))


class _Screen:
    """Squared errors of all sets about one base, as sums over joints and pairs of joints."""

    def __init__(self, lanes: PartLanes, base: Index, every: int) -> None:
        self.counts = lanes.counts
        n = len(self.counts)
        singles = np.concatenate([_with_each_option(base, j, count) for j, count in enumerate(self.counts)])
        motions = lanes.residuals(np.concatenate([base[None, :], singles]), every)
        zero = motions[:, :1]
        ends = np.cumsum([0, *self.counts])
        moves = [motions[:, 1 + ends[j] : 1 + ends[j + 1]] - zero for j in range(n)]
        self.constant = float(np.sum(zero**2))
        self.own = [2.0 * (zero[:, 0] @ move) + np.sum(move**2, axis=0) for move in moves]
        self.pairs = {(i, j): 2.0 * moves[i].T @ moves[j] for j in range(n) for i in range(j)}

    def errors(self, index: Index) -> Array:
        """(n_set,) rad, the screened errors of these sets."""
        square = self.constant + sum(own[index[:, j]] for j, own in enumerate(self.own))
        for (i, j), pair in self.pairs.items():
            square = square + pair[index[:, i], index[:, j]]
        return np.asarray(np.sqrt(np.maximum(square, 0.0)))

    def best(self, most: int) -> tuple[Index, Array]:
        """Numbers and screened errors (rad) of the ``most`` best of all sets, best first."""
        numbers, squares = np.zeros(0, dtype=np.int64), np.zeros(0)
        for first, block in self._blocks():
            flat = block.ravel()
            better = np.flatnonzero(flat < squares.max()) if len(squares) >= most else np.arange(len(flat))
            if len(better) > most:
                better = better[np.argpartition(flat[better], most - 1)[:most]]
            numbers = np.concatenate([numbers, first + better])
            squares = np.concatenate([squares, flat[better]])
            if len(squares) > most:
                kept = np.argpartition(squares, most - 1)[:most]
                numbers, squares = numbers[kept], squares[kept]
        order = np.lexsort((numbers, squares))
        return numbers[order], np.sqrt(np.maximum(squares[order], 0.0))

    def _blocks(self) -> Iterator[tuple[int, Array]]:
        """Number of the first set and squared errors (n_prefix, n_last) of blocks of sets, in order."""
        last = len(self.counts) - 1
        n_prefix = int(np.prod(self.counts[:-1]))
        for start in range(0, n_prefix, PREFIXES):
            numbers = np.arange(start, min(start + PREFIXES, n_prefix))
            prefix = np.unravel_index(numbers, self.counts[:-1]) if last else ()
            square = np.full(len(numbers), self.constant)
            for j in range(last):
                square += self.own[j][prefix[j]]
                for i in range(j):
                    square += self.pairs[i, j][prefix[i], prefix[j]]
            block = square[:, None] + self.own[last]
            for i in range(last):
                block += self.pairs[i, last][prefix[i]]
            yield start * self.counts[-1], block


def _with_each_option(base: Index, joint: int, count: int) -> Index:
    """(count, n) the base with each option of one joint."""
    index = np.repeat(base[None, :], count, axis=0)
    index[:, joint] = np.arange(count)
    return index
