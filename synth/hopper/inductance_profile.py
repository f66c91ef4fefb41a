"""Intervals of a motor's constants by profile likelihood over the inductance.

The response is far from linear in the inductance where L/R is below the time between samples: there only an upper bound
is known. A recording that lost the rise of the current shows little but ``R - L/tau`` with tau the run-up's time
constant, so what is known of the inductance, 0 at least, bounds the resistance, and with it every constant. Profile
likelihood: Pawitan, In All Likelihood, 2001, section 3.4.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.estimation.intervals import NORMAL90
from synth.hopper.fit_motor_response import INDUCTANCE, ResponseFit, ResponsePoint, standard_deviations
from synth.hopper.motor_response import CONSTANTS

SAME_COST = 1e-2  # difference of cost, 0.14 standard deviations, below which two fits are alike
BETWEEN = 9  # inductances inside the interval; an end that lies between two of them is at most 1 % too near


@dataclass(frozen=True)
class InductanceProfile:
    """``best`` point, the inductance of ``interval`` H with 90 %, and the best fits with others held, ``points``.

    ``value`` H: 0 if none at all would do as well; ``best`` is then the fit without.
    """

    fit: ResponseFit
    best: ResponsePoint
    value: float
    interval: tuple[float, float]
    points: tuple[ResponsePoint, ...]

    def ends(self) -> Array:
        """(6, 2) 90 % intervals of the unknowns; that of the inductance is ``interval``.

        A value lies inside if some inductance explains it: the union over the profile's points, each with the
        interval of its inductance held and with the cost above the best taken off the 90 %.

        Raises
        ------
        UserError : the simulation diverges near a point.
        """
        low, high = np.full(len(CONSTANTS), np.inf), np.full(len(CONSTANTS), -np.inf)
        for point in self.points:
            left = NORMAL90**2 - 2.0 * max(point.cost - self.best.cost, 0.0)
            if left >= 0.0:
                reach = np.sqrt(left) * standard_deviations(self.fit, point, inductance_held=True)
                low, high = np.minimum(low, point.unknowns - reach), np.maximum(high, point.unknowns + reach)
        return np.column_stack([low, high])


def inductance_profile(fit: ResponseFit, best: ResponsePoint) -> InductanceProfile:
    """The inductance, its 90 % interval, from 0 if none at all would do as well, and the fits that show it."""
    from scipy.optimize import brentq  # imported here: it takes 0.1 s, and only run-ups need it

    at, kept = float(best.unknowns[INDUCTANCE]), {float(best.unknowns[INDUCTANCE]): best}

    def beyond(unknown: float) -> float:
        """Standard deviations from the best fit to that with this inductance, less those of the interval's end."""
        if unknown not in kept:  # a repeated fit begins at its own end and gets a little lower: the bracket fails
            kept[unknown] = _held(fit, kept[min(kept, key=lambda other: abs(other - unknown))], unknown)
        return float(np.sqrt(2.0 * max(kept[unknown].cost - best.cost, 0.0)) - NORMAL90)

    information = float(fit.normal(best).matrix[INDUCTANCE, INDUCTANCE])
    ends = []
    for bound, way in ((float(fit.low[INDUCTANCE]), -1.0), (float(fit.high[INDUCTANCE]), 1.0)):
        inside, step = at, 1.0 / np.sqrt(max(information, 1.0))
        while True:
            outside = way * min(way * bound, way * at + step)
            found = beyond(outside)
            if found > 0.0 or outside == bound:
                break
            inside, step = outside, 2.0 * step
        ends.append(float(brentq(beyond, inside, outside, xtol=0.01 * step)) if found > 0.0 else bound)
    none = float(fit.low[INDUCTANCE])
    for inductance in np.linspace(np.exp(ends[0]), np.exp(ends[1]), BETWEEN + 2).tolist():
        beyond(min(max(float(np.log(inductance)), ends[0]), ends[1]))
    low = 0.0 if ends[0] <= none else float(np.exp(ends[0]))
    without = kept.get(none)
    alike = without is not None and without.cost <= best.cost + SAME_COST
    chosen = without if alike and without is not None else best
    value = 0.0 if alike else float(np.exp(at))
    return InductanceProfile(fit, chosen, value, (low, float(np.exp(ends[1]))), tuple(kept.values()))


def _held(fit: ResponseFit, near: ResponsePoint, unknown: float) -> ResponsePoint:
    """The best fit with an inductance held, from a point near it."""
    unknowns = near.unknowns.copy()
    unknowns[INDUCTANCE] = unknown
    return fit.with_inductance(unknown).best([ResponsePoint(unknowns, near.starts)])
