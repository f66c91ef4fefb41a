"""Where fits begin: a strong cause changes a swing too much for a search that begins with hardly any of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from synth.diagnosis.solve import Fit

LADDER = (0.1, 1.0, -1.0, 4.0, -4.0, 12.0, 30.0, 70.0)  # times a start's strengths
STIFF_LADDER = (0.5, 2.0, 8.0)  # its like where a strength is a compliance: the stiffer, the dearer


def rungs(fit: Fit, first: int) -> list[Fit]:
    """The start with the strengths of its last candidate multiplied by ``LADDER``, those that its bounds allow.

    ``first`` : place of that candidate's unknowns.
    """
    made, seen = [], set()
    for factor in LADDER if fit.hypothesis[-1].effect.way != "structure" else STIFF_LADDER:
        rung = strengthened(fit, first, factor)
        key = tuple(rung.unknowns[first:].round(9))
        if key not in seen:
            seen.add(key)
            made.append(rung)
    return made


def strengthened(fit: Fit, first: int, factor: float) -> Fit:
    """The fit with its last candidate's strengths multiplied, within its bounds."""
    candidate = fit.hypothesis[-1]
    strengths = np.array([name in candidate.effect.strengths for name in candidate.shape.free])
    low, high = candidate.bounds()
    unknowns = fit.unknowns.copy()
    unknowns[first:] = np.clip(unknowns[first:] * np.where(strengths, factor, 1.0), low, high)
    return replace(fit, unknowns=unknowns)
