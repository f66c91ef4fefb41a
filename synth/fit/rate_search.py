"""Springs and dampers by search, as in the thesis: only spring and damper rates are unknown.

Each trial's initial state is read from its first samples, and its free angles follow from the spring rates and the
final pose, in which spring and weight balance (the thesis' ``theta_bias``; its sign of the foot's weight is
corrected here). Two unknowns per joint remain, and any cost can be used, even a discontinuous one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from synth.arrays import Array
from synth.fit.fit_problem import unknowns_of
from synth.fit.recordings import Recording
from synth.fit.simplex import SearchEnd, simplex
from synth.fit.starts import Start, balanced_rests, starts
from synth.fit.swarm import swarm
from synth.fit.trajectories import Local, TrajectoryModel
from synth.fit.weak_form import weak_form
from synth.swing.leg_model import DamperCurve
from synth.swing.mechanics import outboard_inertia
from synth.threads import shared_out

TOLERANCE = 1e-6  # relative, of the integration: a direct search needs no derivatives
WINDOW = 0.1  # s, in the same unit, of the weak form
FACTOR = 10.0  # factor between the start and the bounds
START = (3.0, 20.0)  # Hz of k/I and 1/s of b/I, in the recordings' unit of time, if the weak form has no solution


@dataclass(frozen=True)
class Bounds:
    """Lower and upper bounds of spring rates (n,) N m/rad and damper rates (n,) N m s/rad."""

    lower: Array  # (2, n)
    upper: Array  # (2, n)

    @classmethod
    def around(cls, start: Array, factor: float = FACTOR) -> Bounds:
        """A factor in both directions from rates (2, n)."""
        return cls(start / factor, start * factor)


class CostByJoint(Protocol):
    """The cost of a search."""

    def of(self, motions: Sequence[Array]) -> Array:
        """(c, n) costs of candidates by joint, from their motions (m, n, c) rad a trial."""


@dataclass
class Search:
    """A leg, its recordings and a cost; rates are (2, n): spring and damper rates, in natural units.

    ``common`` : one free angle for all trials (their median) instead of one each; a trial in which a joint is locked
    tells nothing of its free angle. ``calls`` counts calls of the engine.
    """

    model: TrajectoryModel
    recordings: Sequence[Recording]
    cost: CostByJoint
    common: bool = False
    starts: tuple[Start, ...] = ()
    calls: int = field(default=0, init=False)

    def __post_init__(self) -> None:
        self.starts = self.starts or starts(self.recordings)
        self.unknowns = unknowns_of(self.model)
        self.rough = self.model.at_tolerance(TOLERANCE)
        self.n = len(self.model.leg.joints)
        free = np.array([np.isin(np.arange(self.n), recording.free) for recording in self.recordings])
        self._told = free | ~free.any(axis=0)  # (n_trial, n); of a joint that is always locked any pose will do

    def rests(self, spring_rate: Array) -> Array:
        """(n_trial, n, c) rad, rest angles that balance each trial's final pose, for spring rates (n, c).

        Where a joint is locked, the median of the other trials.
        """
        rests = balanced_rests(self.model.leg, self.recordings, [start.end for start in self.starts], spring_rate)
        told = self._told[:, :, None] & (not self.common)
        return np.where(told, rests, self._middle(rests))

    def _middle(self, rests: Array) -> Array:
        """(n, c) rad, median of rest angles (n_trial, n, c) over the trials that tell them."""
        return np.asarray(np.nanmedian(np.where(self._told[:, :, None], rests, np.nan), axis=0))

    def motions(self, rates: Array) -> list[Array]:
        """(m, n, c) rad a trial for rates (2, n, c)."""
        self.calls += 1
        count = rates.shape[2]
        sought = self.unknowns
        values = np.concatenate([
            np.log(rates[0][list(sought.rates)]),
            np.zeros((len(sought.rests), count)),
            np.log(rates[1][list(sought.dampers)]),
        ])  # fmt: skip
        rests = self.rests(rates[0])

        def one(t: int) -> Array:
            state = np.concatenate([self.starts[t].rotation, self.starts[t].rate])
            return self.rough.run(self.recordings[t], values, np.repeat(state[:, None], count, axis=1), rests[t])

        return shared_out(one, len(self.recordings))

    def by_joint(self, rates: Array) -> Array:
        """(c, n) costs for rates (2, n, c)."""
        return self.cost.of(self.motions(rates))

    def locals(self, spring_rate: Array) -> tuple[Array, list[Local]]:
        """The common rests (n,) rad, and each trial's own unknowns, for spring rates (n,)."""
        rests = self.rests(spring_rate[:, None])
        middle = self._middle(rests)[:, 0]
        own = [Local(s.rotation, s.rate, rest - middle) for s, rest in zip(self.starts, rests[:, :, 0], strict=True)]
        return middle, own

    def first(self, curves: Sequence[DamperCurve | None]) -> Array:
        """(2, n) starting rates: the weak form's, or typical ones if it has no solution."""
        inertia = outboard_inertia(self.model.leg)
        unit, highest = self.recordings[0].unit, np.exp([side[1] for side in self.unknowns.box.rates(self.model.leg)])
        natural = np.array([inertia * (2 * np.pi * START[0] / unit) ** 2, inertia * START[1] / unit])
        found = weak_form(self.model.leg, self.recordings, curves, window=WINDOW * unit)
        rates = np.array([found.spring_rate, found.damper_rate])
        # Below a hundredth of a limb's rates, or beyond what these recordings can show, the weak form failed.
        within = (rates > 0.01 * natural) & (rates < highest)
        return np.where(within.all(axis=0), rates, natural)

    def piecewise(
        self,
        start: Array,
        bounds: Bounds,
        order: Sequence[int] | None = None,
        judged: Sequence[Sequence[int]] | None = None,
    ) -> tuple[Array, list[SearchEnd]]:
        """(2, n) rates by a simplex joint after joint, the others fixed: knee, hip, ankle, as in the thesis.

        Each joint's two rates minimise its own cost and that of the joints before it in the order, or that of
        the joints ``judged`` at each step.
        """
        rates, found = start.copy(), []
        steps = tuple(order) if order is not None else order_of(self.n)
        for place, j in enumerate(steps):
            if j not in self.unknowns.rates:  # locked in all recordings
                continue
            done = tuple(judged[place]) if judged is not None else steps[: place + 1]
            rows = [0, 1] if j in self.unknowns.dampers else [0]

            def cost(columns: Array, j: int = j, rows: Sequence[int] = rows, done: Sequence[int] = done) -> Array:
                tried = np.repeat(rates[:, :, None], columns.shape[1], axis=2)
                tried[rows, j] = columns
                return np.asarray(self.by_joint(tried)[:, list(done)].sum(axis=1))

            result = simplex(cost, rates[rows, j], bounds.lower[rows, j], bounds.upper[rows, j])
            rates[rows, j] = result.point
            found.append(result)
        return rates, found

    def swarm(
        self, seeded: Array, bounds: Bounds, *, seed: int = 0, decimals: int | None = None
    ) -> tuple[Array, SearchEnd]:
        """(2, n) rates by the swarm over all joints, its first particle at ``seeded`` (2, n)."""
        sought = np.array([np.isin(np.arange(self.n), each) for each in (self.unknowns.rates, self.unknowns.dampers)])

        def cost(columns: Array) -> Array:
            tried = np.repeat(seeded[:, :, None], columns.shape[1], axis=2)
            tried[sought] = columns
            return np.asarray(self.by_joint(tried).sum(axis=1))

        result = swarm(cost, seeded[sought], bounds.lower[sought], bounds.upper[sought], seed=seed, decimals=decimals)
        rates = seeded.copy()
        rates[sought] = result.point
        return rates, result


def order_of(n: int) -> tuple[int, ...]:
    """The order of the joints: the second, the first, then outwards (knee, hip, ankle)."""
    return (1, 0, *range(2, n)) if n > 1 else (0,)
