"""The diagnosis of a swinging chain: adapter to ``synth.diagnosis.cause_findings``, and the complete run."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial, angle_trial, spread_over_kinds
from synth.diagnosis.cause_findings import Findings, find_causes
from synth.diagnosis.companions import with_companions
from synth.diagnosis.diagnosis_result import Cause, Verdict
from synth.diagnosis.effect_shape import ShapedEffect
from synth.diagnosis.encoder_counts import coarse_counts, counts_matter, noise_as_read, round_to_counts, usual_noise
from synth.diagnosis.encoder_transitions import with_edges
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.held_out import moved_within_uncertainty
from synth.diagnosis.hypotheses import Hypotheses, TrialErrors
from synth.diagnosis.influence import verdict_dependence
from synth.diagnosis.lanes import PredictorCache
from synth.diagnosis.odds import far_share
from synth.diagnosis.plant import MenuItem, Plant, StagePredictions
from synth.diagnosis.plants.swinging_chain.chain_candidates import candidates, natural_sizes_of
from synth.diagnosis.plants.swinging_chain.chain_figures import joint_errors, joint_odds, squares, trial_gaps
from synth.diagnosis.plants.swinging_chain.chain_menu import forecast, menu, variations
from synth.diagnosis.plants.swinging_chain.chain_predictor import Predictor
from synth.diagnosis.plants.swinging_chain.chain_result import FreeTorque, GapResult
from synth.diagnosis.plants.swinging_chain.chain_where import locate_gap, locate_remainder, missing_torque
from synth.diagnosis.plants.swinging_chain.clock_doubt import doubting_clock
from synth.diagnosis.plants.swinging_chain.column_slips import slips_of
from synth.diagnosis.plants.swinging_chain.command_menu import has_servo
from synth.diagnosis.plants.swinging_chain.diagnosed_leg import diagnosed_leg
from synth.diagnosis.plants.swinging_chain.free_torque import free_torque_sentence, free_torques
from synth.diagnosis.plants.swinging_chain.held_starts import doubt_of_held_starts, held_start_remarks, held_starts
from synth.diagnosis.plants.swinging_chain.left_out_sentences import left_out_sentences
from synth.diagnosis.plants.swinging_chain.moved_numbers import moved_numbers, with_moved_numbers
from synth.diagnosis.plants.swinging_chain.pieces import cut_into_pieces, cut_sentence, join_pieces, whole_recordings
from synth.diagnosis.plants.swinging_chain.replaced_effects import with_replaced_effects
from synth.diagnosis.plants.swinging_chain.slips import Slip, doubt_of_slips, doubting_slips
from synth.diagnosis.plants.swinging_chain.smeared_ends import without_smeared_ends
from synth.diagnosis.plants.swinging_chain.stated_candidates import search_from_stated
from synth.diagnosis.plants.swinging_chain.stated_numbers import against_design
from synth.diagnosis.plants.swinging_chain.tolerance_words import cause_words
from synth.diagnosis.plants.swinging_chain.trial_legs import TrialLegs
from synth.diagnosis.plants.swinging_chain.trial_order import as_listed, in_canonical_order
from synth.diagnosis.poor_trials import no_better
from synth.diagnosis.prediction_error import PredictionErrors
from synth.diagnosis.score import score
from synth.diagnosis.sentences import ErrorWording, angle_text, scored_on
from synth.diagnosis.settled import settle_leading
from synth.diagnosis.unseen import with_unseen_errors
from synth.diagnosis.verdict import Judgement, open_explanations, rivals_with_doubt, with_coarse_counts
from synth.diagnosis.workbench import Workbench
from synth.errors import UserError
from synth.estimation.information import RIVALS, TrialForecast
from synth.estimation.intervals import Estimate
from synth.estimation.linearisation import LinearisedNormal
from synth.files.next_command import NextCommand
from synth.files.tolerance import Tolerance
from synth.fit.copies import told_copies
from synth.fit.odd_trials import odd_trials
from synth.fit.recordings import joints_by_current, recordings, sentences_on_reading
from synth.fit.sensor_noise import estimate_sensor
from synth.remarks import decisive
from synth.swing.leg_model import Leg
from synth.swing.stated_effects import COUNTS
from synth.swing.tolerances import Tolerances

if TYPE_CHECKING:
    from synth.diagnosis.encoder_counts import CoarseChannel
    from synth.files.trial_list import Trial

MOST_TRAINING = 200  # trials: what they share is then known 14 times as well as from one; .5 s of a processor each
EFFECTIVE_SAMPLES = 50.0  # samples per trial and joint that count as independent, see Workbench
# Rivals that a command should separate, and the weight of those that the trials reject: few trials may be wrong.
MOST_RIVALS, DOUBT_SHARE = 6, 0.3


@dataclass(frozen=True)
class Scene:
    """The data that all stages of a diagnosis share.

    ``given``, ``held`` : recordings, or pieces of them; ``scored`` too. Figures are of the ``whole_recordings``.
    """

    leg: Leg
    tolerances: Tolerances
    bench: Workbench
    given: tuple[AngleTrial, ...]
    held: tuple[AngleTrial, ...]
    coarse: tuple[CoarseChannel, ...]
    usual: Array  # (n,) rad, noise without coarse counts
    seed: int
    legs: TrialLegs
    accuracy: float = 0.0  # rad, a gap below it does not matter
    next_command: NextCommand = field(default_factory=NextCommand)  # limits of a suggested command

    @property
    def scored(self) -> tuple[AngleTrial, ...]:
        """The trials used for the figures of the gap."""
        return self.held or self.given

    @property
    def motion(self) -> float:
        """RMS of the motion about its mean over the noise, of all joints that are free."""
        squares = [np.nanvar(t.measured[:, t.free], 0) / self.usual[t.free] ** 2 for t in whole_recordings(self.given)]
        return float(np.sqrt(np.mean(np.concatenate(squares))))

    def motion_trusted(self, share: float) -> float:
        """The motion over the noise; if an accuracy is stated, the motion of which it is this ``share``."""
        stated = self.accuracy / (share * float(np.sqrt(np.mean(self.usual**2))))
        return stated if self.accuracy > 0.0 else self.motion


class SwingingChain(Plant[EvaluatedHypothesis, AngleTrial, Array]):
    """A leg of links that swings from releases, or is driven by known torques."""

    def __init__(self, scene: Scene, warnings: tuple[str, ...], slips: Sequence[Slip] = ()) -> None:
        self.scene, self.bench, self.warnings, self.seed = scene, scene.bench, warnings, scene.seed
        self.scored, self.held_out, self.n_tolerance = scene.scored, bool(scene.held), scene.bench.n_tolerance
        self.slips, self.whole = slips, whole_recordings(scene.scored)
        self.scored_names = tuple(trial.recording.name for trial in self.whole)
        self.accuracy, self.motion = scene.accuracy, scene.motion_trusted(self.calibration.accuracy)
        self.most_rivals = MOST_RIVALS if has_servo(scene.leg, scene.given) else RIVALS
        self.own_motion, self.independent = scene.motion, EFFECTIVE_SAMPLES * len(scene.leg.joints)
        self._free: dict[int, tuple[EvaluatedHypothesis, tuple[FreeTorque, ...]]] = {}  # a fit keeps its identity
        self.direct_causes = tuple(
            Cause(COUNTS, scene.leg.joint_names[item.joint], {"step": Estimate(item.step, "deg")})
            for item in scene.coarse
        )

    def search(self, say: Callable[[str], None]) -> Hypotheses[EvaluatedHypothesis]:
        """Every effect at every place where it could be visible, alone and with others."""
        leg, given, bench, odds = self.scene.leg, self.scene.given, self.bench, self.calibration
        every = candidates(leg, given, natural_sizes_of(leg, given), self.scene.legs)
        found = search_from_stated(bench, every, odds, say)
        found, done = settle_leading(bench, found, odds)
        say("trials left out")
        found = with_unseen_errors(bench, found, odds)
        say("small causes beside the leading ones")
        return settle_leading(bench, with_companions(bench, found, odds), odds, done)[0]

    def designed(self) -> EvaluatedHypothesis:
        """The unchanged nominal leg."""
        return EvaluatedHypothesis((), np.zeros(self.n_tolerance), ())

    def normal(self, fit: EvaluatedHypothesis) -> LinearisedNormal:
        """Normal equations at a fit."""
        return self.bench.normal(fit)

    def bounds(self, fit: EvaluatedHypothesis) -> tuple[Array, Array]:
        """Bounds of the unknowns."""
        return self.bench.bounds(fit.hypothesis)

    def against_design(
        self, candidate: ShapedEffect, values: Mapping[str, float], tolerances: Array
    ) -> dict[str, float]:
        """Shares, rates and angles against the design's numbers."""
        return against_design(candidate.key, values, self.scene.leg, self.scene.tolerances, tolerances)

    def predict(self, fit: EvaluatedHypothesis, trials: Sequence[AngleTrial]) -> tuple[Array, ...]:
        """Rotations (m, n) rad in the sense of q, with the best-fitting initial states."""
        return tuple(prediction for prediction, _ in score(self.bench, fit, self._begun(trials)))

    def within_uncertainty(self, fit: EvaluatedHypothesis) -> tuple[Array, ...]:
        """Predictions of the held-out trials, which the hypothesis follows as far as the other trials let it."""
        begun, covariance = self._begun(self.scored), self.covariance(fit)
        return self.predict(moved_within_uncertainty(self.bench, fit, begun, covariance), self.scored)

    def _begun(self, trials: Sequence[AngleTrial]) -> list[AngleTrial]:
        """Trials from whose coarse counts the initial states can be found."""
        return [with_edges(trial, self.scene.coarse, self.scene.usual) for trial in trials]

    def as_read(self, predicted: tuple[Array, ...]) -> tuple[Array, ...]:
        """Predictions as channels with coarse counts would read them."""
        return tuple(round_to_counts(t, p, self.scene.coarse) for t, p in zip(self.scored, predicted, strict=True))

    def left_where(
        self, predicted: Sequence[Array], unread: Sequence[Array] = ()
    ) -> tuple[dict[str, float], dict[str, float]]:
        """The remainder by joint and phase, in squared degrees above the noise."""
        noise, usual = self._noise(unread), self.scene.usual
        return locate_remainder(self.scene.leg, self.whole, join_pieces(self.scored, predicted), noise, usual)

    def freely(self, found: Hypotheses[EvaluatedHypothesis]) -> TrialErrors | None:
        """The remainder with the most effective free torque; None where causes reach the noise: nothing lacks."""
        if far_share([found.none, *found.singles, *found.several]) == 0.0:
            return None
        torques = self.free_torques(found.none.fit)
        return torques[0].unseen if torques else None

    def squares(self, predicted: Sequence[Array]) -> Array:
        """Squared errors of the rotations, recording by recording."""
        return squares(self.whole, join_pieces(self.scored, predicted))

    def samples(self, unread: Sequence[Array] = ()) -> tuple[Array, Array]:
        """Samples that count, and the sum expected from noise alone; of ``unread`` predictions, as coarse counts do."""
        counts = squares(self.whole, [np.ones_like(t.measured) + t.measured for t in self.whole])
        each = zip(self.whole, self._noise(unread), strict=True)
        return counts, squares(self.whole, [trial.measured + noise for trial, noise in each])

    def _noise(self, unread: Sequence[Array]) -> tuple[Array, ...]:
        """(m, n) rad, the RMS noise of each whole trial's readings; of ``unread`` predictions, about these as read."""
        coarse, usual = self.scene.coarse, self.scene.usual
        if not (coarse and unread):
            return tuple(np.broadcast_to(usual, trial.measured.shape) for trial in self.whole)
        return join_pieces(self.scored, noise_as_read(self.scored, unread, coarse, usual))

    def with_direct_causes(self, judged: Judgement[EvaluatedHypothesis]) -> Judgement[EvaluatedHypothesis]:
        """The verdict with coarse counts included, where they matter."""
        left = self.predict(judged.accepted.fit, self.scored) if self.scene.coarse else ()
        return with_coarse_counts(judged, coarse=counts_matter(self.scored, left, self.scene.coarse))

    def shown(
        self, stages: StagePredictions[EvaluatedHypothesis, Array]
    ) -> StagePredictions[EvaluatedHypothesis, Array]:
        """The predictions recording by recording."""
        as_designed, before, after = (
            join_pieces(self.scored, each) for each in (stages.as_designed, stages.before, stages.after)
        )
        alone = {cause: join_pieces(self.scored, predicted) for cause, predicted in stages.alone.items()}
        return replace(stages, as_designed=as_designed, before=before, after=after, alone=alone)

    def remarks(self, stages: StagePredictions[EvaluatedHypothesis, Array]) -> tuple[str, ...]:
        """Trials whose error by the nominal leg's best fit is far larger than the others'."""
        rms = joint_errors(self.whole, join_pieces(self.scored, stages.before))
        return tuple(odd_trials(self.scored_names, self.scene.leg.joint_names, rms))

    def doubts(
        self, found: Hypotheses[EvaluatedHypothesis], judged: Judgement[EvaluatedHypothesis], motion: float
    ) -> tuple[tuple[str, ...], float]:
        """Recordings that the verdict depends on, and the probability that a further one changes it."""
        hangs = verdict_dependence(self.bench, found, judged, self.calibration, self.freely(found), motion)
        slip = doubt_of_slips(self.slips, self.bench, judged.accepted.fit, (*self.scene.given, *self.scene.held))
        return hangs.warnings(), max(hangs.chance, doubt_of_held_starts(self.warnings), slip)

    def wording(self, errors: PredictionErrors) -> ErrorWording:
        """The words of the sentence for the errors."""
        before, after = errors.figure("before"), errors.figure("after")
        driven = any(trial.recording.driven for trial in self.whole)
        return ErrorWording(
            nominal="the nominal leg",
            error="the error",
            on=scored_on("trials" if driven else "releases", held_out=self.held_out),
            falls_from=angle_text(before),
            before=before,
            after=after,
            floor=errors.floor,
            released=not driven,
        )

    def cause_text(self, cause: Cause) -> str:
        """The knee has dry friction (torque 0.052 N·m)."""
        return cause_words(cause, self.scene.leg, self.scene.tolerances)

    def free_torques(self, nominal: EvaluatedHypothesis) -> tuple[FreeTorque, ...]:
        """Free-form torques with the nominal leg's best fit, computed once for each."""
        if id(nominal) not in self._free:
            leg, sizes = self.scene.leg, natural_sizes_of(self.scene.leg, self.scene.given)
            at_best = self.scene.tolerances.leg(leg, nominal.unknowns)
            self._free[id(nominal)] = nominal, free_torques(leg, at_best, self.bench, nominal, sizes)
        return self._free[id(nominal)][1]

    def lacking(self, findings: Findings[EvaluatedHypothesis, Array]) -> bool:
        """Whether the library leaves something that a torque of free shape may describe."""
        return findings.judged.verdict == "unknown" or self.freely(findings.found) is not None

    def addendum(self, verdict: Verdict, stages: StagePredictions[EvaluatedHypothesis, Array]) -> str:
        """Place and shape of the missing torque, if no effect of the library explains it."""
        return free_torque_sentence(self.free_torques(stages.fits[1])) if verdict == "unknown" else ""

    def short_text(self, cause: Cause) -> str:
        """Effect and joint."""
        return f"{cause.effect.replace('_', ' ')} ({cause.joint})"

    def menu(self) -> Sequence[MenuItem[AngleTrial]]:
        """Releases, locked joints, added masses, tilts and torques."""
        return menu(self.scene.leg, self.bench, self.scene.given, self.scene.next_command)

    def variations(self, best: Sequence[MenuItem[AngleTrial]], number: int) -> Sequence[MenuItem[AngleTrial]]:
        """Commands of a servo-driven leg drawn at random, then varied."""
        return variations(self.scene.leg, self.bench, self.scene.given, self.scene.next_command, best, number)

    def rivals(self, judged: Judgement[EvaluatedHypothesis]) -> list[tuple[EvaluatedHypothesis, float]]:
        """For a servo-driven leg more than usual: a search finds a command that separates all."""
        if not has_servo(self.scene.leg, self.scene.given):
            return super().rivals(judged)
        return rivals_with_doubt(judged, DOUBT_SHARE, self.most_rivals)

    def present_odds(self, judged: Judgement[EvaluatedHypothesis]) -> list[tuple[EvaluatedHypothesis, float]]:
        """Without the doubt; with it where the cause is unknown: the trials then reject no cause for another."""
        known = judged.verdict != "unknown" and has_servo(self.scene.leg, self.scene.given)
        return open_explanations(judged) if known else []

    def remainder(self, fit: EvaluatedHypothesis) -> float:
        """RMS of the whitened residuals, in whose unit a sample of the noise is 1."""
        squares = sum(float(residual @ residual) for residual in fit.residuals)
        return max(float(np.sqrt(squares / self.bench.total)), 1.0)

    def forecast(self, fit: EvaluatedHypothesis, trial: AngleTrial, covariance: Array) -> TrialForecast | None:
        """What a hypothesis predicts of an imagined trial."""
        _, kept = self._forecasts.setdefault(id(fit), (fit, {}))
        return forecast(self.scene.leg, self.bench, fit, trial, covariance, kept)

    @cached_property
    def _forecasts(self) -> dict[int, tuple[EvaluatedHypothesis, PredictorCache]]:
        """What forecasts by one fit have in common; the fit is kept for its identity."""
        return {}

    def worse(self, errors: PredictionErrors, moved: PredictionErrors | None, words: str) -> tuple[str, ...]:
        """Warnings if the explanation fits its own trials but predicts scored ones no better, and why."""
        return tuple(map(decisive, no_better(self.scored_names, errors, moved, words)))


