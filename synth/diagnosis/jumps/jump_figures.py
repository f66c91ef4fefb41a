"""How far: misses of the upper link's angle on scored trials, and how high each model jumps there."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array
from synth.diagnosis.jumps.jump_data import ANGLE, Jump, pooled
from synth.diagnosis.jumps.jump_score import Scored, score, score_in_turn
from synth.diagnosis.jumps.jump_search import JumpAssessed, JumpSearch, as_designed
from synth.diagnosis.jumps.jump_solve import JumpBench, JumpFit
from synth.diagnosis.prediction_error import BLOCKS, Misses, label
from synth.jump.jump_runs import compiled_jump
from synth.jump.outcomes import APEX, LANDED_AGAIN, STATUS


@dataclass(frozen=True)
class Rise:
    """How far the centre of mass rises over the crouch in one trial, m; None where no model or plate tells."""

    measured: float | None
    as_designed: float | None
    before: float | None
    after: float | None


@dataclass(frozen=True)
class JumpGaps:
    """Scored trials with what each stage predicts; ``rises`` a trial.

    ``learnt`` : trials to learn from that are not scored, with their rises: of these ``before`` and ``after`` are fits.
    """

    trials: tuple[Jump, ...]
    as_designed: tuple[Scored, ...]
    before: tuple[Scored, ...]
    after: tuple[Scored, ...]
    misses: Misses
    rises: tuple[Rise, ...]
    learnt: tuple[tuple[Jump, Rise], ...] = ()


def measured_gaps(
    bench: JumpBench, held: Sequence[Jump], found: JumpSearch, accepted: JumpAssessed,
    others: Sequence[JumpAssessed], seed: int,
) -> JumpGaps:  # fmt: skip
    """Predict the scored trials (those held out, else each by the others) as designed, before, after, by the others."""
    trials = tuple(held) or bench.trials
    designed = as_designed(bench)

    def told(fit: JumpFit) -> tuple[Scored, ...]:
        return score(bench, fit, trials) if held else score_in_turn(bench, fit)

    nominal = score(bench, designed, trials)
    before = told(found.none.fit)
    after = before if accepted is found.none else told(accepted.fit)
    squares = {name: _squares(trials, scored) for name, scored in
               (("as_designed", nominal), ("before", before), ("after", after))}  # fmt: skip
    for other in others:
        squares[label(other.keys)] = squares["after"] if other is accepted else _squares(trials, told(other.fit))
    counts = np.array([[len(part) for part in np.array_split(trial.time, BLOCKS)] for trial in trials], dtype=float)
    misses = Misses(squares, counts, counts * pooled(trials, ANGLE) ** 2, seed)
    stages = (designed, found.none.fit, accepted.fit)
    rises = tuple(
        _rise(bench, trial, stages, [item[i] for item in (nominal, before, after)]) for i, trial in enumerate(trials)
    )
    learnt = tuple(
        (trial, _rise(bench, trial, stages, [Scored({}, fit.own[i]) for fit in stages]))
        for i, trial in enumerate(bench.trials if held else ())
    )
    return JumpGaps(trials, nominal, before, after, misses, rises, learnt)


def _squares(trials: Sequence[Jump], scored: Sequence[Scored]) -> Array:
    """(n_trial, BLOCKS) summed squared misses of the angle, rad^2."""
    found = []
    for trial, told in zip(trials, scored, strict=True):
        away = np.nan_to_num(told.channels[ANGLE] - trial.measured[ANGLE], nan=np.pi)
        found.append([float(part @ part) for part in np.array_split(away, BLOCKS)])
    return np.array(found)


def _rise(bench: JumpBench, trial: Jump, fits: Sequence[JumpFit], told: Sequence[Scored]) -> Rise:
    measured = None if trial.seen is None else trial.seen.rise
    if trial.torque is not None or trial.leaning:
        return Rise(measured, None, None, None)
    rises: list[float | None] = []
    for fit, scored in zip(fits, told, strict=True):
        made = bench.predictor.columns(trial, fit.hypothesis, fit.unknowns[:, None], scored.own[:, None])
        column = compiled_jump(bench.predictor.bending).run(made.workspace())[:, 0]
        rises.append(float(column[APEX]) if column[STATUS] == LANDED_AGAIN else 0.0)
    return Rise(measured, *rises)
