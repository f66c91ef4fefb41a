"""The diagnosis from end to end: trials in, verdict, where, which, how far and what next out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from synth.arrays import Array
from synth.diagnosis.candidates import Candidate, candidates, scales
from synth.diagnosis.diagnosed_leg import SHOWN, diagnosed_leg, parts
from synth.diagnosis.encoder_counts import Coarse, coarse_counts, usual_noise
from synth.diagnosis.encoder_transitions import at_edges
from synth.diagnosis.experiment import next_experiment
from synth.diagnosis.figures import Gap, measure, trial_gaps
from synth.diagnosis.gap_trials import GapTrial, copies, gap_trial, sensor
from synth.diagnosis.influence import Hangs, hangs_on
from synth.diagnosis.predict import Predictor
from synth.diagnosis.prediction_error import label
from synth.diagnosis.result import Cause, GapResult, Ranked, Verdict
from synth.diagnosis.search import Assessed, search
from synth.diagnosis.sentences import Told, angle, cause_text, scored_on, sentence, what_is_open
from synth.diagnosis.solve import Fit, Workbench
from synth.diagnosis.tolerances import Tolerance, Tolerances
from synth.diagnosis.verdict import Judged, judge, open_explanations, with_counts
from synth.diagnosis.where import missing_torque, where
from synth.errors import UserError
from synth.fit.fit_result import Estimate
from synth.fit.odd_trials import odd_trials
from synth.fit.recordings import recordings, thinned_sentences
from synth.fit.unknowns import NORMAL90
from synth.swing.leg_model import Leg

if TYPE_CHECKING:
    from synth.files.trial_list import Trial

EFFECTIVE = 50.0  # samples a trial and joint that count as independent, see Workbench
RANKED = 8  # causes that are listed


@dataclass(frozen=True)
class Scene:
    """Everything that the stages of a diagnosis share."""

    leg: Leg
    bench: Workbench
    given: tuple[GapTrial, ...]
    held: tuple[GapTrial, ...]
    coarse: tuple[Coarse, ...]
    usual: Array  # (n,) rad, noise without coarse counts
    seed: int

    @property
    def scored(self) -> tuple[GapTrial, ...]:
        """The trials that the gap's figures are taken on."""
        return self.held or self.given


def diagnose(
    leg: Leg,
    trials: Sequence[Trial],
    tolerance: Tolerance,
    *,
    seed: int = 0,
    progress: Callable[[str], None] | None = None,
) -> GapResult:
    """Say what the built leg does that the nominal one does not.

    Parameters
    ----------
    leg : as designed; every joint has a spring (its rate may be zero).
    trials : what the built leg did; those held out take no part but in scoring.
    tolerance : one standard deviation of what manufacturing and measuring leave open.
    progress : told what is being done.

    Raises
    ------
    UserError : every trial is held out, or a trial cannot be used.
    """
    say = progress or (lambda text: None)
    scene, warnings = scene_of(leg, trials, tolerance, seed)
    bench, held_out = scene.bench, bool(scene.held)
    found = search(bench, candidates(leg, scene.given, scales(leg, scene.given)), say)
    weighed = judge(found)
    turned = hangs_on(bench, found, weighed)
    judged = with_counts(weighed, scene.coarse)
    say("how far it shrinks")
    shown = [item for item, _ in judged.singles[:RANKED]]
    gap = measure(bench, scene.scored, found, judged.accepted, shown, scene.coarse, scene.usual, held_out, seed)
    explained = judged.verdict in ("effect", "tie")
    causes = (*_causes(bench, judged.accepted), *_counts(scene)) if explained else ()
    tied = tuple(_causes(bench, rival) for rival in judged.tied)
    tolerances = bench.predictor.tolerances
    nominal = tolerances.leg(leg, found.none.fit.unknowns)
    # What the accepted effects do is missing from the leg without them, not from one whose dampers stand in for them.
    bare = tolerances.leg(leg, judged.accepted.fit.unknowns[: tolerances.size]) if explained else nominal
    missing = [missing_torque(bare, trial) for trial in scene.scored]
    say("what next")
    explanations = (causes, *tied)
    return GapResult(
        leg=leg,
        verdict=judged.verdict,
        sentence=_sentence(judged, explanations, gap, held_out),
        explanation=causes,
        ranked=_ranked(scene, judged, gap),
        probability_none=judged.none,
        probability_unknown=judged.unknown,
        where=where(nominal, scene.scored, gap.before, scene.usual, missing, _blamed(judged, leg)),
        as_designed=gap.figure("as_designed"),
        before=gap.figure("before"),
        after=gap.figure("after"),
        noise_floor=gap.floor,
        shrink=gap.shrink(),
        best_possible=gap.best_possible,
        noise=dict(zip(leg.joint_names, scene.usual.tolist(), strict=True)),
        scored_on=tuple(trial.recording.name for trial in scene.scored),
        trials=trial_gaps(nominal, gap, missing, held_out, scene.usual),
        next_experiment=next_experiment(
            bench, open_explanations(judged), scene.given, _why(judged.verdict, explanations)
        ),
        diagnosed=diagnosed_leg(
            leg, tolerances, (judged.accepted if explained else found.none).fit, scene.coarse if explained else ()
        ),
        warnings=(*warnings, *_odd(gap, leg), *_turning(turned), *(_worse(gap) if explained else ())),
        tied=tied,
    )