def diagnose(
    leg: Leg,
    trials: Sequence[Trial],
    tolerance: Tolerance,
    *,
    seed: int = 0,
    noise: Mapping[str, float] | None = None,
    accuracy: float = 0.0,
    next_command: NextCommand | None = None,
    progress: Callable[[str], None] | None = None,
) -> GapResult:
    """Find how the built leg differs from the nominal one.

    Parameters
    ----------
    leg : as designed; every joint has a spring (its rate may be zero).
    trials : recordings of the built leg; held-out ones are used for scoring only.
    tolerance : standard deviations of manufacturing and measurement.
    noise : joint -> known RMS noise of its sensor, rad; estimated from the readings if not given.
    accuracy : rad; a smaller gap does not matter.
    next_command : limits of a suggested command; as in the trials so far if not given.
    progress : called with the current stage.

    Raises
    ------
    UserError : every trial is held out, or a trial cannot be used.
    """
    scene, warnings = scene_of(leg, in_canonical_order(trials), tolerance, seed, noise)
    scene = replace(scene, accuracy=accuracy, next_command=next_command or NextCommand())
    plant = SwingingChain(scene, warnings, slips_of(leg, trials, scene.bench, scene.given))
    findings = doubting_slips(plant.slips, find_causes(plant, progress or (lambda text: None)))
    findings = doubting_clock(leg, findings, trials, lambda new: scene_of(leg, new, tolerance, seed, noise)[0].bench)
    errors, shown, tolerances = findings.stages.errors, plant.shown(findings.stages), scene.tolerances
    nominal = tolerances.leg(leg, findings.found.none.fit.unknowns)
    # The torque of accepted effects is missing from the leg without them, not from one whose dampers replace them.
    bare = tolerances.leg(leg, findings.likeliest.unknowns[: tolerances.size])
    missing = [missing_torque(bare, trial) for trial in plant.whole]
    gaps = trial_gaps(nominal, plant.whole, shown, missing, held_out=plant.held_out, noise=scene.usual)
    moved = moved_numbers(plant, leg, tolerances, findings.best, errors)
    return GapResult(
        **with_moved_numbers(with_replaced_effects(findings.fields(), leg, trials), moved),
        leg=leg,
        where=locate_gap(nominal, plant.whole, shown.before, scene.usual, missing, joint_odds(findings.odds, leg)),
        as_designed=errors.figure("as_designed"),
        before=errors.figure("before"),
        after=errors.figure("after"),
        noise_floor=errors.floor,
        shrink=errors.shrink(),
        best_possible=errors.best_possible,
        noise=dict(zip(leg.joint_names, scene.usual.tolist(), strict=True)),
        scored_on=as_listed(plant.scored_names, plant.scored_names, trials),
        trials=as_listed(plant.scored_names, gaps, trials),
        diagnosed=diagnosed_leg(leg, tolerances, findings.of_diagnosed, scene.coarse if findings.explained else ()),
        free_torque=plant.free_torques(findings.found.none.fit) if plant.lacking(findings) else (),
        moved_numbers=moved,
    )


