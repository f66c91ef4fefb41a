"""What a user states of the rates (priors, static points), weighed against links that are not known exactly.

A fit weighs all that it is told by the sensor's noise, with the links as stated. Against noise a prior of 0.5 % is
nothing, but against links of 2 % it is most of what is known: free swings tell rates over inertia alone, so the prior
tells the links too. Both sources are put together once more with the links' parameters as unknowns with their
tolerance, in one linear step from the fit.

Of the trials only their estimate of the rates and its change with the links is used, not what their residuals may tell
of the links: that would trust the model to the noise. With f the information of a source, G its gradient's change with
a parameter of deviation 1 and g its gradient, the source's own information on the links is then G^T f^+ G and its
gradient G^T f^+ g (the best that its estimate can follow). Without a second source the result is that of the
consider covariance (``estimation.consider``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from synth.arrays import Array
from synth.estimation.consider import Considered
from synth.estimation.intervals import covariance_of
from synth.files.static_points_file import StaticPoint
from synth.fit.fit_problem import unknowns_of
from synth.fit.least_squares import Stage
from synth.fit.link_errors import WORDS, LinkErrors, gradient_by_links, link_errors, moved_leg
from synth.fit.model_error import ModelError
from synth.fit.recordings import Recording
from synth.fit.trajectories import TrajectoryModel
from synth.fit.unknowns import SpringsAndDampers
from synth.remarks import decisive, noted
from synth.swing.leg_model import Leg

# Deviations of both together, beyond which what is stated and what the trials tell contradict each other: one in 370.
CONTRADICTION = 3.0
# Of the deviation that the links leave to a rate, below which what is stated tells the scale of masses and rates.
TELLS_SCALE = 0.5
LEAST_MOVE, MOVES_TOLD = 0.2, 3  # deviations from which a moved link is told, and how many of them


@dataclass(frozen=True)
class StatedKnowledge:
    """What is known with what is stated.

    ``leg`` : the given one with the links and motors that suit both sources best. ``values`` (p,) of the unknowns;
    ``noise`` (p, p) their covariance but for the links' errors, which change them by ``by_links`` (p, c) a deviation.
    ``tells_scale`` : of masses and rates. ``sentences`` on contradictions, and on the moved links.
    """

    leg: Leg
    values: Array
    noise: Array
    by_links: Array
    tells_scale: bool
    sentences: tuple[str, ...] = ()


class BesideTrials(Protocol):
    """What a fit knows beside its trials; ``error`` of its law."""

    @property
    def stated(self) -> StatedKnowledge | None:
        """Priors and static points."""

    @property
    def error(self) -> ModelError | None:
        """Of the model."""


def stated_knowledge(
    leg: Leg,
    model: TrajectoryModel,
    recordings: Sequence[Recording],
    stage: Stage,
    widths: Array,
    static: Sequence[StaticPoint] = (),
) -> StatedKnowledge | None:
    """Priors and static points weighed beside the links; None without these, or if links are exact.

    Parameters
    ----------
    leg : as given; of ``model`` without springs.
    widths : (9, n) as in ``link_errors``; static : the fit's static points.
    """
    unknowns = unknowns_of(model)
    if not unknowns.beliefs and not static:
        return None
    links = link_errors(model, recordings, stage, widths, static)
    if links is None:
        return None
    values, whole = stage.solution.values, stage.solution.information.schur()
    spread = stage.weights.points
    gradient, stated = _stated(unknowns, values, spread)
    coupled = -whole @ links.considered.sensitivity
    beside = gradient_by_links(model, values, widths, static, spread) if static else np.zeros_like(coupled)
    # The fit is at a minimum: the gradient by the trials is that by what is stated, with the other sign.
    of_trials = _on_links(whole - stated, coupled - beside, -gradient)
    of_stated = _on_links(stated, beside, gradient)
    p = len(values)
    joint = np.block([[whole, coupled], [coupled.T, of_trials[0] + of_stated[0] + np.eye(coupled.shape[1])]])
    both = covariance_of(joint)
    step = -both @ np.concatenate([np.zeros(p), of_trials[1] + of_stated[1]])
    by_links = both[:p, p:]
    open_ = np.diag(links.covariance)
    told = [place for place, _, _ in unknowns.beliefs if unknowns.logarithmic[place]]
    return StatedKnowledge(
        moved_leg(leg, widths, step[p:], recordings),
        np.clip(values + step[:p], unknowns.lower, unknowns.upper),
        both[:p, :p] - by_links @ by_links.T,
        by_links,
        any(both[k, k] < TELLS_SCALE**2 * open_[k] for k in told),
        (*_contradictions(unknowns, values, links, whole - stated), *_moved_sentence(links, step[p:])),
    )


def with_stated(
    known: BesideTrials, noise: tuple[Array, Array], links: LinkErrors | None
) -> tuple[Array, LinkErrors | None]:
    """Covariance (p, p) of the noise and the links' errors with what is stated, and with a law that follows links.

    ``noise`` : two covariances (p, p), the one found, and that of white noise alone.
    """
    (found, white), error = noise, known.error
    if known.stated is not None and links is not None:
        # What the noise is beyond white noise is taken as it is without the prior: the prior only reduces it.
        more = np.maximum(np.diag(found) - np.diag(white), 0.0)
        found, links = known.stated.noise + np.diag(more), replace(links, considered=Considered(known.stated.by_links))
    if links is None or error is None or error.by_links is None or not error.by_links.size:
        return found, links
    return found, replace(links, considered=Considered(links.considered.sensitivity + error.by_links))


def _stated(unknowns: SpringsAndDampers, values: Array, spread: Array | None) -> tuple[Array, Array]:
    """Gradient (p,) and information (p, p) of priors and static points; ``spread`` (n,) rad of their free angles."""
    gradient, information = np.zeros(len(values)), np.zeros((len(values), len(values)))
    for place, mean, precision in unknowns.beliefs:
        gradient[place] += precision * (values[place] - mean)
        information[place, place] += precision
    measured = unknowns.measured(values, spread)
    if measured is not None:
        gradient, information = gradient + measured[1], information + measured[2]
    return gradient, information


def _on_links(information: Array, coupled: Array, gradient: Array) -> tuple[Array, Array]:
    """Information (c, c) and gradient (c,) that a source has of the links, through its estimate of the unknowns."""
    followed = coupled.T @ np.linalg.pinv(information, rcond=1e-10, hermitian=True)
    return followed @ coupled, followed @ gradient


def _moved_sentence(links: LinkErrors, moved: Array) -> list[str]:
    """What of the links is taken otherwise than stated; ``moved`` (c,) in deviations."""
    order = [int(k) for k in np.argsort(-np.abs(moved)) if abs(moved[k]) > LEAST_MOVE]
    if not order:
        return []
    named = []
    for k in order[:MOVES_TOLD]:
        joint, quantity = links.names[k]
        named.append(f"{WORDS[quantity].format(joint)} {np.expm1(moved[k] * links.deviation[k]):+.2%}")
    more = f" and {len(order) - MOVES_TOLD} more" if len(order) > MOVES_TOLD else ""
    told = ", ".join(named) + more
    return [
        noted(f"what is stated of springs and dampers agrees with the trials for these links, which are taken: {told}")
    ]


def _contradictions(
    unknowns: SpringsAndDampers, values: Array, links: LinkErrors, information: Array
) -> tuple[str, ...]:
    """Priors that the trials contradict, by more than both and the links' tolerances allow.

    ``information`` (p, p) of the trials alone.
    """
    noise, said = np.diag(covariance_of(information)), []
    variance = noise + np.diag(links.covariance)
    for place, mean, precision in unknowns.beliefs:
        off = (1.0 + noise[place] * precision) * (values[place] - mean)  # of the trials alone
        times = abs(off) / np.sqrt(variance[place] + 1.0 / precision)
        if times > CONTRADICTION:
            quantity, joint = unknowns.names[place].split(" ", 1)
            if unknowns.logarithmic[place]:
                apart = f"{100.0 * abs(np.expm1(off)):.2g} % {'above' if off > 0.0 else 'below'}"
            else:  # the sense of a rotation is not that of the measured angle
                apart = f"{abs(np.degrees(off)):.2g} deg from"
            text = f"{joint}: the trials find a {quantity.replace('_', ' ')} {apart} the stated one, {times:.2g}"
            remedy = "Look whether the stated value, the masses or the tolerances are wrong."
            text += " deviations of the prior, the noise and the links' tolerances together"
            said.append(decisive(text, remedy))
    return tuple(said)
