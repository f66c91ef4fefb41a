"""The probability that an unknown cause is behind a gap: one that no effect of the library describes.

Near the noise it rests on the share of the gap that the best explanation leaves, far from it on what each explanation
removes from fitted and from unseen trials, and on what a free-form torque removes there.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synth.diagnosis.hypotheses import Assessment, F, TrialErrors
from synth.diagnosis.odds import (
    LEAST_FURTHER_SHARE,
    Calibration,
    far_share,
    share_removed,
    share_removed_between,
    share_removed_from_fitted,
)

MOST_SCATTER = 1 / 3  # of the gap, largest tolerance for the remainder's scatter between trials
CAUSES_OF_A_CURVE = 3  # causes of one spring or damper that together are any curve of it, see ``_is_curve``


def probability_of_unknown(
    hypotheses: Sequence[Assessment[F]],
    best: Assessment[F],
    unexplained: float,
    free: TrialErrors | None,
    calibration: Calibration,
) -> float:
    """The probability if ``best`` is accepted.

    ``hypotheses`` : none, then those that pay; ``unexplained`` : probability that an effect is missing at all; ``free``
    : the error of a free-form torque on unseen trials.
    """
    unknown = _unknown_near_noise(hypotheses[0], best, calibration)
    doubt = calibration.doubt if len(best.keys) < 2 else calibration.doubt_of_several
    far = far_share(hypotheses)
    if far > 0.0:
        missing, doubt_far = _unknown_far_from_noise(hypotheses, best, unexplained, free, calibration)
        unknown = (1.0 - far) * unknown + far * missing
        doubt = (1.0 - far) * doubt + far * doubt_far
    return 1.0 - (1.0 - unknown) * (1.0 - doubt) if best.keys else unknown


def _unknown_near_noise(none: Assessment[F], best: Assessment[F], calibration: Calibration) -> float:
    """Probability of an unknown cause, from the share of the gap that the best explanation leaves."""
    gap = max(none.ratio**2 - 1.0, 1e-9)
    left = max(best.ratio**2 - calibration.clean**2, 0.0) / gap
    if left <= 0.0 or none.ratio < calibration.clean:
        return 0.0
    allowed = calibration.left if len(best.keys) < 2 else calibration.left_by_several
    allowed *= min(1.0, calibration.far / best.ratio) ** 0.5
    return float(1.0 / (1.0 + np.exp(-calibration.misfit * np.log(left / allowed))))


def _unknown_far_from_noise(
    hypotheses: Sequence[Assessment[F]],
    best: Assessment[F],
    missing: float,
    free: TrialErrors | None,
    calibration: Calibration,
) -> tuple[float, float]:
    """Probability of an unknown cause, and its least value, if the remainder is far above the noise.

    High if no cause alone removes most of the gap and several do not either, if a free-form torque removes much more
    than they, or if the best explanation predicts trials no better that were left out of its fit. ``missing`` :
    probability that an effect is missing at all; it rises if a free-form torque removes more than the scatter between
    trials. The least value is ``_chance_of_contradiction``. What a cause does on trials left out is what it does in the
    best set with it: dry friction removed 4 % of the gap there alone, and 60 % beside a shifted reading. Several causes
    imitate an unknown one more easily, so they leave more doubt where no single one suffices.
    """
    none = hypotheses[0]

    def removed(h: Assessment[F]) -> float:
        return share_removed(h, none)

    shown = max((h for h in hypotheses if {*best.keys} <= {*h.keys} and h.unseen), key=removed, default=best)
    freely = share_removed_between(free, none.unseen) if free is not None and none.unseen is not None else 0.0
    leads = max(freely - (removed(shown) if best.keys else 0.0) - calibration.free_leads, 0.0)
    telling = float(np.clip((freely - least_removed_share(hypotheses)) / calibration.free_leads, 0.0, 1.0))
    missing = max(missing, telling)

    def short(items: Sequence[Assessment[F]], most: float) -> float:
        """Probability that an unknown cause is in what the best of these leaves."""
        share = max((share_removed_from_fitted(h, none) for h in items), default=0.0)
        return float(1.0 / (1.0 + np.exp(-calibration.steep * (most - share + leads))))

    # What predicts trials left out of its fit no better explains the others by chance, however well.
    fails = (
        float(1.0 / (1.0 + np.exp(calibration.steep * (removed(shown) - LEAST_FURTHER_SHARE)))) if best.keys else 0.0
    )
    doubt = _chance_of_contradiction(shown, none)
    alone = short([h for h in hypotheses if len(h.keys) == 1], calibration.most)
    if len(best.keys) < 2:
        return calibration.most_unknown * missing * max(alone, fails), doubt
    if _is_curve(best):
        return calibration.most_unknown * missing * max(alone, fails), max(doubt, calibration.doubt_of_several)
    together = short([h for h in hypotheses if len(h.keys) > 1], calibration.most_of_several)
    doubt += max(calibration.doubt_of_several - doubt, 0.0) * alone
    return calibration.most_unknown * missing * max(min(alone, together), fails), doubt


def _is_curve(best: Assessment[F]) -> bool:
    """Whether so many causes of one spring or damper are accepted that they describe any curve of its torque.

    A preload, a softer side and a hardening at one joint reproduce the torque of a magnet there. That the part has
    three defects at once is far less likely than one unknown torque in the joint.
    """
    parts = {(cause.part, cause.key[1]) for cause in best.fit.hypothesis}
    return len(best.keys) >= CAUSES_OF_A_CURVE and len(parts) == 1 and all(part for part, _ in parts)


def _chance_of_contradiction(best: Assessment[F], none: Assessment[F]) -> float:
    """Probability that a further window of a trial contradicts the explanation: that it errs more than without it.

    From the windows of unseen trials in which either errs by more than the explanation's typical remainder, with
    Jeffreys' prior (Krichevsky & Trofimov, IEEE Trans. Inf. Theory 27 (1981) 199).
    """
    if best.unseen is None or none.unseen is None:
        return 0.5
    with_it, without = best.unseen.squares, none.unseen.squares
    telling = np.maximum(with_it, without) > best.unseen.typical**2
    against = int(np.sum(telling & (with_it > without)))
    return float((against + 0.5) / (int(np.sum(telling)) + 1.0))


def least_removed_share(hypotheses: Sequence[Assessment[F]]) -> float:
    """Least share of the gap that a cause must remove: more than the remainder's scatter between trials.

    A smaller reduction is variation between trials, not a missing effect; a third of the gap always suffices.
    """
    best = min((h.unseen for h in hypotheses if h.unseen is not None), key=lambda unseen: unseen.typical)
    scatter = float(np.std(0.5 * np.log(np.maximum(best.by_trial, 1e-9)), ddof=1))
    return float(np.clip(scatter, LEAST_FURTHER_SHARE, MOST_SCATTER))


def probability_beyond_accuracy(share: float, calibration: Calibration) -> float:
    """Probability that a gap of this share of the motion is more than a model's accuracy."""
    return float(1.0 / (1.0 + (calibration.accuracy / max(share, 1e-12)) ** calibration.accuracy_steep))
