"""The next trial: the one of a plant's menu that best separates the remaining explanations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite

from synth.diagnosis.diagnosis_result import Experiment
from synth.diagnosis.plant import F, MenuItem, Plant, S, T
from synth.estimation.information import expected_information, of_unknown_size, rivals_of
from synth.threads import in_parallel

# Trials that separate all rivals give the same information to this digit; of them the one that best
# separates the two most similar rivals is the most robust.
INFORMATION_DIGITS = 2
LEAST_INFORMATION = 0.01  # bit; a trial that tells less is not worth its recording
TRIALS_VARIED = 3  # best trials that each round of a search varies
MOST_FORECASTS = 480  # of a search: some 5 s of a processor


@dataclass(frozen=True)
class _TrialInformation:
    """What a trial tells: expected information in bits, and the smallest distance of two rivals."""

    bits: float
    nearest: float

    @property
    def place(self) -> tuple[float, float]:
        """For sorting, the best first."""
        return -round(self.bits, INFORMATION_DIGITS), -self.nearest


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


def next_experiment(plant: Plant[F, T, S], rivals: Sequence[tuple[F, float]], why: str) -> Experiment | None:
    """The trial with the largest expected information on which rival is true.

    None with fewer than two rivals, or if no trial gives ``LEAST_INFORMATION``.

    ``rivals`` : fits with their weights. ``why`` : a sentence. The uncertainty of a prediction combines noise, what
    the best rival leaves unexplained in the existing trials, per-trial unknowns, and the uncertainty of the leg after
    these trials. Without the second every trial of a rig far above its noise separates all rivals. A plant may vary
    the best trials of its menu.
    """
    menu = list(plant.menu()) if len(rivals) > 1 else []
    if not menu:
        return None
    kept, weights = rivals_of(rivals, plant.most_rivals)
    covariances = [plant.covariance(fit) for fit in kept]
    remainder = min(plant.remainder(fit) for fit in kept)

    def information_of_trial(item: MenuItem[T]) -> _TrialInformation:
        made = [plant.forecast(fit, item.trial, known) for fit, known in zip(kept, covariances, strict=True)]
        found = [forecast for forecast in made if forecast is not None]
        if len(found) < len(kept):
            return _TrialInformation(0.0, 0.0)
        least = [float("inf")]

        def distance(a: int, b: int, at: int) -> float:
            apart = found[a].distance(found[b], found[at], remainder)
            least.append(apart)
            return of_unknown_size(apart, plant.independent)

        bits = expected_information(weights, distance)
        return (
            _TrialInformation(bits, min(least)) if isfinite(bits) else _TrialInformation(0.0, 0.0)
        )  # derivatives may overflow

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
        f"{why} {best_item.what[0].upper()}{best_item.what[1:]} would give most information: {most.bits:.2g} bit"
        f"{_recording_condition(best_item, kept)}.",
        dict(best_item.keys),
        dict(best_item.release),
        most.bits,
        tuple((item.what, each.bits) for item, each in known),
        best_item.ramp,
        best_item.command,
    )
