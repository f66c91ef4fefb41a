"""The legs that show wanted characteristics: the likeliest one, and how far every rate can be from its.

Each rate is fixed at steps from the likeliest leg's, both ways, everything else is fitted again, and the steps end
where the leg becomes less likely than a 90 % interval allows (a profile: Raue et al., Bioinformatics 25 (2009) 1923).
An interval from sensitivities at one leg would tell nothing of the others.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.estimation.intervals import NORMAL90
from synth.fit.random_streams import Stream
from synth.fit.wanted_release import MOST_LOGARITHM, CharacteristicRelease

DIFFERENCE = 1e-3  # of a logarithm, for derivatives: far above the integrator's error, far below what bends them
TOLERANCE = 1e-3  # relative, of cost and step: a logarithm then moves by less than any characteristic can show
ITERATIONS, PROFILE_ITERATIONS = 25, 8  # most of a search, and of one that begins beside a solution
DISTAL = (1.0, 2.0, -1.0)  # logarithms by which the last joint is stiffer at other starts: it follows the others' swing
DRAWN_STARTS, DRAWN_SPREAD = 4, 1.2  # further starts, and their standard deviation in logarithms
COST_RISE = 0.5 * NORMAL90**2  # of the negative log-likelihood within a 90 % interval of one parameter
BETTER = 0.1  # fall of the cost from which a leg met on the way takes the likeliest one's place
RESTARTS = 3  # a choice: each begins at a likelier leg
FIRST_STEP, GROWTH, LAST_STEP = 0.15, 1.4, 0.02  # logarithms; the last: an end is known to 2 %
MOST_TRIES = 16  # of one profile: without a failure they reach the end of the box
AIM, SHORTER = 0.98, (0.1, 0.6)  # of the way to an interval's end that is tried; least and most share of a failed step


@dataclass(frozen=True, eq=False)
class WantedCandidate:
    """Unknowns (p,) and the negative log-likelihood of their leg."""

    x: Array
    cost: float


@dataclass(frozen=True, eq=False)
class WantedSearch:
    """Least squares of ``CharacteristicRelease.residuals``."""

    release: CharacteristicRelease

    def legs(self, seed: int = 0) -> tuple[WantedCandidate, ...]:
        """The likeliest leg, then the others: of each rate the least and the greatest within its 90 % interval."""
        met = sorted((self.solved(start) for start in self._starts(seed)), key=lambda each: each.cost)
        for _ in range(RESTARTS):
            best, beside = met[0], self._profiles(met[0], BETTER)
            least = min(beside, key=lambda each: each.cost)
            if least.cost >= best.cost - BETTER:
                return self._likely(best, [*met[1:], *beside])
            met = [min(self.solved(least.x), least, key=lambda each: each.cost), *met]
        return self._likely(met[0], [*met[1:], *self._profiles(met[0], np.inf)])

    @staticmethod
    def _likely(best: WantedCandidate, others: Sequence[WantedCandidate]) -> tuple[WantedCandidate, ...]:
        return best, *(each for each in others if each.cost <= best.cost + COST_RISE)

    def _profiles(self, best: WantedCandidate, better: float) -> list[WantedCandidate]:
        """The legs met while each unknown moves both ways, until one is likelier than ``best`` by ``better``."""
        found: list[WantedCandidate] = []
        for unknown in range(self.release.n):
            for way in (-1, 1):
                found += self._profile(best, unknown, way)
            if min((each.cost for each in found), default=np.inf) < best.cost - better:
                break
        return found

    def solved(self, start: Array, fixed: Sequence[int] = (), most: int = ITERATIONS) -> WantedCandidate:
        """The likeliest leg near a start, with some unknowns ``fixed``."""
        from scipy.optimize import least_squares  # imported here: it takes 0.1 s, and few fits state a wanted motion

        free = [j for j in range(self.release.n) if j not in fixed]
        if not free:
            return WantedCandidate(start, self._cost(start))

        def whole(part: Array) -> Array:
            x = start.copy()
            x[free] = part
            return x

        inside = MOST_LOGARITHM * (1.0 - 1e-9)  # a start on a bound is refused

        def residuals(part: Array) -> Array:
            return np.asarray(self.release.residuals(whole(part)[None])[0])

        def derivatives(part: Array) -> Array:
            return self._derivatives(whole(part), free)

        found = least_squares(
            residuals,
            np.clip(start[free], -inside, inside),
            jac=derivatives,
            bounds=(-MOST_LOGARITHM, MOST_LOGARITHM),
            max_nfev=most,
            xtol=TOLERANCE,
            ftol=TOLERANCE,
        )
        return WantedCandidate(whole(found.x), float(found.cost))

    def _cost(self, x: Array) -> float:
        return float(0.5 * (self.release.residuals(x[None])[0] ** 2).sum())

    def _derivatives(self, x: Array, free: Sequence[int]) -> Array:
        """(r, len(free)) by differences, all simulated together."""
        points = np.repeat(x[None], 1 + len(free), axis=0)
        for row, unknown in enumerate(free):
            points[1 + row, unknown] += DIFFERENCE
        found = self.release.residuals(points)
        return np.asarray((found[1:] - found[0]).T / DIFFERENCE)

    def _starts(self, seed: int) -> list[Array]:
        """The usual rates; the joints alone, with the last joint stiffer or softer and its damper; and drawn ones."""
        size, last = self.release.n, self.release.n // 2 - 1
        alone = -np.tile(self.release.usual, 2)
        starts = [np.zeros(size), alone] if last else [np.zeros(size)]
        if last == 0:
            return starts  # nothing is coupled
        for shift in DISTAL:
            start = alone.copy()
            start[[last, size - 1]] += shift
            starts.append(start)
        return [*starts, *Stream.WANTED.generator(seed).normal(0.0, DRAWN_SPREAD, (DRAWN_STARTS, size))]

    def _profile(self, best: WantedCandidate, unknown: int, way: int) -> list[WantedCandidate]:
        """Legs with this unknown ever farther from that of ``best``, the last at the end of its interval."""
        found, step = [best], FIRST_STEP
        for _ in range(MOST_TRIES):
            last = found[-1]
            if step < LAST_STEP or abs(last.x[unknown]) >= MOST_LOGARITHM:
                break
            there = self._beside(last, unknown, last.x[unknown] + way * step)
            if there.cost <= best.cost + COST_RISE:
                found.append(there)
                step *= GROWTH
                continue
            # The root of the rise grows about linearly. A step that only ended in another valley is tried shorter too.
            low, high = (np.sqrt(max(each.cost - best.cost, 0.0)) for each in (last, there))
            step *= float(np.clip(AIM * (np.sqrt(COST_RISE) - low) / (high - low), *SHORTER))
        return found[1:]

    def _beside(self, last: WantedCandidate, unknown: int, value: float) -> WantedCandidate:
        start = last.x.copy()
        start[unknown] = np.clip(value, -MOST_LOGARITHM, MOST_LOGARITHM)
        return self.solved(start, (unknown,), PROFILE_ITERATIONS)
