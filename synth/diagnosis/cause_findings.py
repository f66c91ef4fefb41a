"""The diagnosis of any plant from its hypotheses: verdict, causes, reduction of the gap, next experiment."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Generic

from synth.diagnosis.cause_intervals import causes_of
from synth.diagnosis.causes_of_remainder import BesideFurtherCause, beside_further_causes, causes_beside
from synth.diagnosis.diagnosis_result import Cause, Experiment, RankedCause, ScoredBy
from synth.diagnosis.hypotheses import Assessment, Hypotheses, Key
from synth.diagnosis.next_experiment import next_experiment
from synth.diagnosis.no_help import without_what_helps_not
from synth.diagnosis.odds import share_removed_from_fitted
from synth.diagnosis.plant import F, Plant, S, StagePredictions, T
from synth.diagnosis.poor_trials import followed_trials
from synth.diagnosis.prediction_error import PredictionErrors, label_of_causes
from synth.diagnosis.remainder import Remainder
from synth.diagnosis.search_limits import limit_sentences
from synth.diagnosis.sentences import FurtherCauseWords, PartedErrors, reason_for_next_trial, sentence
from synth.diagnosis.tie_on_held_out import held_out_trial_that_distinguishes
from synth.diagnosis.unseen_predictions import predict_unseen
from synth.diagnosis.verdict import Judgement, judge, with_doubt_of_held_out, with_further_doubt, without_causes
from synth.threads import one_thread_of_linear_algebra

MOST_RANKED = 8  # listed single causes; each costs a prediction of every scored trial
PREDICTED_ALONE = 4  # single causes whose predictions are stored for the page, the most probable first
# An explanation must take this share of the gap on held-out trials, where the gap is so many noise floors. Decided by
# ``make blind-rigs``: a wrong explanation imitates the gap of the trials that it was fitted to, and fails on others.
LEAST_UNSEEN_SHARE, LEAST_GAP_RATIO = 0.25, 2.0
LEAST_CHANCE_OF_FAILURE = 0.05  # of held-out trials that contradict: a smaller one decides no verdict
TRIAL_WORDS = {  # in words, where one recording is all there is
    "fitted": "the trial that was fitted",
    "pieces_in_turn": "each piece of the recording, predicted by the others,",
}
DIRECT_LABEL = "direct causes"  # label of the errors with these alone


@dataclass(frozen=True)
class Findings(Generic[F, S]):
    """The plant-independent part of a result; the adapter adds the rest."""

    found: Hypotheses[F]
    judged: Judgement[F]
    stages: StagePredictions[F, S]
    explained: bool
    causes: tuple[Cause, ...]
    tied: tuple[tuple[Cause, ...], ...]
    ranked: tuple[RankedCause, ...]
    remainder: Remainder
    sentence: str
    next_experiment: Experiment | None
    warnings: tuple[str, ...]
    scored_by: ScoredBy
    within_accuracy: bool
    odds: Judgement[F]  # ``judged``, within the required accuracy as if none were required

    @property
    def best(self) -> F:
        """The accepted hypothesis if one explains the trials, else the nominal leg's best fit."""
        return (self.judged.accepted if self.explained else self.found.none).fit

    @property
    def of_diagnosed(self) -> F | None:
        """The hypothesis of the diagnosed leg; None where an unknown effect is missing, which its numbers take up."""
        return None if self.judged.verdict == "unknown" else self.best

    @property
    def likeliest(self) -> F:
        """The hypothesis accepted as if no accuracy were required, else the nominal leg's best fit."""
        accepted = self.odds.verdict in ("effect", "tie")
        return (self.odds.accepted if accepted else self.found.none).fit

    def fields(self) -> dict[str, Any]:
        """The fields of ``Diagnosis`` except ``where``."""
        return {
            "verdict": self.judged.verdict,
            "sentence": self.sentence,
            "explanation": self.causes,
            "ranked": self.ranked,
            "probability_none": self.judged.none,
            "probability_unknown": self.judged.unknown,
            "tied": self.tied,
            "remainder": self.remainder,
            "next_experiment": self.next_experiment,
            "warnings": self.warnings,
            "scored_by": self.scored_by,
            "within_accuracy": self.within_accuracy,
        }


@dataclass(frozen=True)
class _ToldCauses:
    """Causes of each hypothesis of the verdict, by its identity; ``further``, ``tried`` : see ``ErrorWording``."""

    causes: Mapping[int, tuple[Cause, ...]]
    further: FurtherCauseWords | None
    tried: bool


