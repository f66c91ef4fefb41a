"""Prediction errors: the upper link's angle on scored trials, and the height of the jumps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from synth.arrays import Array
from synth.diagnosis.plants.jumping_leg.jump_bench import JumpBench, JumpFit
from synth.diagnosis.plants.jumping_leg.jump_data import ANGLE, Jump
from synth.diagnosis.plants.jumping_leg.jump_score import ScoredJump
from synth.diagnosis.prediction_error import BLOCKS_A_TRIAL, PredictionErrors
from synth.jump.jump_runs import compiled_jump
from synth.jump.outcomes import APEX, known_values


@dataclass(frozen=True)
class Rise:
    """Rise of the centre of mass over the crouch in one trial, m; None if no model or plate gives it."""

    measured: float | None
    as_designed: float | None
    before: float | None
    after: float | None


@dataclass(frozen=True)
class JumpGaps:
    """Scored trials with every stage's prediction; ``rises`` one per trial.

    ``learnt`` : training trials that are not scored, with their rises; their ``before`` and ``after`` are fits.
    ``alone`` : label of a single cause -> the scored trials with it.
    """

    trials: tuple[Jump, ...]
    as_designed: tuple[ScoredJump, ...]
    before: tuple[ScoredJump, ...]
    after: tuple[ScoredJump, ...]
    errors: PredictionErrors
    rises: tuple[Rise, ...]
    learnt: tuple[tuple[Jump, Rise], ...] = ()
    alone: Mapping[str, tuple[ScoredJump, ...]] = field(default_factory=dict)


def rises_of(
    bench: JumpBench, trials: Sequence[Jump], fits: Sequence[JumpFit], stages: Sequence[Sequence[ScoredJump]]
) -> tuple[Rise, ...]:
    """One per trial, from the fits of the three stages and their predictions."""
    return tuple(_rise(bench, trial, fits, [stage[i] for stage in stages]) for i, trial in enumerate(trials))


def learnt_rises(bench: JumpBench, fits: Sequence[JumpFit]) -> tuple[tuple[Jump, Rise], ...]:
    """The rises of the training trials, from the fits themselves."""
    return tuple(
        (trial, _rise(bench, trial, fits, [ScoredJump({}, fit.own[i]) for fit in fits]))
        for i, trial in enumerate(bench.trials)
    )


def squares(trials: Sequence[Jump], scored: Sequence[ScoredJump]) -> Array:
    """(n_trial, BLOCKS) summed squared errors of the angle, rad^2."""
    found = []
    for trial, predicted in zip(trials, scored, strict=True):
        away = np.nan_to_num(predicted.channels[ANGLE] - trial.measured[ANGLE], nan=np.pi)
        found.append([float(part @ part) for part in np.array_split(away, BLOCKS_A_TRIAL)])
    return np.array(found)


def _rise(bench: JumpBench, trial: Jump, fits: Sequence[JumpFit], every: Sequence[ScoredJump]) -> Rise:
    measured = None if trial.seen is None else trial.seen.rise
    if trial.torque is not None or trial.leaning:
        return Rise(measured, None, None, None)
    rises: list[float | None] = []
    for fit, scored in zip(fits, every, strict=True):
        made = bench.predictor.columns(trial, fit.hypothesis, fit.unknowns[:, None], scored.own[:, None])
        # Of a leg that does not lift off too: it stands up, and its centre of mass rises.
        (rise,) = known_values(compiled_jump(bench.predictor.bending).run(made.workspace()), APEX)
        rises.append(None if np.isnan(rise) else float(rise))
    return Rise(measured, *rises)
