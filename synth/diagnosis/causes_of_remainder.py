"""What takes the remainder of an explanation but too little of the gap to be named, and what it does to the named.

A further cause is named where it takes a tenth of the gap. A smaller one still pulls on the named cause's numbers where
the tolerances end: beside a torque column scaled by 12 % a damper 3.3 tolerances off leaves 1.4 noise floors, and the
scale at 9.9 %, because a tolerance gives way to ``LARGEST_TOLERANCE`` only. The fit's own interval does not know that.
The sets with such a cause do: the numbers lie between theirs and the fit's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Generic

from synth.diagnosis.cause_intervals import causes_of
from synth.diagnosis.diagnosis_result import Cause
from synth.diagnosis.hypotheses import Assessment, Hypotheses
from synth.diagnosis.odds import LEAST_FURTHER_SHARE, posterior_weights
from synth.diagnosis.plant import F, Plant, S, T
from synth.diagnosis.prediction_error import PredictionErrors, label_of_causes
from synth.diagnosis.unseen_predictions import predict_unseen
from synth.diagnosis.verdict import Calibration
from synth.estimation.intervals import Estimate

MOST_SETS = 3  # with a further cause, that are predicted


@dataclass(frozen=True)
class BesideFurtherCause(Generic[F]):
    """A hypothesis with a further cause; ``left`` : what it leaves of the scored trials above the noise, RMS.

    ``little`` : the cause takes less of the gap than a cause must to be named.
    """

    item: Assessment[F]
    left: Estimate
    little: bool


def beside_further_causes(
    plant: Plant[F, T, S], found: Hypotheses[F], item: Assessment[F], errors: PredictionErrors
) -> tuple[BesideFurtherCause[F], ...]:
    """The hypothesis beside each further cause that takes most of what it leaves, the most probable first.

    Of the fitted trials most by the rule for a cause that pays, and some of the scored ones. ``errors`` : of these,
    with the hypothesis.
    """
    if not item.keys:
        return ()
    label = label_of_causes(item.keys)
    label = label if label in errors.squares else "after"
    made = []
    for more in _more_probable_sets(found, item, plant.calibration)[:MOST_SETS]:
        own = label_of_causes(more.keys)
        squares = {**errors.squares, own: plant.squares(plant.as_read(predict_unseen(plant, more)))}
        if squares[own].sum() < squares[label].sum():
            with_it = replace(errors, squares=squares)
            gained = with_it.shrink(own).value - with_it.shrink(label).value
            made.append(BesideFurtherCause(more, with_it.above_noise(own), gained < LEAST_FURTHER_SHARE))
    return tuple(made)


def _more_probable_sets(found: Hypotheses[F], item: Assessment[F], calibration: Calibration) -> list[Assessment[F]]:
    """The sets that contain a hypothesis, pay beside it and have better odds; those tied with the best of them."""
    paid = [
        more
        for more in found.several
        if {*item.keys} < {*more.keys} and more.above**2 < (1.0 - calibration.pays) * item.above**2
    ]
    if not paid:
        return []
    weights = posterior_weights([found.none, item, *paid], calibration, len(found.singles))[1:]
    least = max(float(weights[0]), float(weights[1:].max()) / calibration.tie_odds)
    order = sorted(zip(weights[1:].tolist(), paid, strict=True), key=lambda each: -each[0])
    return [more for weight, more in order if weight > least]


def causes_beside(
    plant: Plant[F, T, S], item: Assessment[F], beside: Sequence[BesideFurtherCause[F]]
) -> tuple[Cause, ...]:
    """The causes of a hypothesis; each interval reaches those of the same parameter beside further causes."""
    known = [{(each.effect, each.joint): each for each in causes_of(plant, more.item)} for more in beside]
    return tuple(
        replace(cause, parameters={name: _reaching(name, cause, known) for name in cause.parameters})
        for cause in causes_of(plant, item)
    )


def _reaching(name: str, cause: Cause, known: Sequence[dict[tuple[str, str], Cause]]) -> Estimate:
    """The parameter's estimate, its interval as wide as those of the same one in the ``known`` causes as well."""
    own = cause.parameters[name]
    others = [causes[cause.effect, cause.joint].parameters.get(name, own) for causes in known]
    lows, highs = [e.low for e in (own, *others)], [e.high for e in (own, *others)]
    if own.low is None or own.high is None:
        return own
    low, high = (pick(end for end in ends if end is not None) for pick, ends in ((min, lows), (max, highs)))
    return replace(own, low=low, high=high)
