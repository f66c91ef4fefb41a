"""Legs that the trials allow: draws of the fit's unknowns, with what holds them together (k with b on a ridge).

An interval a number says too much of each and too little of all: on a ridge k and b may both be off by half, but not
one without the other. Whoever chooses by the fit takes these draws instead.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from synth.fit.bootstrap import Bootstrap
from synth.fit.unknowns import SpringsAndDampers
from synth.model.leg import Array, Damper, Leg, Spring

DRAWS = 64


def draws(values: Array, covariance: Array, refits: Bootstrap | None, seed: int) -> Array:
    """(DRAWS, p) unknowns: the bootstrap's refits where there are any, else normal by the sensitivities."""
    if refits is not None:
        return refits.values[:DRAWS]
    root = np.sqrt(np.maximum(np.diag(covariance), 1e-300))
    value, vector = np.linalg.eigh(covariance / np.outer(root, root))
    half = vector * np.sqrt(np.maximum(value, 0.0))
    normal = np.random.default_rng([seed, DRAWS]).normal(size=(DRAWS, len(values)))
    return np.asarray(values + normal @ half.T * root)


def drawn_legs(leg: Leg, unknowns: SpringsAndDampers, drawn: Array) -> list[Leg]:
    """The fitted leg with each draw (m, p) of its springs and dampers; known damper curves stay."""
    n_rate, n_rest = len(unknowns.rates), len(unknowns.rests)
    found = []
    for values in np.clip(drawn, unknowns.lower, unknowns.upper):
        natural, joints = unknowns.natural(values), list(leg.joints)
        for j, joint in enumerate(leg.joints):
            rest = float(natural[n_rate + unknowns.rests.index(j)])
            spring = Spring(float(natural[unknowns.rates.index(j)]), joint.zero + joint.sign * rest)
            damper = joint.damper
            if j in unknowns.dampers:
                damper = Damper(float(natural[n_rate + n_rest + unknowns.dampers.index(j)]))
            joints[j] = replace(joint, spring=spring, damper=damper)
        found.append(replace(leg, joints=tuple(joints)))
    return found
