"""Commands of random steps and ramps, each joint with its own, and variations of a good one.

The rivals decide which command is best, and none of a few well-known shapes has to be near it: two causes that act
alike in slow motion may differ only where the duty is at its limit, or where one joint moves and the other rests.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array, Mask

USUAL_DWELL = 0.5  # s, usual time of a level: several rise times of a servo
LEAST_LEVELS = 3  # levels
STEP_SHARE = 0.6  # share of levels that are reached by a step; the others by a ramp
CHANGED_SHARE, CHANGE_SIZE = 0.3, 0.4  # share of numbers that a variation changes, and how far in half ranges


@dataclass(frozen=True)
class Programme:
    """Levels between -1 and 1 that each joint takes one after the other.

    ``levels``, ``dwell`` (k, n): level and its share of the time; ``stepped`` (k, n): reached by a step, else by a ramp
    that takes all its time.
    """

    levels: Array
    dwell: Array
    stepped: Mask

    @classmethod
    def drawn(cls, rng: np.random.Generator, n: int, length: float) -> Programme:
        """A programme at random, for ``n`` joints and ``length`` s."""
        count = max(LEAST_LEVELS, round(length / USUAL_DWELL))
        size = (count, n)
        return cls(rng.uniform(-1.0, 1.0, size), rng.uniform(0.3, 1.7, size), rng.random(size) < STEP_SHARE)

    def varied(self, rng: np.random.Generator) -> Programme:
        """A neighbour: some numbers changed."""

        def moved(values: Array, by: float, low: float, high: float) -> Array:
            chosen = rng.random(values.shape) < CHANGED_SHARE
            return np.asarray(np.clip(values + chosen * by * rng.standard_normal(values.shape), low, high))

        swapped = rng.random(self.stepped.shape) < 0.5 * CHANGED_SHARE
        return replace(
            self,
            levels=moved(self.levels, CHANGE_SIZE, -1.0, 1.0),
            dwell=moved(self.dwell, CHANGE_SIZE, 0.2, 2.0),
            stepped=self.stepped ^ swapped,
        )

    def shape(self, time: Array) -> Array:
        """(m, n) between -1 and 1 at ``time`` (m,) s; begins at the first level."""
        length = float(time[-1])
        made = np.empty((len(time), self.levels.shape[1]))
        for j in range(made.shape[1]):
            ends = np.cumsum(self.dwell[:, j]) / self.dwell[:, j].sum() * length
            before = np.r_[self.levels[0, j], self.levels[:-1, j]]
            place = np.minimum(np.searchsorted(ends, time, side="right"), len(ends) - 1)
            start = np.r_[0.0, ends[:-1]][place]
            along = np.where(self.stepped[place, j], 1.0, (time - start) / np.maximum(ends[place] - start, 1e-9))
            made[:, j] = before[place] + along * (self.levels[place, j] - before[place])
        return made
