"""From costs to odds and a verdict: which cause, none, several that cannot be told apart, or none that is known."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Generic

import numpy as np

from synth.arrays import Array
from synth.diagnosis.diagnosis_result import Verdict
from synth.diagnosis.hypotheses import Assessed, F, HeldOutError, Hypotheses, Key
from synth.diagnosis.odds import CALIBRATED as CALIBRATED
from synth.diagnosis.odds import Calibration as Calibration
from synth.diagnosis.odds import far_share, taken, taken_of
from synth.diagnosis.odds import weigh as weigh

LEAST_SHARE = 0.1  # of the whole gap (RMS) that one cause more must take to be named: less does not matter to a user
MOST_SCATTER = 1 / 3  # of the gap, that a scatter of the remainder from trial to trial may excuse
COUNTS = 0.95  # probability of coarse counts that show; not tuned


@dataclass(frozen=True)
class Judged(Generic[F]):
    """Verdict, the hypothesis accepted (no causes for none), the others it is tied with, and all odds.

    ``singles`` : (assessed, probability) in order of probability; with ``none`` and ``unknown`` they sum to 1, unless
    the accepted hypothesis has several causes.
    """

    verdict: Verdict
    accepted: Assessed[F]
    tied: tuple[Assessed[F], ...]
    singles: tuple[tuple[Assessed[F], float], ...]
    none: float
    unknown: float
    weighed: tuple[tuple[Assessed[F], float], ...] = ()  # every hypothesis with its weight, heaviest first
    counts: float = 0.0  # probability that coarse counts are a cause

    def share(self, key: Key) -> float:
        """Probability that a cause is there, alone or as one of several."""
        return (1.0 - self.unknown) * sum(weight for item, weight in self.weighed if key in item.keys)

    @property
    def probability(self) -> float:
        """Of the first cause."""
        return max([self.counts, *(p for _, p in self.singles[:1])])


def paying(hypotheses: Sequence[Assessed[F]], share: float, least: float = LEAST_SHARE) -> list[Assessed[F]]:
    """Those of several causes only that leave clearly less than the best of fewer causes does.

    One cause more must take ``share`` of the squared error above the noise that fewer leave, and ``least`` of the whole
    gap, on unseen trials where these are known: near the noise a share of what is left is next to nothing.
    """
    none = next((h for h in hypotheses if not h.keys), None)
    gap = _above(none) if none is not None else 0.0
    kept = []
    for hypothesis in hypotheses:
        fewer = [h for h in hypotheses if 0 < len(h.keys) < len(hypothesis.keys)]
        if len(hypothesis.keys) < 2 or not fewer:
            kept.append(hypothesis)
            continue
        left, before = _above(hypothesis), min(map(_above, fewer))
        known = [h for h in fewer if h.unseen is not None]
        takes = (before - left) / gap if gap > 0.0 else 1.0
        if none is not None and none.unseen is not None and known:
            if hypothesis.unseen is None:
                continue
            takes = taken(hypothesis, none) - max(taken(h, none) for h in known)
        if left**2 <= (1.0 - share) * before**2 and takes >= least:
            kept.append(hypothesis)
    return kept


def _above(found: Assessed[F]) -> float:
    """RMS error above the noise, in noise floors."""
    return float(np.sqrt(max(found.ratio**2 - 1.0, 0.0)))


def judge(
    found: Hypotheses[F], calibration: Calibration = CALIBRATED, singles: int = 0, free: HeldOutError | None = None
) -> Judged[F]:
    """Weigh all hypotheses; ``singles`` as in ``weigh``; ``free`` : what a torque of free shape leaves unseen.

    Where one cause explains the trials, a cause's probability is the weight of itself alone and its share of every set
    that it is part of, by what it does there: they sum to at most 1. Where it takes several, it is the weight of all
    sets that it is part of: each of two may have all that the doubt of several leaves.
    """
    hypotheses = paying([found.none, *found.singles, *found.several], calibration.pays)
    raw = weigh(hypotheses, calibration, singles)
    weights = _worth(hypotheses, raw)
    heaviest = int(np.argmax(weights))
    best = hypotheses[heaviest]
    unknown = _unknown(found.none, best, calibration)
    doubt = calibration.doubt if len(best.keys) < 2 else calibration.doubt_of_several
    far = far_share(hypotheses)
    if far > 0.0:
        missing = _unknown_far(hypotheses, weights, free, calibration)
        unknown = (1.0 - far) * unknown + far * missing
        doubt = (1.0 - far) * doubt + far * max(doubt, calibration.doubt_far)
    if best.keys:
        unknown = 1.0 - (1.0 - unknown) * (1.0 - doubt)
    by_key: dict[Key, float] = {}
    costs = {frozenset(hypothesis.keys): hypothesis.cost for hypothesis in hypotheses}
    for hypothesis, weight in zip(hypotheses[1:], weights[1:], strict=True):
        shares = _credit(hypothesis, costs) if len(best.keys) < 2 else dict.fromkeys(hypothesis.keys, 1.0)
        for key, share in shares.items():
            by_key[key] = by_key.get(key, 0.0) + float(weight) * share
    ranked = sorted(
        ((single, by_key.get(single.keys[0], 0.0) * (1.0 - unknown)) for single in found.singles),
        key=lambda item: (-item[1], item[0].cost),
    )
    none = float(weights[0]) * (1.0 - unknown)
    verdict, tied = _verdict(hypotheses, weights, heaviest, unknown, calibration)
    if verdict == "unknown" and not best.keys and len(hypotheses) > 1:  # what comes nearest is shown
        best = hypotheses[1 + int(np.argmax(raw[1:]))]
    weighed = sorted(zip(hypotheses, weights.tolist(), strict=True), key=lambda item: -item[1])
    return Judged(verdict, best, tied, tuple(ranked), none, unknown, tuple(weighed))


def _worth(hypotheses: Sequence[Assessed[F]], weights: Array) -> Array:
    """The weights; far from the noise, what takes too little of the gap unseen speaks for none."""
    far = far_share(hypotheses)
    if far == 0.0 or hypotheses[0].keys:
        return weights
    least = _least(hypotheses)
    little = np.array([bool(h.keys) and taken(h, hypotheses[0]) < least for h in hypotheses])
    kept = weights * np.where(little, 1.0 - far, 1.0)
    kept[0] += weights.sum() - kept.sum()
    return np.asarray(kept)


def _least(hypotheses: Sequence[Assessed[F]]) -> float:
    """Share of the gap that a cause must take on unseen trials: more than the remainder scatters from trial to trial.

    What takes less is how trials differ, not what they lack; a third of the gap is more than that in any case.
    """
    best = min((h.unseen for h in hypotheses if h.unseen is not None), key=lambda unseen: unseen.typical)
    scatter = float(np.std(0.5 * np.log(np.maximum(best.by_trial, 1e-9)), ddof=1))
    return float(np.clip(scatter, LEAST_SHARE, MOST_SCATTER))


def _unknown_far(
    hypotheses: Sequence[Assessed[F]], weights: Array, free: HeldOutError | None, calibration: Calibration
) -> float:
    """Probability that what is missing is in no list, where the remainder is far above the noise.

    The heaviest explanation takes too little of what is missing, or a torque of free shape takes much more. Where
    neither takes more than trials scatter by, nothing is known to be missing: so near a model of this kind comes.
    """
    none, best = hypotheses[0], hypotheses[int(np.argmax(weights))]
    takes = taken(best, none) if best.keys else 0.0
    freely = taken_of(free, none.unseen) if free is not None and none.unseen is not None else 0.0
    leads = max(freely - takes - calibration.free_leads, 0.0)
    telling = float(np.clip((freely - _least(hypotheses)) / calibration.free_leads, 0.0, 1.0))
    missing = max(1.0 - float(weights[0]), telling)
    short = calibration.steep * (calibration.most - takes + leads)
    return missing / (1.0 + float(np.exp(-short)))


def _credit(found: Assessed[F], costs: Mapping[frozenset[Key], float]) -> dict[Key, float]:
    """What each cause of a hypothesis does for it: by how much the cost of the best without it is higher."""
    gains = {}
    for key in found.keys:
        rest = frozenset(found.keys) - {key}
        without = min(cost for keys, cost in costs.items() if keys <= rest)
        gains[key] = max(without - found.cost, 0.0)
    total = sum(gains.values())
    return {key: gain / total if total > 0.0 else 1.0 / len(gains) for key, gain in gains.items()}


def with_counts(judged: Judged[F], coarse: bool) -> Judged[F]:
    """The verdict with coarse counts as a cause: they are seen in the readings themselves.

    Beside another cause they take nothing from its odds: both are there.
    """
    if not coarse:
        return judged
    if judged.verdict != "none":
        return replace(judged, none=judged.none * (1.0 - COUNTS), counts=COUNTS)
    singles = tuple((item, probability * (1.0 - COUNTS)) for item, probability in judged.singles)
    none, unknown = judged.none * (1.0 - COUNTS), judged.unknown * (1.0 - COUNTS)
    return replace(judged, verdict="effect", singles=singles, none=none, unknown=unknown, counts=COUNTS)


def of_no_account(judged: Judged[F], none: Assessed[F]) -> Judged[F]:
    """The verdict where the gap is smaller than what matters to the user: nothing is missing."""
    singles = tuple((item, 0.0) for item, _ in judged.singles)
    return replace(judged, verdict="none", accepted=none, tied=(), singles=singles, none=1.0, unknown=0.0)


def open_explanations(judged: Judged[F]) -> list[tuple[F, float]]:
    """Fits that a further trial is to separate, with their weights; at least the two heaviest."""
    chosen = [(item.fit, weight) for item, weight in judged.weighed[:6]]
    near = [(judged.accepted.fit, 1.0), *[(rival.fit, 1.0) for rival in judged.tied]]
    return near if judged.verdict == "tie" else chosen


def _unknown(none: Assessed[F], best: Assessed[F], calibration: Calibration) -> float:
    """Probability that what is missing is in no list: by the share of the gap that the best explanation leaves."""
    gap = max(none.ratio**2 - 1.0, 1e-9)
    left = max(best.ratio**2 - calibration.clean**2, 0.0) / gap
    if left <= 0.0 or none.ratio < calibration.clean:
        return 0.0
    allowed = calibration.left if len(best.keys) < 2 else calibration.left_by_several
    allowed *= min(1.0, calibration.far / best.ratio) ** 0.5
    return float(1.0 / (1.0 + np.exp(-calibration.misfit * np.log(left / allowed))))


def _verdict(
    hypotheses: Sequence[Assessed[F]], weights: Array, heaviest: int, unknown: float, calibration: Calibration
) -> tuple[Verdict, tuple[Assessed[F], ...]]:
    if unknown > 0.5:
        return "unknown", ()
    best = hypotheses[heaviest]
    if not best.keys:
        return "none", ()
    size = len(best.keys)
    rivals = [(h, w) for h, w in zip(hypotheses, weights, strict=True) if h is not best and len(h.keys) == size]
    tied = tuple(h for h, w in rivals if w * calibration.tie_odds > weights[heaviest])
    return ("tie" if tied else "effect"), tied