def scene_of(leg: Leg, trials: Sequence[Trial], tolerance: Tolerance, seed: int) -> tuple[Scene, tuple[str, ...]]:
    """Trials prepared, copies struck out, noise and counts estimated."""
    made = recordings(leg, trials, ())
    warnings = list(thinned_sentences(made))
    twice = copies(made, [trial.held_out for trial in trials])
    for later, earlier in twice:
        warnings.append(f"{made[later].name} is a copy of {made[earlier].name} and is left out")
    struck = {later for later, _ in twice}
    kept = [(r, t.held_out) for k, (r, t) in enumerate(zip(made, trials, strict=True)) if k not in struck]
    prepared = [gap_trial(recording, held) for recording, held in kept]
    given = tuple(trial for trial in prepared if not trial.held_out)
    held = tuple(trial for trial in prepared if trial.held_out)
    if not given:
        raise UserError("every trial is held out; at least one must be there to learn from")
    found = sensor([trial.recording for trial in given])
    coarse = coarse_counts(found)
    predictor = Predictor(leg, Tolerances.of(leg, tolerance))
    usual = usual_noise(found, coarse)
    bench = Workbench(predictor, tuple(at_edges(trial, coarse, usual) for trial in given), usual, EFFECTIVE)
    return Scene(leg, bench, given, held, coarse, usual, seed), tuple(warnings)


def _turning(hangs: Hangs) -> tuple[str, ...]:
    """Warnings where the verdict hangs on single recordings."""
    said = [
        f"the verdict hangs on {name}: without it {said}. Look at that recording first (its start, its rest, what was "
        "different that day), or repeat it"
        for name, said in hangs.turned
    ]
    if hangs.open:
        names = ", ".join(hangs.open[:5]) + (f" and {len(hangs.open) - 5} more" if len(hangs.open) > 5 else "")
        said.append(
            f"the verdict may hang on each of {names} too: a first look says so, and only the recordings that count "
            "for most were left out in turn. With so many the explanations are nearly tied"
        )
    return tuple(said)


def _odd(gap: Gap, leg: Leg) -> list[str]:
    """Warnings on trials that the nominal leg at its best misses by far more than the others."""
    away = [np.where(t.counts, p - t.measured, np.nan) for t, p in zip(gap.trials, gap.before, strict=True)]
    rms = [np.sqrt([np.nanmean(a[:, j] ** 2) if t.counts[:, j].any() else np.nan for j in range(a.shape[1])])
           for t, a in zip(gap.trials, away, strict=True)]  # fmt: skip
    return odd_trials([trial.recording.name for trial in gap.trials], leg.joint_names, np.array(rms))


