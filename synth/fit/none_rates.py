"""Springs and dampers that the trials do not tell from none: intervals in the rate itself, from 0.

An unknown is the logarithm u of a rate k. Where k is small the motion is linear in k and not in u: the deviation of u
is that of k over k, and an interval of u that is as wide has ends of no meaning. In k and in the spring's torque at a
fixed angle, k r, the information stays finite: dk = k du, and r is unknown where k may be 0.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array
from synth.estimation.consider import Considered
from synth.estimation.intervals import NORMAL90
from synth.fit.least_squares import Solution
from synth.fit.link_errors import LinkErrors
from synth.fit.model_error import ModelError
from synth.fit.uncertainty import is_ridge, like_none
from synth.fit.unknowns import SpringsAndDampers

# Deviations from 0 of a rate below a limb's range that is told from none: one-sided 99 %, by the normal distribution. A
# choice: at the interval's own 95 % every twentieth absent spring would be told.
SURE_DEVIATIONS = 2.33
SAME_RATE = np.log(2.0)  # of a logarithm; more between a ridge's softest point and its least residual is a ridge


@dataclass(frozen=True)
class NoneRates:
    """Places of log rates that are not told from none, and (p,) deviations of all unknowns without priors.

    A deviation of a logarithm is relative, of the rate itself. ``links`` : the links' errors, at these places without
    priors too: a prior would hold the rate where the links' errors move it.
    """

    places: tuple[int, ...]
    deviation: Array
    links: LinkErrors | None

    def offsets(self, unknowns: SpringsAndDampers, offsets: tuple[Array, Array]) -> tuple[Array, Array]:
        """The ends (p,) of the intervals relative to the values: from a rate of 0, free angles of such springs open."""
        low, high = (each.copy() for each in offsets)
        for place in self.places:
            low[place], high[place] = -np.inf, np.log1p(NORMAL90 * self.deviation[place])
        for j in unknowns.rests:
            if j in unknowns.rates and unknowns.rate_at(j) in self.places:
                low[unknowns.rest_at(j)], high[unknowns.rest_at(j)] = -np.inf, np.inf
        return low, high

    def drawn(self, unknowns: SpringsAndDampers, values: Array, drawn: Array) -> Array:
        """Draws (k, p) about ``values`` (p,), normal in these rates and in the torques of these springs."""
        made = drawn.copy()
        for place in self.places:
            least = unknowns.lower[place] - values[place]
            made[:, place] = values[place] + np.log(np.maximum(1.0 + drawn[:, place] - values[place], np.exp(least)))
        for j in unknowns.rests:
            if j in unknowns.rates and unknowns.rate_at(j) in self.places:
                rate, rest = unknowns.rate_at(j), unknowns.rest_at(j)
                # k' (r' - r) is the torque that k (r' - r) was.
                made[:, rest] = values[rest] + (drawn[:, rest] - values[rest]) * np.exp(values[rate] - made[:, rate])
        return made


def none_rates(
    unknowns: SpringsAndDampers,
    solution: Solution,
    cov: Array,
    links: LinkErrors | None,
    error: ModelError | None = None,
    least: Solution | None = None,
) -> NoneRates:
    """The rates of a solution that 0 explains as well.

    ``cov`` (p, p) of the unknowns by the trials alone, without priors; ``least`` : the other end of a ridge along which
    the solution was moved.
    """
    values, variance = solution.values, np.diag(cov).copy()
    sensitivity = None
    if links is not None:
        # H S is the change of the gradient, whatever the prior in H.
        sensitivity = cov @ solution.information.schur() @ links.considered.sensitivity
        variance += (sensitivity**2).sum(axis=1)
    if error is not None:
        variance += np.diag(error.covariance)
    deviation = np.sqrt(variance)
    places = tuple(
        place
        for place in _separate_rates(unknowns, cov)
        if like_none(unknowns, place, values)
        and SURE_DEVIATIONS * deviation[place] >= 1.0
        and (least is None or abs(least.values[place] - values[place]) < SAME_RATE)
    )
    if links is not None and sensitivity is not None and places:
        moved, some = links.considered.sensitivity.copy(), list(places)
        moved[some] = sensitivity[some]
        links = replace(links, considered=Considered(moved))
    return NoneRates(places, deviation, links)


def _separate_rates(unknowns: SpringsAndDampers, cov: Array) -> list[int]:
    """Places of the rates that are on no ridge: along one, spring and damper vary together and are not none."""
    found = []
    for j in range(len(unknowns.leg.joints)):
        spring = unknowns.rate_at(j) if j in unknowns.rates else None
        damper = unknowns.damper_at(j) if j in unknowns.dampers else None
        if spring is None or damper is None or not is_ridge(cov, spring, damper):
            found += [place for place in (spring, damper) if place is not None]
    return found
