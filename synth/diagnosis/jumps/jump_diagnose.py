"""The diagnosis of a jumping leg from end to end."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from synth.arrays import Array
from synth.diagnosis.jumps.jump_across import across
from synth.diagnosis.jumps.jump_candidates import JumpCandidate, candidates
from synth.diagnosis.jumps.jump_data import ANGLE, Jump, pooled, prepared
from synth.diagnosis.jumps.jump_experiment import menu, next_experiment
from synth.diagnosis.jumps.jump_figures import JumpGaps, measured_gaps
from synth.diagnosis.jumps.jump_predict import JumpPredictor
from synth.diagnosis.jumps.jump_result import JumpGapResult
from synth.diagnosis.jumps.jump_search import search
from synth.diagnosis.jumps.jump_solve import JumpBench, JumpFit
from synth.diagnosis.jumps.jump_tolerances import OF_MOTOR, SHARED, JumpTolerances
from synth.diagnosis.jumps.jump_verdict import judge_jumps
from synth.diagnosis.jumps.jump_where import missing, where
from synth.diagnosis.jumps.jump_words import sentence
from synth.diagnosis.prediction_error import label
from synth.diagnosis.result import Cause, Ranked, Verdict
from synth.diagnosis.sentences import what_is_open
from synth.diagnosis.verdict import open_explanations
from synth.errors import UserError
from synth.files.hopper_gap_project import HopperGapProject
from synth.fit.fit_result import Estimate
from synth.fit.unknowns import NORMAL90
from synth.parts.catalogs import Catalogue

SHOWN = {"H": "mH", "N/m": "N/m"}  # units that people read better


def diagnose(
    project: HopperGapProject, catalogue: Catalogue, progress: Callable[[str], None] | None = None
) -> JumpGapResult:
    """Say what the built leg does that its design does not.

    Raises
    ------
    UserError : an unknown motor, or a trial that cannot be used.
    """
    say = progress or (lambda text: None)
    jumps, warnings = prepared(project, catalogue)
    given = tuple(jump for jump in jumps if not jump.trial.held_out)
    held = tuple(jump for jump in jumps if jump.trial.held_out)
    if not given:
        raise UserError("every trial that is not a copy is held out; at least one must be there to learn from")
    bench = _bench(project, jumps, given)
    found = search(bench, candidates(given), say)
    judged = judge_jumps(found)
    accepted = judged.accepted
    say("how far it shrinks")
    gaps = measured_gaps(bench, held, found, accepted, [item for item, _ in judged.singles], project.seed)
    lacks = tuple(missing(trial, told) for trial, told in zip(gaps.trials, gaps.before, strict=True))
    explained = judged.verdict in ("effect", "tie")
    causes = _causes(bench, accepted.fit) if explained else ()
    tied = tuple(_causes(bench, rival.fit) for rival in judged.tied)
    ranked = tuple(
        Ranked(_causes(bench, item.fit)[0], chance, gaps.misses.shrink(label(item.keys)))
        for item, chance in judged.singles
    )
    say("what next")
    best = 1.0 - judged.none - judged.unknown if len(causes) > 1 else judged.probability
    return JumpGapResult(
        name=project.name,
        verdict=judged.verdict,
        sentence=sentence(judged.verdict, causes, tied, best, gaps, bool(held)),
        explanation=causes,
        ranked=ranked,
        probability_none=judged.none,
        probability_unknown=judged.unknown,
        tied=tied,
        where=where(gaps.trials, gaps.before, lacks),
        gaps=gaps,
        lacks=lacks,
        across=across(gaps),
        held_out=bool(held),
        noise=pooled(gaps.trials, ANGLE),
        next_experiment=next_experiment(
            bench, open_explanations(judged), menu(project, catalogue, given), _why(judged.verdict, (causes, *tied))
        ),
        unknowns=_tolerances(bench, accepted.fit),
        warnings=(*warnings, *(_worse(gaps) if explained else ())),
    )


def _bench(project: HopperGapProject, jumps: Sequence[Jump], given: tuple[Jump, ...]) -> JumpBench:
    tolerances = JumpTolerances(project.tolerance, 1 + max(jump.group for jump in jumps))
    leg = project.design.leg
    return JumpBench(JumpPredictor(tolerances, leg.bending, leg.body_inertia), given)


def _causes(bench: JumpBench, fit: JumpFit) -> tuple[Cause, ...]:
    """The causes of a fit with their parameters and what the trials leave open of each."""
    if not fit.hypothesis:
        return ()
    deviation = np.sqrt(np.diag(bench.normal(fit).covariance))
    made, first = [], bench.n_tolerance
    for candidate in fit.hypothesis:
        part = slice(first, first + candidate.size)
        made.append(_cause(candidate, fit.unknowns[part], np.asarray(deviation[part])))
        first += candidate.size
    return tuple(made)


def _cause(candidate: JumpCandidate, x: Array, deviation: Array) -> Cause:
    low, high = candidate.bounds()
    found = {}
    for k, name in enumerate(candidate.shape.free):
        index = candidate.effect.index(name)
        points = np.repeat(x[:, None], 3, axis=1)
        points[k, 1:] = np.clip(x[k] + NORMAL90 * deviation[k] * np.array([-1.0, 1.0]), low[k], high[k])
        value, *ends = candidate.values(points)[index].tolist()
        unit = candidate.effect.parameters[index].unit
        found[name] = Estimate(value, SHOWN.get(unit, unit), min(value, *ends), max(value, *ends))
    effect, place = candidate.key
    return Cause(effect, place, found)


def _why(verdict: Verdict, explanations: Sequence[Sequence[Cause]]) -> str:
    names = [" and ".join(cause.effect.replace("_", " ") for cause in causes) for causes in explanations]
    return what_is_open(verdict, names)


def _worse(gaps: JumpGaps) -> tuple[str, ...]:
    """A warning where the explanation predicts scored trials no better, and not as well as their noise allows."""
    before, after = gaps.misses.squares["before"].sum(axis=1), gaps.misses.squares["after"].sum(axis=1)
    poor = (after > 1.1 * before) & (after > 1.5 * gaps.misses.noise.sum(axis=1))
    names = [trial.name for trial, worse in zip(gaps.trials, poor, strict=True) if worse]
    if not names:
        return ()
    return (
        f"{', '.join(names)}: predicted no better with the explanation than without; add a trial of that kind to "
        "learn from",
    )


def _tolerances(bench: JumpBench, fit: JumpFit) -> dict[str, float]:
    """Where the design's numbers are taken to be, in deviations of their tolerances."""
    names = [*SHARED, *(f"{name} {k + 1}" for k in range(bench.predictor.tolerances.motors) for name in OF_MOTOR)]
    return dict(zip(names, fit.unknowns[: bench.n_tolerance].tolist(), strict=True))