def _worse(gap: Gap) -> tuple[str, ...]:
    """A warning where the explanation, good on the trials that it rests on, predicts scored ones no better."""
    before, after = gap.squares["before"].sum(axis=1), gap.squares["after"].sum(axis=1)
    names = [trial.recording.name for trial, b, a in zip(gap.trials, before, after, strict=True) if a > 1.1 * b]
    if not names:
        return ()
    return (
        f"{', '.join(names)}: predicted no better with the explanation than without. Either the trials to learn from "
        "do not fix what matters there (a tip mass shows the leg's overall mass, a tilt its gravity), or something "
        "else is at work; add a trial of that kind to learn from",
    )


def _causes(bench: Workbench, found: Assessed) -> tuple[Cause, ...]:
    """The causes of a hypothesis with their parameters and what the trials leave open of each."""
    if not found.fit.hypothesis:
        return ()
    p = bench.n_tolerance
    deviation = np.sqrt(np.diag(bench.normal(found.fit).covariance))
    made, first = [], p
    for candidate, x in parts(found.fit, p):
        made.append(_cause(candidate, x, deviation[first : first + candidate.size]))
        first += candidate.size
    return tuple(made)


def _cause(candidate: Candidate, x: Array, deviation: Array) -> Cause:
    values, reach = candidate.named(x), {name: [value] for name, value in candidate.named(x).items()}
    low, high = candidate.bounds()
    for k in range(candidate.size):
        for side in (-NORMAL90, NORMAL90):
            moved = x.copy()
            moved[k] = np.clip(moved[k] + side * deviation[k], low[k], high[k])
            for name, value in candidate.named(moved).items():
                reach[name].append(value)
    unit = {parameter.name: parameter.unit for parameter in candidate.effect.parameters}
    found = {}
    for name, value in values.items():
        written = SHOWN.get(unit[name], unit[name])
        ends = (min(reach[name]), max(reach[name]))
        free = name in candidate.shape.free
        found[name] = Estimate(value, written, *ends) if free else Estimate(value, written)
    effect, joint = candidate.key
    return Cause(effect, joint, found)


def _counts(scene: Scene) -> tuple[Cause, ...]:
    """Coarse counts as causes."""
    names = scene.leg.joint_names
    return tuple(
        Cause("encoder_quantisation", names[item.joint], {"step": Estimate(item.step, "deg")}) for item in scene.coarse
    )


def _ranked(scene: Scene, judged: Judged[Fit], gap: Gap) -> tuple[Ranked, ...]:
    made = [
        Ranked(_causes(scene.bench, item)[0], probability, gap.shrink(label(item.keys)))
        for item, probability in judged.singles[:RANKED]
    ]
    made += [Ranked(cause, judged.counts, gap.shrink()) for cause in _counts(scene)]
    # A cause that no fit found alone may still be one of several that are accepted.
    alone = {item.keys[0] for item, _ in judged.singles[:RANKED]}
    for cause, key in zip(_causes(scene.bench, judged.accepted), judged.accepted.keys, strict=True):
        if key not in alone:
            made.append(Ranked(cause, judged.share(key), gap.shrink()))
    return tuple(sorted(made, key=lambda entry: -entry.probability))


def _blamed(judged: Judged[Fit], leg: Leg) -> dict[str, float]:
    """Joint -> probability that a cause sits there."""
    found: dict[str, float] = {}
    for item, probability in judged.singles:
        joint = item.keys[0][1]
        if joint in leg.joint_names:
            found[joint] = found.get(joint, 0.0) + probability
    return found


def _sentence(judged: Judged[Fit], explanations: Sequence[Sequence[Cause]], gap: Gap, held_out: bool) -> str:
    several = len(explanations[0]) > 1
    before, after = gap.figure("before"), gap.figure("after")
    told = Told(
        nominal="the nominal leg",
        error="the error",
        on=scored_on(held_out, "releases"),
        falls_from=angle(before),
        before=before,
        after=after,
        floor=gap.floor,
    )
    texts = [[cause_text(cause) for cause in causes] for causes in explanations]
    probability = 1.0 - judged.none - judged.unknown if several else judged.probability
    return sentence(judged.verdict, texts[0], texts[1:], probability, told)


def _why(verdict: Verdict, explanations: Sequence[Sequence[Cause]]) -> str:
    return what_is_open(verdict, [" and ".join(f"{c.effect} ({c.joint})" for c in causes) for causes in explanations])
