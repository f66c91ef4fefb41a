"""The thesis' particle swarm: 20 particles as lanes of the engine, the first at the end of another search.

``v <- w v + c1 r1 (own best - x) + c2 r2 (swarm's best - x)``, ``x <- x + v`` (Kennedy & Eberhart, Proc. IEEE Int.
Conf. Neural Networks, 1995; inertia w after Shi & Eberhart, 1998), with the coefficients of the thesis' script
``pso_fsn_start.m``: w = 0.8, c1 = c2 = 0.1, r1 and r2 one number each for the whole swarm and iteration, initial
velocities within 10 % of the positions, positions kept within the bounds, 100 iterations and no test for convergence.
``decimals`` rounds positions like the script (to four, which is coarse for a rat's ankle); default: no rounding.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from synth.arrays import Array
from synth.fit.simplex import SearchEnd

PARTICLES = 20  # as in the thesis' script, like the following
ITERATIONS = 100  # as in the script
INERTIA, OWN, SOCIAL = 0.8, 0.1, 0.1  # w, c1, c2 of the script
FIRST_VELOCITY = 0.1  # share of the position, as in the script


def swarm(
    cost: Callable[[Array], Array],
    seeded: Array,
    lower: Array,
    upper: Array,
    *,
    seed: int = 0,
    iterations: int = ITERATIONS,
    decimals: int | None = None,
) -> SearchEnd:
    """Minimise ``cost``, which takes columns (d, c) and gives (c,), from ``seeded`` (d,) and 19 random points."""
    generator = np.random.default_rng(seed)
    d = len(seeded)

    def kept(points: Array) -> Array:
        rounded = points if decimals is None else np.round(points, decimals)
        return np.asarray(np.clip(rounded, lower[:, None], upper[:, None]))

    points = lower[:, None] + (upper - lower)[:, None] * generator.random((d, PARTICLES))
    points[:, 0] = seeded
    points = kept(points)
    velocity = FIRST_VELOCITY * points * generator.uniform(-1.0, 1.0, (d, PARTICLES))
    own, own_cost = points.copy(), cost(points)
    best = int(np.argmin(own_cost))
    for _ in range(iterations):
        r1, r2 = generator.random(2)
        velocity = INERTIA * velocity + OWN * r1 * (own - points) + SOCIAL * r2 * (own[:, [best]] - points)
        points = kept(points + velocity)
        found = cost(points)
        better = found < own_cost
        own[:, better], own_cost[better] = points[:, better], found[better]
        best = int(np.argmin(own_cost))
    return SearchEnd(own[:, best].copy(), float(own_cost[best]), iterations, PARTICLES * (iterations + 1))
