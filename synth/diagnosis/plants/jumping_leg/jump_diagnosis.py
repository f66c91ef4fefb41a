"""The diagnosis of a jumping leg: adapter to ``synth.diagnosis.cause_findings``, and the complete run."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np

from synth.arrays import Array
from synth.diagnosis.cause_findings import find_causes
from synth.diagnosis.diagnosis_result import Cause, Verdict
from synth.diagnosis.effect_shape import ShapedEffect
from synth.diagnosis.hypotheses import Hypotheses
from synth.diagnosis.plant import MenuItem, Plant, StagePredictions
from synth.diagnosis.plants.jumping_leg.jump_across import trends_across_designs
from synth.diagnosis.plants.jumping_leg.jump_bench import JumpBench, JumpFit
from synth.diagnosis.plants.jumping_leg.jump_candidates import candidates
from synth.diagnosis.plants.jumping_leg.jump_data import ANGLE, Jump, pooled_noise, prepare_jumps
from synth.diagnosis.plants.jumping_leg.jump_figures import JumpGaps, Rise, learnt_rises, rises_of, squares
from synth.diagnosis.plants.jumping_leg.jump_menu import forecast, menu
from synth.diagnosis.plants.jumping_leg.jump_predict import JumpPredictor
from synth.diagnosis.plants.jumping_leg.jump_result import JumpGapResult
from synth.diagnosis.plants.jumping_leg.jump_score import ScoredJump, score
from synth.diagnosis.plants.jumping_leg.jump_search import as_designed, search
from synth.diagnosis.plants.jumping_leg.jump_tolerances import MOTOR_TOLERANCES, SHARED_TOLERANCES, JumpTolerances
from synth.diagnosis.plants.jumping_leg.jump_where import locate_gap, missing_hip_torque
from synth.diagnosis.plants.jumping_leg.jump_words import cause_text, other_channels_text, rise_text, wording
from synth.diagnosis.prediction_error import BLOCKS_A_TRIAL, NO_BETTER_RATIO, PredictionErrors
from synth.diagnosis.sentences import ErrorWording
from synth.diagnosis.verdict import Calibration
from synth.errors import UserError
from synth.estimation.information import TrialForecast
from synth.estimation.normal_equations import ReducedNormal
from synth.files.hopper_gap_project import HopperGapProject
from synth.parts.catalogs import Catalogue
from synth.remarks import decisive

# At the end of a push, a cause of another form than the library's leaves a larger error. Decided by
# ``make blind-jumps``, whose few cases determine only what may be left, and call for a cautious temperature.
CALIBRATED_ON_JUMPS = Calibration(
    temperature=5.0,
    per_parameter=3.0,
    misfit=3.0,
    far=np.inf,
    left=0.25,
    left_by_several=0.25,
    doubt=0.06,
    doubt_of_several=0.06,
)


class JumpingLeg(Plant[JumpFit, Jump, ScoredJump]):
    """A leg with gear motors that jumps or pulls itself up."""

    calibration = CALIBRATED_ON_JUMPS

    def __init__(self, project: HopperGapProject, catalogue: Catalogue) -> None:
        jumps, warnings = prepare_jumps(project, catalogue)
        given = tuple(jump for jump in jumps if not jump.trial.held_out)
        held = tuple(jump for jump in jumps if jump.trial.held_out)
        if not given:
            raise UserError("every trial that is not a copy is held out; at least one training trial is needed")
        tolerances = JumpTolerances(project.tolerance, 1 + max(jump.group for jump in jumps))
        leg = project.design.leg
        self.project, self.catalogue = project, catalogue
        self.bench = JumpBench(JumpPredictor(tolerances, leg.bending, leg.body_inertia), given)
        self.scored, self.held_out, self.seed = held or given, bool(held), project.seed
        self.scored_names = tuple(trial.name for trial in self.scored)
        self.warnings, self.n_tolerance = tuple(warnings), tolerances.size

    def search(self, say: Callable[[str], None]) -> Hypotheses[JumpFit]:
        """Every effect that these trials could show, alone and in pairs."""
        return search(self.bench, candidates(self.bench.trials), say)

    @cached_property
    def _designed(self) -> JumpFit:
        return as_designed(self.bench)

    def designed(self) -> JumpFit:
        """The unchanged nominal leg."""
        return self._designed

    def normal(self, fit: JumpFit) -> ReducedNormal:
        """Normal equations at a fit."""
        return self.bench.normal(fit)

    def prior_cost(self, fit: JumpFit) -> float:
        """Of normal tolerances, and of causes that may be far larger than usual."""
        return self.bench.prior_cost(fit.unknowns)

    def remainder(self, fit: JumpFit) -> float:
        """RMS of the whitened residuals, in whose unit the uncertainty of a sample is 1."""
        return self.bench.remainder(fit)

    def bounds(self, fit: JumpFit) -> tuple[Array, Array]:
        """Bounds of the unknowns."""
        return self.bench.bounds(fit.hypothesis)

    def against_design(
        self, candidate: ShapedEffect, values: Mapping[str, float], tolerances: Array
    ) -> dict[str, float]:
        """Shares, friction, damping and inductance against the design's numbers."""
        jumps = self.bench.trials[0].jumps
        return self.bench.predictor.tolerances.against_design(candidate.key[0], values, jumps, tolerances)

    def predict(self, fit: JumpFit, trials: Sequence[Jump]) -> tuple[ScoredJump, ...]:
        """All channels, with the start angle and moment that fit best."""
        return score(self.bench, fit, trials)

    def left_where(
        self, predicted: Sequence[ScoredJump], unread: Sequence[ScoredJump] = ()
    ) -> tuple[Mapping[str, float], Mapping[str, float]]:
        """The remainder by place and phase, over all channels in units of their samples' uncertainty."""
        lacks = [missing_hip_torque(trial, told) for trial, told in zip(self.scored, predicted, strict=True)]
        found = locate_gap(self.scored, predicted, lacks)
        return found.joint, found.phase

    def squares(self, predicted: Sequence[ScoredJump]) -> Array:
        """Squared errors of the upper link's angle."""
        return squares(self.scored, predicted)

    def samples(self, unread: Sequence[ScoredJump] = ()) -> tuple[Array, Array]:
        """Samples of the upper link, and the sum expected from noise alone."""
        lengths = [[len(part) for part in np.array_split(trial.time, BLOCKS_A_TRIAL)] for trial in self.scored]
        counts = np.array(lengths, dtype=float)
        return counts, counts * pooled_noise(self.scored, ANGLE) ** 2

    def wording(self, errors: PredictionErrors) -> ErrorWording:
        """The words of the sentence for the errors."""
        return wording(errors, held_out=self.held_out)

    def cause_text(self, cause: Cause) -> str:
        """The joints have more damping than the design (damping 0.00046 N·m·s/rad)."""
        return cause_text(cause)

    def short_text(self, cause: Cause) -> str:
        """The effect."""
        return cause.effect.replace("_", " ")

    def worse(self, errors: PredictionErrors, moved: PredictionErrors | None, words: str) -> tuple[str, ...]:
        """A warning if the explanation predicts trials no better, and worse than their noise allows."""
        before, after = errors.squares["before"].sum(axis=1), errors.squares["after"].sum(axis=1)
        # Besides, over 20 % above the noise, in squares.
        poor = (after > NO_BETTER_RATIO * before) & (after > 1.5 * errors.noise.sum(axis=1))
        names = [name for name, worse in zip(self.scored_names, poor, strict=True) if worse]
        if not names:
            return ()
        text = f"{', '.join(names)}: predicted no better with {words} than without"
        return (decisive(f"{text}; add a trial of that kind to learn from"),)

    def menu(self) -> Sequence[MenuItem[Jump]]:
        """Jumps under other conditions, other sensors, a lean, a pull-up."""
        return menu(self.project, self.catalogue, self.bench.trials)

    def forecast(self, fit: JumpFit, trial: Jump, covariance: Array) -> TrialForecast | None:
        """What a hypothesis predicts of an imagined trial."""
        return forecast(self.bench, fit, trial, covariance)

    def addendum(self, verdict: Verdict, stages: StagePredictions[JumpFit, ScoredJump]) -> str:
        """The heights of the jumps, if an effect is found; what else shows it, where the angle does not."""
        if verdict != "effect":
            return ""
        takes = stages.errors.shrink().value
        hidden = replace(self.wording(stages.errors), takes=takes).shows_no_share
        others = other_channels_text(self.scored, stages.before, stages.after) if hidden else ""
        return others + rise_text(self.rises(stages))

    def rises(self, stages: StagePredictions[JumpFit, ScoredJump]) -> tuple[Rise, ...]:
        """The rise of the scored jumps, predicted by each stage."""
        return rises_of(self.bench, self.scored, stages.fits, (stages.as_designed, stages.before, stages.after))