@one_thread_of_linear_algebra()
def find_causes(plant: Plant[F, T, S], say: Callable[[str], None]) -> Findings[F, S]:
    """Find what distinguishes the built leg from the nominal one; ``say`` receives the current stage."""
    found = plant.search(say)
    before = predict_unseen(plant, found.none)
    within = plant.accuracy > 0.0 and plant.rms(before) <= plant.accuracy
    # Within the accuracy that is required the causes are weighed as if none were.
    motion = plant.own_motion if within else plant.motion
    weighed = judge(found, plant.calibration, free=plant.freely(found), motion=motion)
    doubts, chance = plant.doubts(found, weighed, motion)
    if weighed.verdict in ("effect", "tie"):
        weighed = with_further_doubt(weighed, chance)
    say("reduction of the gap")
    weighed = plant.with_direct_causes(weighed)
    judged, stages, moved = _judge_on_scored(plant, before, found, weighed)
    helpful = without_what_helps_not(judged, found.none, stages.errors, plant)
    worse = plant.worse(stages.errors, moved, _words_of_left_out(plant, judged, helpful))
    if helpful.verdict != judged.verdict:  # what was doubted is not said
        weighed, doubts = helpful, ()
    if helpful is not judged:
        judged, moved = helpful, None
        stages = _predict_stages(plant, before, found, judged)
    offered, odds = not within and weighed.verdict in ("effect", "tie"), judged
    if within:
        judged = without_causes(judged, found.none)
        stages, moved = _predict_stages(plant, before, found, judged, within=within), None
    explained, named = judged.verdict in ("effect", "tie"), judged.verdict != "none"
    told = _tell_causes(plant, found, judged, stages.errors)
    causes = (*told.causes[id(judged.accepted)], *_direct_causes(plant, judged)) if named else ()
    tied = tuple(told.causes[id(rival)] for rival in judged.tied)
    left = Remainder.of(stages.errors, "after", *plant.left_where(stages.after, stages.unread))
    say("what next")
    short, takes = [" + ".join(map(plant.short_text, each)) for each in (causes, *tied)], stages.errors.shrink().value
    ranked = _rank_causes(plant, judged, stages.errors, told.causes)
    return Findings(
        found,
        judged,
        stages,
        explained,
        causes,
        tied,
        ranked,
        left,
        _diagnosis_sentence(plant, judged, (causes, *tied), ranked, stages, left, moved, told),
        next_experiment(
            plant,
            plant.rivals(judged),
            reason_for_next_trial(judged.verdict, short, left, within=within, none=judged.none, takes=takes),
            plant.present_odds(judged),
        ),
        (
            *plant.warnings,
            *plant.remarks(stages),
            *(_limit_warnings(plant, (judged.accepted, *judged.tied)) if named else ()),
            *doubts,
            *(worse if offered else ()),
            *_ends_of_the_tie(plant, judged, stages.errors, short),
        ),
        _scored_by(plant),
        within,
        odds,
    )


def _words_of_left_out(plant: Plant[F, T, S], judged: Judgement[F], helpful: Judgement[F]) -> str:
    """The explanation in warnings: by its causes where they are told nowhere else."""
    if helpful is judged or not judged.accepted.keys:
        return "the explanation"
    return " + ".join(map(plant.short_text, causes_of(plant, judged.accepted)))


def _judge_on_scored(
    plant: Plant[F, T, S], before: tuple[S, ...], found: Hypotheses[F], judged: Judgement[F]
) -> tuple[Judgement[F], StagePredictions[F, S], PredictionErrors | None]:
    """The verdict with what held-out trials say of its explanation, the predictions, and the moved errors if any."""
    stages = _predict_stages(plant, before, found, judged)
    if judged.verdict not in ("effect", "tie") or not judged.accepted.keys or not plant.held_out:
        return judged, stages, None
    moved = _moved_errors(plant, stages.errors, judged.accepted)
    return with_doubt_of_held_out(judged, _chance_of_failure(moved or stages.errors)), stages, moved


def _tell_causes(
    plant: Plant[F, T, S], found: Hypotheses[F], judged: Judgement[F], errors: PredictionErrors
) -> _ToldCauses:
    """The causes of each hypothesis of the verdict; of causes that explain the gap also what takes their remainder."""
    explains, accepted = judged.verdict in ("effect", "tie"), judged.accepted
    beside = {
        id(item): (item, beside_further_causes(plant, found, item, errors) if explains else ())
        for item in (accepted, *judged.tied)
    }
    known = {*accepted.keys}
    tried = not known or any(known < {*item.keys} for item in found.several)
    causes = {key: causes_beside(plant, item, more) for key, (item, more) in beside.items()}
    return _ToldCauses(causes, _further_cause_words(plant, accepted, beside[id(accepted)][1]), tried)


def _ends_of_the_tie(
    plant: Plant[F, T, S], judged: Judgement[F], errors: PredictionErrors, words: Sequence[str]
) -> tuple[str, ...]:
    """What held-out trials say of a tie, which they do not decide; ``words`` of its explanations."""
    if judged.verdict != "tie" or not plant.held_out:
        return ()
    labels = ["after", *(label_of_causes(rival.keys) for rival in judged.tied)]
    return held_out_trial_that_distinguishes(errors, labels, words, plant.scored_names)


