"""Ends of the 90 % intervals relative to the estimates: noise, the links' errors, the law's, and a ridge."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from synth.arrays import Array
from synth.estimation.intervals import NORMAL90
from synth.fit.bootstrap import Bootstrap
from synth.fit.least_squares import Solution
from synth.fit.model_error import ModelError
from synth.fit.none_rates import NoneRates
from synth.fit.unknowns import SpringsAndDampers

Ends = tuple[Array, Array]  # (p,) each


def interval_ends(
    unknowns: SpringsAndDampers,
    chosen: tuple[str, Solution],
    spreads: Mapping[str, Array],
    refits: Bootstrap | None,
    nones: Mapping[str, NoneRates],
    error: ModelError | None,
    least: Solution | None,
) -> dict[str, Ends]:
    """Ends of each treatment's intervals by its name: noise, links' errors and ridge included.

    ``chosen`` : the chosen treatment's name and solution; ``spreads`` (p, p) the noise's covariances; ``nones`` with
    the links' errors; ``error`` and ``least`` as of ``FittedTreatments``.
    """
    mode, values = chosen[0], chosen[1].values
    offsets = {name: _normal_offsets(spread) for name, spread in spreads.items()}
    if refits is not None:
        offsets[mode] = refits.offsets(values)
    for name, found in nones.items():
        if found.links is not None:
            offsets[name] = _add_errors(offsets[name], found.links.covariance)
    if error is not None:
        offsets[mode] = _add_errors(offsets[mode], error.covariance)
    if least is not None:
        offsets[mode] = _offsets_reaching(offsets[mode], values, least.values)
    return {name: nones[name].offsets(unknowns, own) for name, own in offsets.items()}


def _add_errors(offsets: Ends, covariance: Array) -> Ends:
    """The ends of the intervals with independent errors of this covariance (p, p) added in quadrature."""
    half = NORMAL90 * np.sqrt(np.diag(covariance))
    return -np.hypot(offsets[0], half), np.hypot(offsets[1], half)


def _offsets_reaching(offsets: Ends, values: Array, least: Array) -> Ends:
    """The offsets about ``values``, widened to contain the same interval about ``least``."""
    low, high = offsets
    moved = least - values
    return np.minimum(low, moved + low), np.maximum(high, moved + high)


def _normal_offsets(covariance: Array) -> Ends:
    """(p,) each, the ends of the 90 % intervals relative to the values, from the covariance."""
    half = NORMAL90 * np.sqrt(np.maximum(np.diag(covariance), 0.0))
    return -half, half
