"""Springs and dampers of legs that MuJoCo simulated are recovered."""

from __future__ import annotations

import numpy as np

from fit.simulated_legs import DAMPER, FREE_ANGLE, SPRING, errors, fitted, releases, robot

DRAWS = 20


def test_random_legs_are_recovered_without_a_starting_guess() -> None:
    """20 of 20 legs within 40 % of the thesis': k and b within 1 %, free angle within 0.2 deg.

    And the errors are as large as the intervals say: over all draws their scores have about unit variance.
    """
    misses, scores = [], []
    for draw in range(DRAWS):
        generator = np.random.default_rng(1000 + draw)
        spring, damper = (values * generator.uniform(0.6, 1.4, 3) for values in (SPRING, DAMPER))
        leg = robot(spring, damper, FREE_ANGLE + generator.uniform(-10, 10, 3))
        found = errors(fitted(leg, releases(leg, draw)), leg)
        rates, angle = np.expm1(np.r_[found.spring, found.damper]), np.degrees(found.angle)
        if np.abs(rates).max() > 0.01 or np.abs(angle).max() > 0.2:
            misses.append((draw, rates, angle, found.spring_sd, found.damper_sd, found.angle_sd))
        scores.append(found.scores)
    assert not misses
    assert 0.8 < np.sqrt(np.mean(np.square(scores))) < 1.2
    # chi-squared with 20 degrees of freedom stays between 5.9 and 45.3 with 99.9 %; nine quantities
    each = np.sum(np.square(scores), axis=0)
    assert each.min() > 5.0
    assert each.max() < 50.0
