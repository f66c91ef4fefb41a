"""What a residual says: of recordings, that the model lacks an effect; of a wanted motion, how near the leg comes.

A designed leg is fitted to a motion that another leg made. What it misses is due to its own links and dampers, and not
to what the model of the recorded leg lacks: the fit to the recordings themselves tells that.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from synth.arrays import Array, Mask
from synth.fit.fit_options import LegFitOptions
from synth.fit.ridge import MISFIT
from synth.remarks import at_joint
from synth.units import significant

# The samples' scatter is that about a smooth curve, which follows what lasts: it is no noise in a residual alone.
LASTING_NOISE = "its readings err alike for several samples, as those of a marker on skin or behind a filter do"
LEAST_MISFIT = np.radians(0.3)  # smallest reported misfit: a few counts of a coarse encoder


def follower(options: LegFitOptions) -> str:
    """The leg that follows a wanted motion, in words; empty for a fit to recordings."""
    if not options.wanted:
        return ""
    if options.curves:
        return "the robot's leg with the torque-speed curves of the chosen dampers"
    return "the robot's leg, with its links, gravity and any linear dampers,"


def lacking(clipped: Array, scatter: Array) -> Mask:
    """(n,) whether the fit does not explain a joint's motion; truncated RMS and samples' scatter (n,) rad.

    Truncated, so that a glitch alone does not count.
    """
    return np.asarray(clipped > np.maximum(MISFIT * scatter, LEAST_MISFIT))


def misfits(rms: Mapping[str, float], scatter: Mapping[str, float], lacks: Mask, options: LegFitOptions) -> list[str]:
    """Sentences on the joints that ``lacks`` (n,) marks; plain RMS and samples' scatter in rad."""
    leg, found = follower(options), list[str]()
    for (name, left), unexplained in zip(rms.items(), lacks.tolist(), strict=True):
        if not unexplained:
            continue
        off, noise = (f"{significant(np.degrees(each), 2)} deg" for each in (left, scatter[name]))
        if leg:
            text = f"{leg} comes no nearer to the scaled motion than {off} RMS, of which {noise} are its noise"
            found.append(at_joint(name, text, "note"))
        else:
            text = f"the residual is {off}, the samples' scatter only {noise}: the model lacks an effect at this joint"
            found.append(at_joint(name, f"{text} or next to it, or {LASTING_NOISE}"))
    return found