def _scored_by(plant: Plant[F, T, S]) -> ScoredBy:
    """How ``predict_unseen`` predicts the scored trials; pieces of one recording have one row of samples."""
    if plant.held_out:
        return "held_out"
    if len(plant.scored) == 1:
        return "fitted"
    return "in_turn" if len(plant.samples()[0]) > 1 else "pieces_in_turn"


def _predict_stages(
    plant: Plant[F, T, S], before: tuple[S, ...], found: Hypotheses[F], judged: Judgement[F], *, within: bool = False
) -> StagePredictions[F, S]:
    """Predict the scored trials as designed, with each listed single cause and each tied explanation.

    ``before`` is given. ``within`` the required accuracy no cause counts, the direct ones neither.
    """

    def read(predicted: tuple[S, ...]) -> tuple[S, ...]:
        return predicted if within else plant.as_read(predicted)

    as_designed = plant.predict(plant.designed(), plant.scored)
    unread = before if judged.accepted is found.none else predict_unseen(plant, judged.accepted)
    after = read(unread)
    squares = {
        "as_designed": plant.squares(as_designed),
        "before": plant.squares(before),
        "after": plant.squares(after),
    }
    alone: dict[str, tuple[S, ...]] = {}
    for single, _ in _listed_singles(judged):
        predicted = after if single is judged.accepted else read(predict_unseen(plant, single))
        squares[label_of_causes(single.keys)] = plant.squares(predicted)
        if len(alone) < PREDICTED_ALONE:
            alone[label_of_causes(single.keys)] = predicted
    for rival in judged.tied:
        if label_of_causes(rival.keys) not in squares:
            squares[label_of_causes(rival.keys)] = plant.squares(read(predict_unseen(plant, rival)))
    if plant.direct_causes:
        squares[DIRECT_LABEL] = plant.squares(plant.as_read(before))
    unread = () if within else unread
    noise_as_read = plant.samples(unread)[1]  # what counts round carries its noise, of all explanations the same
    errors = PredictionErrors(squares, *plant.samples(), plant.seed, noise_as_read)
    fits = (plant.designed(), found.none.fit, judged.accepted.fit)
    return StagePredictions(fits, as_designed, before, after, alone, errors, unread)


def _direct_causes(plant: Plant[F, T, S], judged: Judgement[F]) -> tuple[Cause, ...]:
    """The causes that are found directly in the readings, where they matter to what the others leave."""
    return plant.direct_causes if judged.counts > 0.0 else ()


def _chance_of_failure(errors: PredictionErrors) -> float:
    """Probability that the explanation takes too little of the gap on the scored trials."""
    return errors.chance_below(LEAST_UNSEEN_SHARE, LEAST_GAP_RATIO)


def _moved_errors(plant: Plant[F, T, S], errors: PredictionErrors, accepted: Assessment[F]) -> PredictionErrors | None:
    """The errors on held-out trials of the explanation moved within its uncertainty; None if that decides nothing."""
    if _chance_of_failure(errors) < LEAST_CHANCE_OF_FAILURE:
        return None
    predicted = plant.within_uncertainty(accepted.fit)
    if predicted is None:
        return None
    moved = replace(errors, squares={**errors.squares, "after": plant.squares(plant.as_read(predicted))})
    return moved if _chance_of_failure(moved) < _chance_of_failure(errors) else None


def _limit_warnings(plant: Plant[F, T, S], named: Sequence[Assessment[F]]) -> dict[str, None]:
    """Warnings on parameters of the named causes that end where their search does, each once."""
    found = []
    for item in named:
        first = plant.n_tolerance
        for candidate, cause in zip(item.fit.hypothesis, causes_of(plant, item), strict=True):
            x = item.fit.unknowns[first : first + candidate.size]
            found += limit_sentences(plant.short_text(cause), candidate, x, cause)
            first += candidate.size
    return dict.fromkeys(found)


def _listed_singles(judged: Judgement[F]) -> list[tuple[Assessment[F], float]]:
    """The most probable single causes, and those of the explanations offered however weak they are alone."""
    offered = {key for item in (judged.accepted, *judged.tied) for key in item.keys}
    return [entry for place, entry in enumerate(judged.singles) if place < MOST_RANKED or entry[0].keys[0] in offered]


