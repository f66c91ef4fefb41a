"""The next trial: the one of a plant's menu that best separates the remaining explanations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from math import isfinite

import numpy as np

from synth.arrays import Array
from synth.diagnosis.diagnosis_result import Experiment
from synth.diagnosis.plant import F, MenuItem, Plant, S, T
from synth.estimation.information import expected_information, of_unknown_size, rivals_of
from synth.threads import in_parallel

# Trials that separate all rivals give the same information to this digit; of them the one that best
# separates the two most similar rivals is the most robust.
INFORMATION_DIGITS = 2
LEAST_INFORMATION = 0.01  # bit; a trial that tells less is not worth its recording
# Share of what the odds leave open: a trial that gives less moves equal odds of two by less than 1 to 3, and no tie is
# decided by that. Bit, below which the odds leave nothing open: one explanation has 99 %.
HARDLY, LEAST_OPEN = 0.2, 0.08
TRIALS_VARIED = 3  # best trials that each round of a search varies
MOST_FORECASTS = 480  # of a search: some 5 s of a processor


@dataclass(frozen=True)
class _TrialInformation:
    """What a trial tells: expected information in bits, by the present odds and by those with the doubt of them; and
    the smallest distance of two rivals.
    """

    bits: float = 0.0
    with_doubt: float = 0.0
    nearest: float = 0.0

    @property
    def place(self) -> tuple[float, float, float]:
        """For sorting, the best first."""
        return -round(self.bits, INFORMATION_DIGITS), -round(self.with_doubt, INFORMATION_DIGITS), -self.nearest


def _recording_condition(item: MenuItem[T], kept: Sequence[F]) -> str:
    """What the information of a trial in which one joint moves freely takes for granted if a reading may be late.

    In free motion a late reading is the same motion begun later. It shows only before the joint moves: of the 9.7
    noise floors by which a reading 30 ms late differs from a torque that is, its initial state free, 8.6 lie in the
    first 40 ms.
    """
    locked = item.keys.get("locked", ())
    free = len(item.release) - (len(locked) if isinstance(locked, Sequence) else 0)
    if item.command is not None or free != 1:
        return ""
    if not any(cause.key[0] == "latency" for fit in kept for cause in fit.hypothesis):
        return ""
    return (
        ", if its recording begins exactly at the release by the recorder's clock: in free motion a late reading of "
        "the only joint that moves shows in nothing else"
    )


def _present_weights(kept: Sequence[F], present: Sequence[tuple[F, float]], weights: Array) -> Array:
    """(n,) the present odds of the fits that are ``kept``, with the sum 1; ``weights`` where none are given."""
    odds = {id(fit): weight for fit, weight in present}
    found = np.array([odds.get(id(fit), 0.0) for fit in kept])
    return found / found.sum() if found.sum() > 0.0 else weights


def _entropy(weights: Array) -> float:
    """Bits."""
    there = weights[weights > 0.0]
    return float(-np.sum(there * np.log2(there)))


def _gain_text(item: MenuItem[T], told: _TrialInformation, kept: Sequence[F], open_bits: float | None) -> str:
    """What the best trial tells, as a sentence; ``open_bits`` : entropy of the present odds, None if none are given."""
    words = f"{item.what}, {item.state}," if item.state else item.what
    what = words[0].upper() + words[1:]
    condition = _recording_condition(item, kept)
    if open_bits is None or told.bits >= HARDLY * open_bits >= HARDLY * LEAST_OPEN:
        return f"{what} would give most information: {told.bits:.2g} bit{condition}."
    if open_bits < LEAST_OPEN:
        return f"{what} would separate it best from the causes that these trials reject{condition}."
    return (
        f"No trial of those tried separates them well: {words} would give most information, {told.bits:.2g} bit "
        f"of the {open_bits:.2g} that are open{condition}."
    )


def next_experiment(
    plant: Plant[F, T, S], rivals: Sequence[tuple[F, float]], why: str, present: Sequence[tuple[F, float]] = ()
) -> Experiment | None:
    """The trial with the largest expected information on which rival is true.

    None with fewer than two rivals, or if no trial gives ``LEAST_INFORMATION``. None gives more than the odds leave
    open: where that is less, none is computed.

    ``rivals`` : fits with their weights. ``why`` : a sentence. ``present`` : the same by the present odds, where the
    weights of ``rivals`` hold some for causes that the trials reject: a trial may tell those apart and still leave the
    question open, and its information is not above what the present odds leave to learn. The uncertainty of a
    prediction combines noise, what the best rival leaves unexplained in the existing trials, per-trial unknowns, and
    the uncertainty of the leg after these trials. Without the second every trial of a rig far above its noise separates
    all rivals. A plant may vary the best trials of its menu.
    """
    if len(rivals) < 2:
        return None
    kept, weights = rivals_of(rivals, plant.most_rivals)
    by_odds = _present_weights(kept, present, weights)
    menu = [] if _entropy(by_odds) < LEAST_INFORMATION else list(plant.menu())
    if not menu:
        return None
    covariances = [plant.covariance(fit) for fit in kept]
    remainder = min(plant.remainder(fit) for fit in kept)

    def information_of_trial(item: MenuItem[T]) -> _TrialInformation:
        made = [plant.forecast(fit, item.trial, known) for fit, known in zip(kept, covariances, strict=True)]
        found = [forecast for forecast in made if forecast is not None]
        if len(found) < len(kept):
            return _TrialInformation()

        @cache
        def apart(a: int, b: int, at: int) -> float:
            return found[a].distance(found[b], found[at], remainder)

        def distance(a: int, b: int, at: int) -> float:
            return of_unknown_size(apart(a, b, at), plant.independent)

        with_doubt = expected_information(weights, distance)
        if not isfinite(with_doubt):  # derivatives may overflow
            return _TrialInformation()
        nearest = min(apart(a, b, at) for a in range(len(kept)) for b in range(a) for at in (a, b))
        bits = with_doubt if by_odds is weights else expected_information(by_odds, distance)
        return _TrialInformation(bits, with_doubt, nearest)

    def information_of_trials(items: Sequence[MenuItem[T]]) -> list[tuple[MenuItem[T], _TrialInformation]]:
        return list(zip(items, in_parallel(lambda i: information_of_trial(items[i]), len(items)), strict=True))

    known = information_of_trials(menu)
    found: list[tuple[MenuItem[T], _TrialInformation]] = []
    number, left = 0, MOST_FORECASTS // len(kept)
    while left > 0 and (more := plant.variations([item for item, _ in found], number)):
        pairs = [*found, *information_of_trials(more)]
        found = sorted(pairs, key=lambda pair: pair[1].place)[:TRIALS_VARIED]
        number, left = number + 1, left - len(more)
    known = sorted([*known, *found[:1]], key=lambda pair: pair[1].place)
    best_item, most = known[0]
    if most.bits < LEAST_INFORMATION:
        return None
    return Experiment(
        f"{why} {_gain_text(best_item, most, kept, _entropy(by_odds) if present else None)}",
        dict(best_item.keys),
        dict(best_item.release),
        most.bits,
        tuple((item.what, each.bits) for item, each in known),
        best_item.ramp,
        best_item.command,
    )
