"""Draws of the fit's unknowns with their correlation (k and b on a ridge): legs that agree with the trials.

An interval a number says too much of each and too little of all: on a ridge k and b may both be off by half, but not
one without the other. Whoever chooses by the fit takes these draws instead.
"""

from __future__ import annotations

import numpy as np

from synth.arrays import Array
from synth.estimation.intervals import spectrum
from synth.fit.bootstrap import Bootstrap
from synth.fit.link_errors import LinkErrors
from synth.fit.unknowns import SpringsAndDampers
from synth.swing.leg_model import Leg

DRAWS = 64  # legs that the trials allow, for each of which the parts are scored


def draws(values: Array, covariance: Array, refits: Bootstrap | None, links: LinkErrors | None, seed: int) -> Array:
    """(DRAWS, p) unknowns: the bootstrap's refits where there are any, else normal by the sensitivities.

    ``links`` : errors of the links' numbers move each draw too, all its unknowns together.
    """
    generator = np.random.default_rng([seed, DRAWS])
    moved = np.zeros((DRAWS, len(values)))
    if links is not None:
        sensitivity = links.considered.sensitivity
        moved = generator.normal(size=(DRAWS, sensitivity.shape[1])) @ sensitivity.T
    if refits is not None:
        return refits.values[:DRAWS] + moved[: len(refits.values)]
    root = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    value, vector = spectrum(covariance, root)
    half = vector * np.sqrt(np.maximum(value, 0.0))
    normal = generator.normal(size=(DRAWS, len(values)))
    return np.asarray(values + normal @ half.T * root + moved)


def drawn_legs(unknowns: SpringsAndDampers, drawn: Array) -> list[Leg]:
    """The leg with each draw (m, p) of its springs and dampers; known damper curves stay."""
    return [unknowns.fitted_leg(values) for values in np.clip(drawn, unknowns.lower, unknowns.upper)]
