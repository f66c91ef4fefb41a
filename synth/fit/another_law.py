"""Dry friction, quadratic damping or a spring that is not linear, where the linear leg does not explain a motion.

A joint that rubs is the most usual leg with another law. Fitted without it, the first samples and the later ones ask
for different rates, as if a hand acted at first, and a spring on the ridge of an overdamped joint comes out at a
multiple of its rate. A search (``law_search``) begins at the fit without the law; unless that explains the motion, one
begins at the weak form with it (``law_start``); not for a spring, whose law bends the motion smoothly.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from synth.arrays import Array
from synth.fit.fit_options import LegFitOptions
from synth.fit.joint_laws import LAWS, AnotherLaw, JointLaw
from synth.fit.law_search import LawPoint, LawSearch
from synth.fit.law_start import law_starts
from synth.fit.least_squares import Stage
from synth.fit.recordings import Recording
from synth.fit.uncertainty import clipped_rms
from synth.swing.chain import compiled_chain
from synth.swing.leg_model import Leg

SUSPECT_RESIDUALS = 1.15  # times the samples' scatter, a joint's residuals from which a law is looked for
# Of searches from the weak form, each with the noise that the last left: a fit far off takes its error for noise, and
# ends where that hides the rest.
ROUNDS = 3
QUIETER_NOISE = 0.7  # of the noise, above which there is no further round
# Share of the error that the weak form's law leaves, above which it is none. The right law leaves little; a hand's
# torque is none of speed, and remains. A choice between the two (``make laws``).
HOPEFUL_RESIDUE = 0.5
SAMPLES = 400  # of a trial that are used
TRIALS = 6


def law_suspected(recordings: Sequence[Recording], stage: Stage, scatter: Array) -> bool:
    """Whether some joint's residuals are larger than the samples' ``scatter`` (n,) rad."""
    return bool(np.any(clipped_rms(recordings, stage.solution.predictions) > SUSPECT_RESIDUALS * scatter))


def another_law(
    leg: Leg, recordings: Sequence[Recording], stage: Stage, options: LegFitOptions, scatter: Array
) -> AnotherLaw | None:
    """The law that explains most of what the fit ``stage`` leaves above the samples' ``scatter`` (n,) rad, if any does.

    Only one that is ``named`` explains enough to be part of the leg. None too for a leg whose file states an effect,
    and for trials with legs of their own.
    """
    if any(joint.effects for joint in leg.joints) or any(recording.leg is not None for recording in recordings):
        return None
    compiled_chain(len(leg.joints)).load_laws()
    some, every = searched_recordings(recordings), _stride(recordings)
    weights = replace(stage.weights, noise=stage.weights.noise[::every], centre=None)
    of_some = Stage(replace(stage.solution, locals=stage.solution.locals[::every]), weights)
    found = [_best_search(law, leg, some, options, of_some, scatter) for law in LAWS]
    return min((each for each in found if each is not None), key=lambda each: (not each.named, each.left), default=None)


def _best_search(
    law: JointLaw, leg: Leg, some: Sequence[Recording], options: LegFitOptions, stage: Stage, scatter: Array
) -> AnotherLaw | None:
    """The best end of searches from the fit ``stage`` without the law, and from the weak form with it."""
    search = LawSearch(law, leg, some, options, stage, scatter)
    linear = search.point(np.zeros(len(leg.joints)))
    if linear is None:
        return None
    best = search, search.descend(linear, first=True) or linear
    if not search.explained(best[1]) and not law.of_deflection:
        for size, begun in law_starts(law, leg, some, options, stage):
            search = LawSearch(law, leg, some, options, begun, scatter)
            here = search.point(size)
            if here is None or search.share(here, linear) > HOPEFUL_RESIDUE:
                break
            search, here = _in_rounds(search, here)
            if search.share(here, linear) < best[0].share(best[1], linear):
                best = search, here
            if search.explained(here):
                break
    search, here = best
    polish = search.share(here, linear) <= law.residue and not search.explained(here)
    return search.law_at(search.polish(here) if polish else here, linear)


def _in_rounds(search: LawSearch, here: LawPoint) -> tuple[LawSearch, LawPoint]:
    """The end of a search, each round with the noise that the last left."""
    for _ in range(ROUNDS):
        here = search.descend(here) or here
        stage = search.refit_at(here)
        if not np.isfinite(stage.solution.cost) or np.all(stage.weights.noise > QUIETER_NOISE * search.weights.noise):
            break
        further = search.at(stage)
        again = further.point(here.size)
        if again is None:
            break
        search, here = further, again
    return search, here


def searched_recordings(recordings: Sequence[Recording]) -> list[Recording]:
    """Those in which a law is sought, thinned: as many as determine it."""
    return [recording.thinned(SAMPLES) for recording in recordings[:: _stride(recordings)]]


def _stride(recordings: Sequence[Recording]) -> int:
    return max(1, -(-len(recordings) // TRIALS))