def scene_of(
    leg: Leg, trials: Sequence[Trial], tolerance: Tolerance, seed: int, noise: Mapping[str, float] | None = None
) -> tuple[Scene, tuple[str, ...]]:
    """Prepared trials without copies, with noise and counts; ``noise`` : a joint's known noise, rad."""
    made, smeared = without_smeared_ends(leg, recordings(leg, trials, ()))
    left_out, copied = told_copies(made, [trial.held_out for trial in trials])
    kept = [(r, t.held_out) for k, (r, t) in enumerate(zip(made, trials, strict=True)) if k not in left_out]
    prepared = [angle_trial(recording, held_out=held) for recording, held in kept]
    learnt, spare = spread_over_kinds([trial for trial in prepared if not trial.held_out], MOST_TRAINING)
    if not learnt:
        raise UserError("every trial is held out; at least one training trial is needed")
    held = (*(trial for trial in prepared if trial.held_out), *(replace(trial, held_out=True) for trial in spare))
    found = estimate_sensor([trial.recording for trial in learnt]).stated(leg.joint_names, noise)
    coarse = coarse_counts(found)
    tolerances = Tolerances.of(leg, tolerance, joints_by_current(made))
    legs = TrialLegs.of(leg, [recording.leg for recording in made])
    predictor = Predictor(leg, tolerances, trial_legs=legs)
    given, held = cut_into_pieces(leg, predictor, learnt), cut_into_pieces(leg, predictor, held)
    warnings = [*held_start_remarks(held_starts(leg, made, found, tolerances)), *sentences_on_reading(made), *copied]
    cut = filter(None, [cut_sentence([*given, *held])])
    warnings += [*smeared, *found.doubts, *left_out_sentences(leg, learnt, len(spare), legs), *cut]
    usual = usual_noise(found, coarse)
    bench = Workbench(predictor, tuple(with_edges(trial, coarse, usual) for trial in given), usual, EFFECTIVE_SAMPLES)
    return Scene(leg, tolerances, bench, given, held, coarse, usual, seed, legs), tuple(warnings)
