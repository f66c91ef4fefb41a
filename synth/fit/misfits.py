"""What a residual says: of recordings, that the model lacks an effect; of a wanted motion, how near the leg comes.

A designed leg is fitted to a motion that another leg made. What it misses is due to its own links and dampers, and not
to what the model of the recorded leg lacks: the fit to the recordings themselves tells that.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from synth.arrays import Array, Mask
from synth.fit.fit_options import LegFitOptions
from synth.fit.recordings import Recording
from synth.fit.ridge import MISFIT
from synth.remarks import Remark, at_joint
from synth.units import significant

# The samples' scatter is that about a smooth curve, which follows what lasts: it is no noise in a residual alone.
LASTING_NOISE = "its readings err alike for several samples, as those of a marker on skin or behind a filter do"
# Residuals over the samples' scatter, beyond which the model is in question, not how long its noise lasts: noise of
# 50 ms without a white part has 4.5 times its scatter at 200 Hz, 5.3 times at 500 Hz.
MOST_OF_NOISE = 6.0
# Of the motion's RMS, a residual from which the motion is not followed. What a lab's filter leaves of the noise
# scatters a thousandth of its size, but is 0.3 deg in motions of some 6 deg.
NOT_FOLLOWED = 0.1
# Kind of the remark that a designed leg makes another motion at a joint than the scaled one.
ANOTHER_MOTION = "another motion"
# Of such a misfit, of one joint, as for a built leg: below the 3 deg that a design is to keep, which are of all
# joints together.
LEAST_OTHER = np.radians(2.0)
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


def beyond_noise(recordings: Sequence[Recording], clipped: Array, scatter: Array) -> Mask:
    """(n,) whether no noise, however long it lasts, explains what the fit leaves of a joint; rad as in ``lacking``.

    Of 16 simulated legs of which a muscle drove one joint for longer than the release, that joint's free angle was
    outside its 90 % interval in 14.
    """
    counts = [recording.counts for recording in recordings]
    samples = np.maximum([each.sum(axis=0) for each in counts], 1)
    sums = [np.where(c, r.rotation, 0.0).sum(axis=0) for c, r in zip(counts, recordings, strict=True)]
    squares = [
        np.where(c, r.rotation - total / count, 0.0) ** 2
        for c, r, total, count in zip(counts, recordings, sums, samples, strict=True)
    ]
    motion = np.sqrt(np.concatenate(squares).sum(axis=0) / samples.sum(axis=0))
    return np.asarray((clipped > MOST_OF_NOISE * scatter) & (clipped > NOT_FOLLOWED * motion))


def misfits(
    rms: Mapping[str, float], scatter: Mapping[str, float], lacks: Mask, options: LegFitOptions, beyond: Mask
) -> list[str]:
    """Sentences on the joints that ``lacks`` (n,) marks; plain RMS and samples' scatter in rad.

    ``beyond`` (n,) : those whose misfit no noise explains, and of recordings none of the differences that intervals
    include.
    """
    leg, found = follower(options), list[str]()
    for (name, left), unexplained, wrong in zip(rms.items(), lacks.tolist(), beyond.tolist(), strict=True):
        if not unexplained:
            continue
        off, noise = (f"{significant(np.degrees(each), 2)} deg" for each in (left, scatter[name]))
        if leg and wrong and left > LEAST_OTHER:
            found.append(_another_motion(name, f"{leg} comes no nearer to the scaled motion than {off} RMS"))
        elif leg:
            text = f"{leg} comes no nearer to the scaled motion than {off} RMS, of which {noise} are its noise"
            found.append(at_joint(name, text, "note"))
        else:
            text = f"the residual is {off}, the samples' scatter only {noise}: the model lacks an effect at this joint"
            if wrong:
                text += (
                    " or next to it, and cannot follow this motion: the numbers here and at the joints beside it, with "
                )
                text += "their 90 % intervals, are not to be used before it is found (synth gap)"
                found.append(at_joint(name, text, "decide"))
            else:
                found.append(at_joint(name, f"{text} or next to it, or {LASTING_NOISE}"))
    return found


def _another_motion(joint: str, text: str) -> Remark:
    """That the leg does not make a joint's motion."""
    text = f"{joint}: {text}, more than a tenth of that motion: the motion that is wanted of its parts is another one"
    remedy = (
        "Compare both on the page. Another scale: {time: ...}, or other links of the target (length, mass, com), bring "
        "the robot's motion nearer."
    )
    return Remark(text, "decide", remedy, ANOTHER_MOTION, joint)
