"""Causes of which none helps: at the noise nothing is missing, far from it no explanation is the nearest.

The odds weigh the tolerances too. Where the leg follows all trials with several of them moved by two deviations, each
cause that saves such moves is more probable, though no error falls by any. Those are no explanations of a gap, and no
tie: ``none`` is the verdict where nothing in the library helps on unseen trials (``../shared/FORMATS.md``). The
probabilities stay, so that what is said of it is that these trials cannot show whether an effect is missing.

Where the cause is unknown the nearest explanation is shown, by what it does to fitted and to unseen trials. One with
which unseen trials err more is no explanation, and what remains is what the nominal leg leaves: three causes together
left 7.3 deg of a gap of 3.1 deg of a driven pendulum, so that more remained than there was.
"""

from __future__ import annotations

from dataclasses import replace

from synth.diagnosis.hypotheses import Assessment
from synth.diagnosis.plant import F, Plant, S, T
from synth.diagnosis.prediction_error import AT_NOISE, LEAST_GAP, PredictionErrors, label_of_causes
from synth.diagnosis.verdict import Judgement

SURE_OF_CAUSE = 0.8  # probability from which the page calls a cause identified


def without_what_helps_not(
    judged: Judgement[F], none: Assessment[F], errors: PredictionErrors, plant: Plant[F, T, S]
) -> Judgement[F]:
    """The verdict without causes, or a nearest explanation, that reduce no error; arguments as below."""
    return without_nearest_of_no_help(without_causes_of_no_help(judged, none, errors, plant), none, errors)


def without_causes_of_no_help(
    judged: Judgement[F], none: Assessment[F], errors: PredictionErrors, plant: Plant[F, T, S]
) -> Judgement[F]:
    """The verdict; ``none`` in the place of causes that reduce the error neither of scored trials nor of fitted ones.

    Only at the noise. An effect that is sure stays: the tolerances that the leg would need without it are hardly
    true, and it is told as an error of the design. ``errors`` : of the scored trials, with those of all tied causes.
    """
    named = (judged.accepted, *judged.tied)
    if judged.verdict not in ("effect", "tie") or judged.counts > 0.0 or not judged.accepted.keys:
        return judged
    probability = judged.probability if len(judged.accepted.keys) == 1 else 1.0 - judged.none - judged.unknown
    if judged.verdict == "effect" and probability >= SURE_OF_CAUSE:
        return judged
    if errors.figure("before").value > AT_NOISE * errors.floor.value:
        return judged
    if any(_helps_on_scored(item, errors) or _helps_on_fitted(item, none, plant) for item in named):
        return judged
    return replace(judged, verdict="none", accepted=none, tied=())


def without_nearest_of_no_help(judged: Judgement[F], none: Assessment[F], errors: PredictionErrors) -> Judgement[F]:
    """The verdict; where the cause is unknown, ``none`` in the place of causes with which scored trials err no less."""
    if judged.verdict != "unknown" or errors.figure("after").value < errors.figure("before").value:
        return judged
    return replace(judged, accepted=none) if judged.accepted.keys else judged


def _helps_on_scored(item: Assessment[F], errors: PredictionErrors) -> bool:
    """Whether the squared error falls by more than the least gap that has a meaningful share."""
    label = label_of_causes(item.keys)
    after = errors.squares[label if label in errors.squares else "after"]
    return float((errors.squares["before"] - after).sum()) > LEAST_GAP * float(errors.noise.sum())


def _helps_on_fitted(item: Assessment[F], none: Assessment[F], plant: Plant[F, T, S]) -> bool:
    """Whether the log-likelihood of the readings alone rises by more than the price of the cause's numbers."""
    misfits = [each.cost - plant.prior_cost(each.fit) for each in (none, item)]
    return misfits[0] - misfits[1] > plant.calibration.per_parameter * item.n_unknown
