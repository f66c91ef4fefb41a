"""From costs to odds and a verdict: a cause, none, tied causes, or unknown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Generic

import numpy as np

from synth.arrays import Array
from synth.diagnosis.diagnosis_result import Verdict
from synth.diagnosis.hypotheses import Assessment, F, Hypotheses, Key, TrialErrors
from synth.diagnosis.odds import (
    BOOTSTRAP_DRAWS,
    LEAST_FURTHER_SHARE,
    costs_against,
    far_share,
    posterior_weights_beside,
    share_removed,
    share_removed_from_fitted,
    unknowns_and_states,
)
from synth.diagnosis.odds import CALIBRATED as CALIBRATED
from synth.diagnosis.odds import Calibration as Calibration
from synth.diagnosis.odds import posterior_weights as posterior_weights
from synth.diagnosis.unknown_cause import least_removed_share, probability_beyond_accuracy, probability_of_unknown
from synth.estimation.information import LEAST_WEIGHT

# Of the whole gap, that one of several causes takes which cannot be told apart: it is not named.
LITTLE_SHARE = 1.0 / 6.0
# Share of its weight that a cause keeps which removes too little: most such causes only follow another's form error.
# Decided by ``make blind-rigs``.
WEIGHT_OF_LITTLE = 0.2
# Times what a set of causes leaves, up to which one that differs in a single cause is its rival. Latency and a delay
# of the torque act alike on a single joint: rounding must not decide which of them is weighed at all.
RIVAL_RATIO = 1.05
# So many rivals of the first explanation, or more, are no tie if that is less probable than an unknown cause: where
# nearly every cause fits as badly (one motion that turns the other way), a list of them tells nothing.
MOST_TIED = 6
# Where a model's own error shows, from this share of the way from the noise, more causes than two are kept only if they
# are all at one joint, or take nearly all of the gap, or one of them alone takes half of it. Otherwise nothing
# dominates, and small causes of every kind follow that error: on 40 dirty rigs without a main cause six of seven
# explanations with a cause that was not there were of three, which took 70 to 93 % (``make blind-rigs``, seed 5050).
FEW, FROM_NOISE, MOST_OF_MANY, DOMINATES = 2, 0.25, 0.95, 0.5
# Difference of two weights that lies within the standard error of the bootstrap's draws where each draw has one of them
# alone: the difference is then 1 or -1 in a draw. Of one weight, 0 or 1, it would be half of that.
UNRESOLVED = 1.0 / BOOTSTRAP_DRAWS**0.5
PROBABILITY_OF_COUNTS = 0.95  # probability of visible coarse counts; not tuned
# Probability of an unknown cause if held-out trials surely contradict the explanation: a choice.
UNKNOWN_IF_CONTRADICTED = 0.9


@dataclass(frozen=True)
class Judgement(Generic[F]):
    """Verdict, accepted hypothesis (without causes for none), tied hypotheses, and all odds.

    ``singles`` : (assessed, probability) in order of probability; with ``none`` and ``unknown`` they sum to 1, unless
    the accepted hypothesis has several causes.
    """

    verdict: Verdict
    accepted: Assessment[F]
    tied: tuple[Assessment[F], ...]
    singles: tuple[tuple[Assessment[F], float], ...]
    none: float
    unknown: float
    weighed: tuple[tuple[Assessment[F], float], ...] = ()  # every hypothesis with its weight, largest first
    counts: float = 0.0  # probability that coarse counts are a cause

    def share(self, key: Key) -> float:
        """Probability that a cause is present, alone or among several."""
        return (1.0 - self.unknown) * sum(weight for item, weight in self.weighed if key in item.keys)

    def in_order(self, probability: Mapping[Key, float]) -> list[Key]:
        """Causes with these probabilities, most probable first.

        Each of several accepted causes has the probability of the set; the most effective one comes first.
        """
        cost = {item.keys[0]: item.cost for item, _ in self.singles}
        together = {*self.accepted.keys} if len(self.accepted.keys) > 1 else set()
        highest = max((probability[key] for key in together if key in probability), default=0.0)

        def place(key: Key) -> tuple[float, float]:
            return (-highest, cost.get(key, np.inf)) if key in together else (-probability[key], 0.0)

        return sorted(probability, key=place)

    @property
    def probability(self) -> float:
        """Probability of the first cause."""
        return max([self.counts, *(p for _, p in self.singles[:1])])


def hypotheses_that_pay(hypotheses: Sequence[Assessment[F]], calibration: Calibration) -> list[Assessment[F]]:
    """Those hypotheses of several causes that clearly improve on the best of fewer causes.

    A set must leave less than any of fewer causes, by ``pays`` of the squared error above the noise, and each of its
    causes must remove ``LEAST_FURTHER_SHARE`` of the whole gap beside the others. So two causes may replace a third
    that imitates both but for a twentieth of the gap. The share is that of the fitted trials near the noise, and far
    from it that of unseen ones if available. A fold is often the only trial of its kind, such as the one log in which a
    servo reaches its current limit: without it the limit is not determined, and the fold's error tells nothing against
    it. Far from the noise more than two causes at several joints must take nearly all of the gap, or one of them most
    of it. A cause with more unknown numbers is not fewer there: a base that yields has initial states in each piece of
    a swing, and follows what two other causes do. A cause that is less probable than none, because of its own numbers,
    is no reason to distrust several: at the ends of its priors it imitates them. What leaves as much with another cause
    in place of one is kept too, as a rival.
    """
    none, far = next((h for h in hypotheses if not h.keys), None), far_share(hypotheses)
    gap = none.above if none is not None else 0.0
    sizes = unknowns_and_states(hypotheses) if far > 0.0 else [0] * len(hypotheses)
    likely = (
        _likelier_than_none(hypotheses, calibration) if far > 0.0 and none is not None else [True] * len(hypotheses)
    )
    kept = []
    for hypothesis, size in zip(hypotheses, sizes, strict=True):
        if far > FROM_NOISE and none is not None and _are_many_small(hypothesis, hypotheses, none):
            continue
        simpler = [h for h, own, may in zip(hypotheses, sizes, likely, strict=True) if own <= size and may]
        fewer = [h for h in simpler if 0 < len(h.keys) < len(hypothesis.keys)]
        if none is not None and not all(likely):
            fewer = fewer or [none]  # where each of fewer causes is less probable than none
        if len(hypothesis.keys) < 2 or not fewer:
            kept.append(hypothesis)
            continue
        left, before = hypothesis.above, min(h.above for h in fewer)
        parts = [h for h in fewer if set(h.keys) < set(hypothesis.keys)] or fewer
        takes = (min(h.above for h in parts) - left) / gap if gap > 0.0 else 1.0
        if far > 0.0 and none is not None and none.unseen is not None:
            if hypothesis.unseen is None:
                continue
            unseen = share_removed(hypothesis, none) - max(share_removed(h, none) for h in parts)
            takes = (1.0 - far) * takes + far * unseen
        if left**2 <= (1.0 - calibration.pays) * before**2 and takes >= LEAST_FURTHER_SHARE:
            kept.append(hypothesis)
    paid = [hypothesis for hypothesis in kept if len(hypothesis.keys) > 1]
    return [h for h in hypotheses if any(h is k for k in kept) or any(_is_rival(h, k) for k in paid)]


def _are_many_small(item: Assessment[F], hypotheses: Sequence[Assessment[F]], none: Assessment[F]) -> bool:
    """Whether more than ``FEW`` causes lie at several joints, none takes most of the gap, and they leave some of it."""
    if len(item.keys) <= FEW or len({joint for _, joint in item.keys}) == 1:
        return False

    def takes(found: Assessment[F]) -> float:
        return min(share_removed_from_fitted(found, none), share_removed(found, none))

    alone = [h for h in hypotheses if len(h.keys) == 1 and h.keys[0] in item.keys]
    return takes(item) < MOST_OF_MANY and all(takes(h) <= DOMINATES for h in alone)


def _likelier_than_none(hypotheses: Sequence[Assessment[F]], calibration: Calibration) -> list[bool]:
    """Of each hypothesis whether it has better odds than none, its numbers charged, before all priors."""
    against = costs_against(hypotheses, far_share(hypotheses), calibration)
    of_none = next(value for h, value in zip(hypotheses, against, strict=True) if not h.keys)
    return [not h.keys or bool(value < of_none) for h, value in zip(hypotheses, against, strict=True)]


def _is_rival(hypothesis: Assessment[F], other: Assessment[F]) -> bool:
    """Whether a set differs from ``other`` in one cause and leaves as much."""
    alike = len(hypothesis.keys) == len(other.keys) == len({*hypothesis.keys} & {*other.keys}) + 1
    return alike and hypothesis.above <= RIVAL_RATIO * other.above


def judge(
    found: Hypotheses[F],
    calibration: Calibration,
    singles: int = 0,
    free: TrialErrors | None = None,
    motion: float = np.inf,
) -> Judgement[F]:
    """Weigh all hypotheses; ``singles`` as in ``posterior_weights``.

    ``free`` : the error of a free-form torque on unseen trials; ``motion`` : RMS of the motion, in noise floors.

    If one cause explains the trials, a cause's probability is its own weight plus its share of every set
    that contains it, by its contribution there: they sum to at most 1. If several are needed, it is the weight of all
    sets that contain it: each of two may have all that the doubt of several leaves.
    """
    fitted = [found.none, *found.singles, *found.several]
    hypotheses = hypotheses_that_pay(fitted, calibration)
    beyond = probability_beyond_accuracy(found.none.above / motion, calibration)
    weights = _weights_by_removal(
        hypotheses, posterior_weights_beside(hypotheses, fitted, found.small, calibration, singles), beyond
    )
    weights = _simpler_of_equal(hypotheses, weights)
    heaviest = _heaviest_index(hypotheses, weights)
    best = hypotheses[heaviest]
    unexplained = max(1.0 - float(weights[0]), beyond)
    unknown = probability_of_unknown(hypotheses, best, unexplained, free, calibration)
    by_key: dict[Key, float] = {}
    costs = {frozenset(hypothesis.keys): hypothesis.cost for hypothesis in hypotheses}
    for hypothesis, weight in zip(hypotheses[1:], weights[1:], strict=True):
        shares = _contributions(hypothesis, costs) if len(best.keys) < 2 else dict.fromkeys(hypothesis.keys, 1.0)
        for key, share in shares.items():
            by_key[key] = by_key.get(key, 0.0) + float(weight) * share
    ranked = sorted(
        ((single, by_key.get(single.keys[0], 0.0) * (1.0 - unknown)) for single in found.singles),
        key=lambda item: (-item[1], item[0].cost),
    )
    none = float(weights[0]) * (1.0 - unknown)
    verdict, tied = _verdict(hypotheses, weights, heaviest, unknown, calibration)
    shared = _shared_by_all(hypotheses, best, tied, calibration) if len(best.keys) > 1 else None
    if shared is not None:
        verdict, best, tied = "effect", shared, ()
    if verdict == "unknown":
        # Where no cause removes enough, a gap beyond a model's accuracy refutes that nothing is missing all the same.
        refuted = max(none - (1.0 - far_share(hypotheses) * beyond), 0.0)
        none, unknown = none - refuted, unknown + refuted
    if verdict == "unknown" and not best.keys and len(hypotheses) > 1:  # the nearest explanation is shown
        best = max(hypotheses[1:], key=lambda h: _mean_share(h, found.none))
    weighed = sorted(zip(hypotheses, weights.tolist(), strict=True), key=lambda item: -item[1])
    return Judgement(verdict, best, tied, tuple(ranked), none, unknown, tuple(weighed))


def _heaviest_index(hypotheses: Sequence[Assessment[F]], weights: Array) -> int:
    """Index of the accepted hypothesis: of those with the most probable cause, alone or with others, the heaviest.

    Of sets that share a cause each may weigh less than a rival of that cause, all together more: half of the real
    ankle's recordings have 0.56 for sets with a link that bends, the best of them 0.35, and 0.43 for backlash alone.
    """
    first = int(np.argmax(weights))
    if not hypotheses[first].keys:
        return first
    total: dict[Key, float] = {}
    for hypothesis, weight in zip(hypotheses, weights, strict=True):
        for key in hypothesis.keys:
            total[key] = total.get(key, 0.0) + float(weight)
    most = max(total.values())
    # The causes of a set that no other hypothesis shares with it are equally probable.
    leading = {key for key, weight in total.items() if weight >= most - 1e-12}
    among = [i for i, hypothesis in enumerate(hypotheses) if leading & set(hypothesis.keys)]
    return max(among, key=lambda i: float(weights[i]))


def _simpler_of_equal(hypotheses: Sequence[Assessment[F]], weights: Array) -> Array:
    """The weights; where the draws do not resolve the first two of them, the simpler hypothesis gets the larger one."""
    first, second = np.argsort(-weights, kind="stable")[:2] if len(weights) > 1 else (0, 0)
    sizes = unknowns_and_states(hypotheses)
    if far_share(hypotheses) == 0.0 or sizes[second] >= sizes[first] or not hypotheses[second].keys:
        return weights
    if weights[first] - weights[second] > UNRESOLVED:
        return weights
    kept = weights.copy()
    kept[[first, second]] = weights[[second, first]]
    return kept


def _weights_by_removal(hypotheses: Sequence[Assessment[F]], weights: Array, beyond: float) -> Array:
    """The weights; far from the noise, a hypothesis that removes too little of the gap mostly supports none.

    Where others remove enough, none has at most what ``beyond``, the probability that the gap is more than a model's
    accuracy, leaves: that nothing is missing is then refuted by the gap, however many numbers its explanation has. They
    share the rest by their weights.
    """
    far, none = far_share(hypotheses), hypotheses[0]
    if far == 0.0 or none.keys:
        return weights
    least = least_removed_share(hypotheses)
    little = np.array([bool(h.keys) and _mean_share(h, none) < least for h in hypotheses])
    kept = weights * np.where(little, 1.0 - far * (1.0 - WEIGHT_OF_LITTLE), 1.0)
    kept[0] += weights.sum() - kept.sum()
    enough = np.array([bool(h.keys) for h in hypotheses]) & ~little
    most = 1.0 - far * beyond
    if float(kept[enough].sum()) > 0.0 and kept[0] > most:
        kept[enough] *= 1.0 + (kept[0] - most) / kept[enough].sum()
        kept[0] = most
    return np.asarray(kept)


def _mean_share(item: Assessment[F], none: Assessment[F]) -> float:
    """Share of the gap that a hypothesis removes, the mean of those of fitted and of unseen trials."""
    return 0.5 * (share_removed(item, none) + share_removed_from_fitted(item, none))


def _contributions(found: Assessment[F], costs: Mapping[frozenset[Key], float]) -> dict[Key, float]:
    """The contribution of each cause of a hypothesis: the cost increase of the best one without it."""
    gains = {}
    for key in found.keys:
        rest = frozenset(found.keys) - {key}
        without = min(cost for keys, cost in costs.items() if keys <= rest)
        gains[key] = max(without - found.cost, 0.0)
    total = sum(gains.values())
    return {key: gain / total if total > 0.0 else 1.0 / len(gains) for key, gain in gains.items()}


def with_coarse_counts(judged: Judgement[F], *, coarse: bool) -> Judgement[F]:
    """The verdict with coarse counts as a cause, which is visible in the readings themselves.

    It takes nothing from the odds of another cause: both are present.
    """
    if not coarse:
        return judged
    if judged.verdict != "none":
        return replace(judged, none=judged.none * (1.0 - PROBABILITY_OF_COUNTS), counts=PROBABILITY_OF_COUNTS)
    singles = tuple((item, probability * (1.0 - PROBABILITY_OF_COUNTS)) for item, probability in judged.singles)
    none, unknown = judged.none * (1.0 - PROBABILITY_OF_COUNTS), judged.unknown * (1.0 - PROBABILITY_OF_COUNTS)
    return replace(judged, verdict="effect", singles=singles, none=none, unknown=unknown, counts=PROBABILITY_OF_COUNTS)


def without_causes(judged: Judgement[F], none: Assessment[F]) -> Judgement[F]:
    """The verdict for a gap that is smaller than the required accuracy: no cause counts, coarse counts neither."""
    singles = tuple((item, 0.0) for item, _ in judged.singles)
    return replace(judged, verdict="none", accepted=none, tied=(), singles=singles, none=1.0, unknown=0.0, counts=0.0)


def with_doubt_of_held_out(judged: Judgement[F], fails: float) -> Judgement[F]:
    """The verdict with the probability that held-out trials contradict the explanation."""
    return with_further_doubt(judged, UNKNOWN_IF_CONTRADICTED * fails)


def with_further_doubt(judged: Judgement[F], chance: float) -> Judgement[F]:
    """The verdict with a further probability that its explanation does not hold.

    "unknown" above a half, and in place of "none" where it is more probable than that.
    """
    unknown = 1.0 - (1.0 - judged.unknown) * (1.0 - chance)
    kept = (1.0 - unknown) / max(1.0 - judged.unknown, 1e-12)
    singles = tuple((item, probability * kept) for item, probability in judged.singles)
    made = replace(judged, singles=singles, none=judged.none * kept, unknown=unknown)
    outweighed = judged.verdict == "none" and made.none < unknown
    return replace(made, verdict="unknown", tied=()) if unknown > 0.5 or outweighed else made


def open_explanations(judged: Judgement[F]) -> list[tuple[F, float]]:
    """Fits that a further trial should separate, with their weights; at least the two largest."""
    chosen = [(item.fit, weight) for item, weight in judged.weighed[:6]]
    near = [(judged.accepted.fit, 1.0), *[(rival.fit, 1.0) for rival in judged.tied]]
    return near if judged.verdict == "tie" else chosen


def rivals_with_doubt(judged: Judgement[F], doubt: float, most: int) -> list[tuple[F, float]]:
    """``open_explanations`` and the next best causes, ``most`` together; the latter share ``doubt``.

    Few trials often favour a wrong cause strongly, and a trial that only separates it from its nearest kin does not
    show that.
    """
    alive = [(fit, weight) for fit, weight in open_explanations(judged) if weight >= LEAST_WEIGHT]
    near = alive[:most] or open_explanations(judged)[:1]
    known, total = {id(fit) for fit, _ in near}, sum(weight for _, weight in near)
    others = [item.fit for item, _ in judged.weighed if item.keys and id(item.fit) not in known][: most - len(near)]
    kept = 1.0 - doubt if others else 1.0
    return [(fit, kept * weight / total) for fit, weight in near] + [(fit, doubt / len(others)) for fit in others]


def _verdict(
    hypotheses: Sequence[Assessment[F]], weights: Array, heaviest: int, unknown: float, calibration: Calibration
) -> tuple[Verdict, tuple[Assessment[F], ...]]:
    if unknown > 0.5:
        return "unknown", ()
    best = hypotheses[heaviest]
    if not best.keys:  # "none" would say more than is known where something missing is more probable
        return ("none" if (1.0 - unknown) * weights[heaviest] >= unknown else "unknown"), ()
    size = len(best.keys)
    rivals = [(h, w) for h, w in zip(hypotheses, weights, strict=True) if h is not best and len(h.keys) == size]
    tied = tuple(h for h, w in rivals if w * calibration.tie_odds > weights[heaviest])
    if len(tied) >= MOST_TIED and (1.0 - unknown) * weights[heaviest] < unknown:
        return "unknown", ()
    return ("tie" if tied else "effect"), tied


def _shared_by_all(
    hypotheses: Sequence[Assessment[F]], best: Assessment[F], tied: Sequence[Assessment[F]], calibration: Calibration
) -> Assessment[F] | None:
    """The single cause that all tied sets have in common, if it removes most of the gap far above the noise.

    What differs between the sets, if it takes little, cannot be determined; it belongs to the remainder.
    """
    common = set(best.keys).intersection(*(rival.keys for rival in tied))
    alone = next((h for h in hypotheses if len(h.keys) == 1 and set(h.keys) <= common), None)
    if not tied or alone is None or len(common) > 1 or far_share(hypotheses) < 1.0:
        return None
    takes = share_removed_from_fitted(alone, hypotheses[0])
    little = share_removed_from_fitted(best, hypotheses[0]) - takes < LITTLE_SHARE
    return alone if takes >= calibration.most and little else None