def _rank_causes(
    plant: Plant[F, T, S], judged: Judgement[F], errors: PredictionErrors, told: Mapping[int, tuple[Cause, ...]]
) -> tuple[RankedCause, ...]:
    """Single causes with their probabilities and the effect of each alone, most probable first.

    ``told`` : causes of a hypothesis, by its identity, where they are told already.
    """
    singles = _listed_singles(judged)
    made = [
        RankedCause(
            (told.get(id(item)) or causes_of(plant, item))[0], probability, errors.shrink(label_of_causes(item.keys))
        )
        for item, probability in singles
    ]
    made += [RankedCause(cause, judged.counts, errors.shrink(DIRECT_LABEL)) for cause in _direct_causes(plant, judged)]
    listed = {item.keys[0] for item, _ in singles}
    by_key = {(entry.cause.effect, entry.cause.joint): entry for entry in made}
    for item in (judged.accepted, *judged.tied):
        for cause, key in zip(told[id(item)], item.keys, strict=True):
            if key not in listed:  # it was fitted beside others only, or its fit alone diverged
                by_key.setdefault((cause.effect, cause.joint), RankedCause(cause, judged.share(key), None))
    order = judged.in_order({key: entry.probability for key, entry in by_key.items()})
    return tuple(by_key[key] for key in order)


def _part_errors(errors: PredictionErrors, moved: PredictionErrors) -> PartedErrors | None:
    """The errors with and without the trials that are followed only where moved; None if these are all or none."""
    open_trials = followed_trials(errors, moved)
    number = int(open_trials.sum())
    if number in (0, len(open_trials)):
        return None
    as_is, others = errors.of_trials(~open_trials), errors.of_trials(open_trials)
    return PartedErrors(
        (as_is.figure("before"), as_is.figure("after")),
        (others.figure("before"), others.figure("after")),
        (len(open_trials) - number, number),
        as_is.shrink().value,
    )


def _common_causes(explanations: Sequence[Sequence[Cause]]) -> set[Key]:
    """Effect and joint of the causes that every explanation contains."""
    return set.intersection(*({(cause.effect, cause.joint) for cause in causes} for causes in explanations))


def _further_cause_words(
    plant: Plant[F, T, S], accepted: Assessment[F], beside: Sequence[BesideFurtherCause[F]]
) -> FurtherCauseWords | None:
    """The most probable cause of the remainder in words, and the named ones as they are beside it; None without one."""
    if not beside:
        return None
    causes, known = causes_of(plant, beside[0].item), {*accepted.keys}
    further, named = (
        [plant.cause_text(cause) for cause in causes if ((cause.effect, cause.joint) in known) is which]
        for which in (False, True)
    )
    return FurtherCauseWords(further, named, beside[0].left, little=beside[0].little)


def _diagnosis_sentence(
    plant: Plant[F, T, S],
    judged: Judgement[F],
    explanations: Sequence[Sequence[Cause]],
    ranked: Sequence[RankedCause],
    stages: StagePredictions[F, S],
    left: Remainder,
    moved: PredictionErrors | None,
    told: _ToldCauses,
) -> str:
    several = len(explanations[0]) > 1
    direct = {(cause.effect, cause.joint) for cause in _direct_causes(plant, judged)}
    common = _common_causes(explanations) | direct if judged.verdict == "tie" else set()
    apart = [[cause for cause in causes if (cause.effect, cause.joint) not in common] for causes in explanations]
    texts = [[plant.cause_text(cause) for cause in causes] for causes in apart]
    probability = 1.0 - judged.none - judged.unknown if several else judged.probability
    leading = [(plant.short_text(entry.cause), entry.shrink.value) for entry in ranked if entry.shrink is not None]
    wording = plant.wording(stages.errors)
    wording = replace(wording, on=TRIAL_WORDS.get(_scored_by(plant), wording.on))
    nearest = " + ".join(plant.short_text(cause) for cause in explanations[0])
    decisive = (
        moved if moved is not None and _chance_of_failure(moved) < 0.5 <= _chance_of_failure(stages.errors) else None
    )
    wording = replace(
        wording,
        nearest=nearest,
        takes=stages.errors.shrink().value,
        takes_fitted=_taken_from_fitted(judged),
        asked=plant.calibration.most_of_several if several else plant.calibration.most,
        left=left,
        accuracy=plant.accuracy,
        leading=leading,
        common=[plant.cause_text(cause) for cause in explanations[0] if (cause.effect, cause.joint) in common],
        each=[stages.errors.figure(label_of_causes(rival.keys)) for rival in judged.tied],
        moved=None if decisive is None else decisive.figure("after"),
        parted=None if decisive is None else _part_errors(stages.errors, decisive),
        none=judged.none,
        further=told.further,
        tried=told.tried,
    )
    text = sentence(judged.verdict, texts[0], texts[1:], probability, wording)
    return text + plant.addendum(judged.verdict, stages)


def _taken_from_fitted(judged: Judgement[F]) -> float:
    """Share of the gap that the accepted explanation removes from the trials that it is fitted to."""
    none = next((item for item, _ in judged.weighed if not item.keys), None)
    return 0.0 if none is None else share_removed_from_fitted(judged.accepted, none)
