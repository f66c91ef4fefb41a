"""From costs to odds and a verdict: which cause, none, several that cannot be told apart, or none that is known."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import factorial
from typing import Generic

import numpy as np

from synth.arrays import Array
from synth.diagnosis.hypotheses import Assessed, F, Hypotheses, Key
from synth.diagnosis.result import Verdict

LEAST_SHARE = 0.1  # of the whole gap (RMS) that one cause more must take to be named: less does not matter to a user
COUNTS = 0.95  # probability of coarse counts that show; not tuned


@dataclass(frozen=True)
class Calibration:
    """What turns costs into probabilities; tuned on simulated cases (``tests/blind``, seeds 1000, 1001 and 2000).

    ``temperature`` : of the softmax over costs, for forms that do not get their cause quite right. ``per_parameter`` :
    what an unknown more must earn. ``none``, ``single``, ``pair``, ``triple`` : prior probabilities that nothing, one
    cause, two or three are missing, shared evenly among their hypotheses. ``left`` : share of the squared gap that the
    best explanation may leave for an unknown cause to be as likely as not, ``left_by_several`` that of several causes,
    ``misfit`` how fast that probability grows with its logarithm, ``doubt`` its least where something is missing: now
    and then what is in no list does the same as what is in it; ``doubt_of_several`` where it takes several causes to do
    the same, of which one may be any other's; ``clean`` : RMS over the noise floor up to which nothing is taken to be
    left; ``far`` : RMS over the floor beyond which less may be left, by the root of it: what is right leaves little
    that a good sensor still sees far above its noise. ``tie_odds`` : odds below which explanations are said to be tied.
    ``pays`` : share of what fewer causes leave of the squared gap that one more must take away; form errors of a cause
    that is right are taken up by others by a tenth.
    """

    temperature: float = 3.0
    per_parameter: float = 4.0
    none: float = 0.3
    single: float = 0.5
    pair: float = 0.19
    triple: float = 0.01
    misfit: float = 2.0
    left: float = 0.2
    left_by_several: float = 0.07
    pays: float = 0.4
    doubt: float = 0.05
    doubt_of_several: float = 0.25
    clean: float = 1.25
    far: float = 5.0
    tie_odds: float = 6.0


CALIBRATED = Calibration()


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


def weigh(hypotheses: Sequence[Assessed[F]], calibration: Calibration, singles: int = 0) -> Array:
    """(n,) posterior weights: prior times exp(-cost / temperature), costs with what their unknowns must earn.

    ``singles`` : how many single causes there are, where they are not all among the hypotheses.
    """
    counts = np.array([len(h.keys) for h in hypotheses])
    unknowns = np.array([h.n_unknown for h in hypotheses])
    singles = max(int(np.sum(counts == 1)), singles, 1)
    together = [calibration.none, calibration.single, calibration.pair, calibration.triple]
    prior = np.array([together[k] * factorial(k) / singles**k for k in counts])
    cost = np.array([h.cost for h in hypotheses]) + calibration.per_parameter * unknowns
    weights = prior * np.exp(-(cost - cost.min()) / calibration.temperature)
    return np.asarray(weights / weights.sum())


def paying(hypotheses: Sequence[Assessed[F]], share: float, least: float = LEAST_SHARE) -> list[Assessed[F]]:
    """Those of several causes only that leave clearly less than the best of fewer causes does.

    One cause more must take ``share`` of the squared error above the noise that fewer leave, and ``least`` of the whole
    gap: near the noise a share of what is left is next to nothing.
    """
    gap = max((_above(h) for h in hypotheses if not h.keys), default=0.0)
    kept = []
    for hypothesis in hypotheses:
        fewer = [_above(h) for h in hypotheses if 0 < len(h.keys) < len(hypothesis.keys)]
        if len(hypothesis.keys) < 2 or not fewer:
            kept.append(hypothesis)
            continue
        left, before = _above(hypothesis), min(fewer)
        if left**2 <= (1.0 - share) * before**2 and before - left >= least * gap:
            kept.append(hypothesis)
    return kept


def _above(found: Assessed[F]) -> float:
    """RMS error above the noise, in noise floors."""
    return float(np.sqrt(max(found.ratio**2 - 1.0, 0.0)))


def judge(found: Hypotheses[F], calibration: Calibration = CALIBRATED, singles: int = 0) -> Judged[F]:
    """Weigh all hypotheses; ``singles`` as in ``weigh``.

    Where one cause explains the trials, a cause's probability is the weight of itself alone and its share of every set
    that it is part of, by what it does there: they sum to at most 1. Where it takes several, it is the weight of all
    sets that it is part of: each of two may have all that the doubt of several leaves.
    """
    hypotheses = paying([found.none, *found.singles, *found.several], calibration.pays)
    weights = weigh(hypotheses, calibration, singles)
    heaviest = int(np.argmax(weights))
    best = hypotheses[heaviest]
    unknown = _unknown(found.none, best, calibration)
    if best.keys:
        doubt = calibration.doubt if len(best.keys) < 2 else calibration.doubt_of_several
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
    weighed = sorted(zip(hypotheses, weights.tolist(), strict=True), key=lambda item: -item[1])
    return Judged(verdict, best, tied, tuple(ranked), none, unknown, tuple(weighed))


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
