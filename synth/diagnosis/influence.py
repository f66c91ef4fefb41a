"""Whether the verdict depends on a single recording: it is evaluated again without each.

First by one step from the common fits, in closed form; if that changes the verdict, by fits without the recording.
A fit uses all other recordings, so only the few most influential ones are refitted: the cost grows linearly with
the number of recordings, not quadratically.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np

from synth.arrays import Array
from synth.diagnosis.angle_search import rms_over_noise
from synth.diagnosis.angle_trials import AngleTrial
from synth.diagnosis.effect_shape import shape_places
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis, shaped
from synth.diagnosis.hypotheses import Assessment, F, Hypotheses, TrialErrors
from synth.diagnosis.lanes import Hypothesis
from synth.diagnosis.restarts import refine
from synth.diagnosis.settled import LARGEST_FALL_LEFT
from synth.diagnosis.unseen import errors_by_trial
from synth.diagnosis.verdict import Calibration, Judgement, judge
from synth.diagnosis.workbench import Workbench
from synth.estimation.unknown_size import UnknownSize
from synth.remarks import decisive
from synth.units import significant

T = TypeVar("T")
LEAST_TRIALS = 3  # with fewer, the verdict depends on each anyway
MOST_HYPOTHESES = 4  # hypotheses that are evaluated again
REFIT_RENEWALS = 3  # renewals of the derivatives in a fit without a recording
MOST_REFITTED = 6  # refits without a recording; the closed form alone rarely changes a clear verdict
SURE_WEIGHT = 0.8  # weight that the other explanation needs without the recording
ODD_SHARE = 1 / 3  # of the misfit, below which it must fall without one recording for that one to be named as odd
# Noise floors of misfit, from which an odd recording is looked for: below, white noise scatters as much.
LEAST_ODD_MISFIT = 3.0


@dataclass(frozen=True)
class SteppedHypothesis:
    """A hypothesis after one step of its linearisation, in which derivatives do not change.

    ``start`` : at its end, not evaluated. ``shapes`` (n, 2) as ``FittedHypothesis``, of the recordings that count.
    """

    start: EvaluatedHypothesis
    shapes: Array

    @property
    def hypothesis(self) -> Hypothesis:
        """Its causes."""
        return self.start.hypothesis


SteppedAssessment = Assessment[SteppedHypothesis]


@dataclass(frozen=True)
class OddRecording:
    """A recording that most of the misfit comes from.

    ``left`` : misfit of the others without it, ``whole`` : of all, both in noise floors, with the causes ``by``.
    ``further`` : causes beside these with which all recordings are explained as well as the others are without it;
    ``together`` : the misfit of all then. Empty: none is known, and the recording contradicts the others.
    """

    name: str
    left: float
    whole: float
    by: str
    further: str = ""
    together: float = 0.0

    @property
    def text(self) -> str:
        """What to do with it, and why."""
        left, whole, together = (significant(each, 2) for each in (self.left, self.whole, self.together))
        alone = f"{f'with {self.by} ' if self.by else ''}their error is {left} times the noise without it, and {whole}"
        if self.further:
            text = f"{self.name} alone shows a further cause, or contradicts the others: {alone} times with it; with "
            return f"{text}{self.further} too it is {together} times for all. Record another motion like this one"
        text = f"{self.name} contradicts the others: {alone} times with it. "
        return f"{text}Check it first (its start, its rest position, what was different then)"


@dataclass(frozen=True)
class VerdictDependence:
    """The recordings that the verdict depends on.

    ``turned`` : (name, the verdict without it) of each recording that changes the verdict. ``open`` : names of
    those that may change it by the closed form and were not refitted, see ``names_of_pieces``. ``odd`` : a recording
    that most of the misfit comes from, if any. ``of`` : number of recordings; ``against`` : of those without which the
    verdict has none of its causes.
    ``whole`` : the verdict with all of them, before these doubts make it less sure.
    """

    turned: tuple[tuple[str, str], ...] = ()
    open: tuple[str, ...] = ()
    odd: tuple[OddRecording, ...] = ()
    of: int = 0
    against: int = 0
    whole: str = ""

    @property
    def chance(self) -> float:
        """Probability that a further recording contradicts the verdict, if it needs one of these; 0 if it needs none.

        With Jeffreys' prior (Krichevsky & Trofimov, IEEE Trans. Inf. Theory 27 (1981) 199): of three recordings of the
        robot's hip one carries the verdict of that half, and the other half has another one.
        """
        return (self.against + 0.5) / (self.of + 1.0) if self.against else 0.0

    def warnings(self) -> tuple[str, ...]:
        """What to doubt, in sentences."""
        said = [
            decisive(
                f"the verdict depends on {name}: with it {self.whole}, without it {other}. Check it first (its start, "
                "its rest position, what was different in this trial), or repeat it"
            )
            for name, other in self.turned
        ]
        if self.open:
            names = ", ".join(self.open[:5]) + (f" and {len(self.open) - 5} more" if len(self.open) > 5 else "")
            said.append(
                f"the verdict may also depend on {names}: this is a first-order estimate, since only the most "
                "influential recordings were left out one by one. So many indicate nearly tied explanations"
            )
        said += [each.text for each in self.odd if each.name not in [turning for turning, _ in self.turned]]
        return tuple(said)


def verdict_dependence(
    bench: Workbench,
    found: Hypotheses[EvaluatedHypothesis],
    judged: Judgement[EvaluatedHypothesis],
    calibration: Calibration,
    free: TrialErrors | None = None,
    motion: float = np.inf,
) -> VerdictDependence:
    """The recordings that the verdict depends on; ``free`` and ``motion`` as in ``judge``.

    A cause that fewer recordings cannot separate from another is no change; another cause, none or unknown is.
    """
    if len(bench.trials) < LEAST_TRIALS:
        return VerdictDependence()
    chosen = {id(item): item for item in _asked_again(found, judged)}
    steps = {key: _step_without_each(bench, item) for key, item in chosen.items()}
    doubtful: list[tuple[float, int]] = []
    for i in range(len(bench.trials)):
        freely = free.without(i) if free is not None else None
        again = _judge_again(found, {key: made[i] for key, made in steps.items()}, calibration, freely, motion)
        if _verdict_differs(judged, again):
            doubtful.append((_weight_without(judged, again), i))
    doubtful.sort()
    turned, against = [], 0
    for _, i in sorted(doubtful[:MOST_REFITTED], key=lambda item: item[1]):
        near, freely = [made[i] for made in steps.values()], free.without(i) if free is not None else None
        anew = _judge_again(
            found, dict(zip(steps, _refit_without(bench, near, i), strict=True)), calibration, freely, motion
        )
        said = _verdict_words(anew)
        if said and _verdict_differs(judged, anew):
            turned.append((bench.trials[i].recording.name, said))
            against += not _shares_a_cause(judged, anew)
    left = sorted(i for _, i in doubtful[MOST_REFITTED:])
    tried = [judged.accepted] if judged.verdict in ("effect", "tie") else [found.none, *found.singles]
    odd = _odd_recording(bench, [(item, steps.get(id(item))) for item in tried], found.several)
    names = names_of_pieces(bench.trials, left)
    return VerdictDependence(tuple(turned), names, odd, len(bench.trials), against, _whole_words(judged))


def names_of_pieces(trials: Sequence[AngleTrial], chosen: Sequence[int]) -> tuple[str, ...]:
    """A name each recording of which a trial is ``chosen`` by its index; of several pieces of one, their number."""
    whole = [id(trial.whole) for trial in trials]
    found: dict[int, list[AngleTrial]] = {}
    for i in chosen:
        found.setdefault(whole[i], []).append(trials[i])
    return tuple(
        some[0].recording.name
        if len(some) == 1
        else f"{len(some)} of the {whole.count(key)} pieces of {some[0].whole.recording.name}"
        for key, some in found.items()
    )


def _asked_again(
    found: Hypotheses[EvaluatedHypothesis], judged: Judgement[EvaluatedHypothesis]
) -> list[Assessment[EvaluatedHypothesis]]:
    """The heaviest hypotheses, and what ``judge`` weighs them by; each once.

    None, the best single cause, those of several each alone, and the sets with small causes. Two causes were taken for
    useless without each of six recordings: a third one imitates both, and neither of them alone was there to compare.
    """
    chosen = [item for item, _ in judged.weighed[:MOST_HYPOTHESES]]
    together = {key for item in chosen if len(item.keys) > 1 for key in item.keys}
    chosen += [found.none, *found.singles[:1], *(item for item in found.singles if item.keys[0] in together)]
    chosen += _sets_with_small_causes(found, chosen)
    return [*{id(item): item for item in chosen}.values()]


def _odd_recording(
    bench: Workbench,
    tried: Sequence[tuple[Assessment[EvaluatedHypothesis], Sequence[SteppedAssessment] | None]],
    several: Sequence[Assessment[EvaluatedHypothesis]],
) -> tuple[OddRecording, ...]:
    """The recording without which the misfit of the others falls below ``ODD_SHARE`` of what it was, by a new fit.

    ``tried`` : explanations, with their steps without each recording if known. Where none of them explains all, one of
    them may explain the others: a forgotten tip mass hides a friction. ``several`` : sets of causes, of which one may
    explain all: a drive's limit acts in the hardest recording alone.
    """
    whole = min(item.ratio for item, _ in tried)
    if whole < LEAST_ODD_MISFIT:
        return ()
    steps = [known or _step_without_each(bench, item) for item, known in tried]
    ratios = np.array([[step.ratio for step in each] for each in steps])
    place, out = divmod(int(np.argmin(ratios)), len(bench.trials))
    if ratios[place, out] > 2.0 * ODD_SHARE * whole:  # one step may not go all the way
        return ()
    (again,) = _refit_without(bench, [steps[place][out]], out)
    if again.ratio > ODD_SHARE * whole:
        return ()
    own, name = tried[place][0].keys, bench.trials[out].recording.name
    wider = [item for item in several if {*own} < {*item.keys} and item.ratio <= again.ratio]
    odd = OddRecording(name, again.ratio, whole, _words(own))
    if not wider:
        return (odd,)
    best = min(wider, key=lambda item: item.cost)
    return (replace(odd, further=_words([key for key in best.keys if key not in own]), together=best.ratio),)


def _words(keys: Iterable[tuple[str, str]]) -> str:
    return " and ".join(f"{effect} ({at})" for effect, at in keys)


def _weight_without(judged: Judgement[EvaluatedHypothesis], again: Judgement[F]) -> float:
    """The probability of the common verdict without one recording."""
    if judged.verdict == "unknown":
        return again.unknown
    if judged.verdict == "none":
        return again.none
    known = [frozenset(judged.accepted.keys), *(frozenset(rival.keys) for rival in judged.tied)]
    left = sum(weight for item, weight in again.weighed if frozenset(item.keys) in known)
    return left * (1.0 - again.unknown)


def _judge_again(
    found: Hypotheses[EvaluatedHypothesis],
    here: dict[int, Assessment[F]],
    calibration: Calibration,
    free: TrialErrors | None,
    motion: float,
) -> Judgement[F]:
    """Odds of the given hypotheses under the keys of those they stand for."""
    singles = tuple(here[id(item)] for item in found.singles if id(item) in here)
    several = tuple(here[id(item)] for item in found.several if id(item) in here)
    some = Hypotheses(here[id(found.none)], singles, several, found.small)
    return judge(some, calibration, len(found.singles), free, motion)


def _sets_with_small_causes(
    found: Hypotheses[EvaluatedHypothesis], chosen: Sequence[Assessment[EvaluatedHypothesis]]
) -> list[Assessment[EvaluatedHypothesis]]:
    """The sets that add small causes to one of these, by which they are weighed."""
    main = [set(item.keys) for item in chosen if item.keys]
    return [item for item in found.several if any(keys < {*item.keys} <= {*keys, *found.small} for keys in main)]


def _refit_without(
    bench: Workbench, found: Sequence[SteppedAssessment], out: int
) -> list[Assessment[EvaluatedHypothesis]]:
    """Hypotheses fitted to all trials but one."""

    def all_but_one(values: Sequence[T]) -> tuple[T, ...]:
        return (*values[:out], *values[out + 1 :])

    rest = replace(bench, trials=all_but_one(bench.trials))
    fits = rest.evaluate([item.fit.start.start_at(states=all_but_one(item.fit.start.states)) for item in found])
    fits = refine(rest, fits, REFIT_RENEWALS, LARGEST_FALL_LEFT)
    return [
        Assessment(
            fit,
            fit.cost,
            rms_over_noise(rest, fit),
            item.unseen,
            errors_by_trial(rest, fit.residuals) if item.seen else None,
        )
        for fit, item in zip(fits, found, strict=True)
    ]


def _step_without_each(bench: Workbench, found: Assessment[EvaluatedHypothesis]) -> list[SteppedAssessment]:
    """A hypothesis refitted to all trials but one, for each trial."""
    fit = found.fit
    normal = bench.normal(fit)
    changes = np.array([np.diag(matrix) for matrix, _ in normal.parts]) / normal.weight
    places = [fit.n_tolerance + place for place in shape_places(fit.hypothesis)]
    low, high = bench.bounds(fit.hypothesis)
    made = []
    for out, trial in enumerate(bench.trials):
        step = np.clip(fit.unknowns + normal.without(out), low, high) - fit.unknowns
        squares = max(normal.squares_without(out, step), 0.0)
        rest = bench.total - float(bench.independent(trial).sum())
        unknowns = fit.unknowns + step
        cost = UnknownSize(rest).cost(squares, unknowns)
        left, seen = (each.without(out) if each is not None else None for each in (found.unseen, found.seen))
        shapes = shaped(unknowns[places], np.delete(changes, out, axis=0).sum(axis=0)[places], squares)
        stepped = SteppedHypothesis(fit.start_at(unknowns=unknowns), shapes)
        made.append(Assessment(stepped, cost, float(np.sqrt(squares / rest)), left, seen))
    return made


def _verdict_words(judged: Judgement[F]) -> str:
    """The verdict, if it is sufficiently certain."""
    if judged.verdict == "unknown":
        return "the missing effect would be unknown" if judged.unknown > SURE_WEIGHT else ""
    if judged.verdict == "none":
        return "no effect would be missing" if judged.none > SURE_WEIGHT else ""
    return (
        f"it would be {_words(judged.accepted.keys)}"
        if judged.weighed[0][1] > SURE_WEIGHT and judged.unknown < 1.0 - SURE_WEIGHT
        else ""
    )


def _whole_words(judged: Judgement[F]) -> str:
    """The verdict, however sure."""
    if judged.verdict == "unknown":
        return "the missing effect is unknown"
    if judged.verdict == "none":
        return "no effect is missing"
    either = [_words(item.keys) for item in (judged.accepted, *judged.tied)]
    return f"it would be {' or '.join(either)}"


def _shares_a_cause(judged: Judgement[EvaluatedHypothesis], again: Judgement[F]) -> bool:
    """Whether a verdict without one recording still names some of the causes, if not all of them."""
    known = {key for item in (judged.accepted, *judged.tied) for key in item.keys}
    return again.verdict in ("effect", "tie") and not known.isdisjoint(again.accepted.keys)


def _verdict_differs(judged: Judgement[EvaluatedHypothesis], again: Judgement[F]) -> bool:
    if again.verdict in ("none", "unknown") or judged.verdict in ("none", "unknown"):
        return again.verdict != judged.verdict
    known = [judged.accepted.keys, *(rival.keys for rival in judged.tied)]
    return {frozenset(again.accepted.keys)}.isdisjoint(frozenset(keys) for keys in known)