def diagnose(
    project: HopperGapProject, catalogue: Catalogue, progress: Callable[[str], None] | None = None
) -> JumpGapResult:
    """Find how the built leg differs from its design.

    Raises
    ------
    UserError : an unknown motor, or a trial that cannot be used.
    """
    plant = JumpingLeg(project, catalogue)
    findings = find_causes(plant, progress or (lambda text: None))
    stages = findings.stages
    gaps = JumpGaps(
        plant.scored,
        stages.as_designed,
        stages.before,
        stages.after,
        stages.errors,
        plant.rises(stages),
        learnt_rises(plant.bench, stages.fits) if plant.held_out else (),
        stages.alone,
    )
    lacks = tuple(missing_hip_torque(trial, told) for trial, told in zip(gaps.trials, gaps.before, strict=True))
    return JumpGapResult(
        **findings.fields(),
        name=project.name,
        where=locate_gap(gaps.trials, gaps.before, lacks),
        gaps=gaps,
        lacks=lacks,
        across=trends_across_designs(gaps),
        held_out=plant.held_out,
        noise=pooled_noise(gaps.trials, ANGLE),
        unknowns=_tolerances(plant.bench, findings.judged.accepted.fit),
    )


def _tolerances(bench: JumpBench, fit: JumpFit) -> dict[str, float]:
    """The estimated values of the design's numbers, in standard deviations of their tolerances."""
    names = [
        *SHARED_TOLERANCES,
        *(f"{name} {k + 1}" for k in range(bench.predictor.tolerances.motors) for name in MOTOR_TOLERANCES),
    ]
    return dict(zip(names, fit.unknowns[: bench.n_tolerance].tolist(), strict=True))
