"""Every cause in the motor leg's list, alone and in pairs, brought to its best within the tolerances."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import combinations

import numpy as np

from synth.arrays import Array
from synth.diagnosis.hypotheses import Assessed, Hypotheses, Key
from synth.diagnosis.plants.jumping_leg.jump_bench import JumpBench, JumpFit
from synth.diagnosis.plants.jumping_leg.jump_candidates import JumpCandidate
from synth.diagnosis.plants.jumping_leg.jump_score import score

LADDER = (0.1, 1.0, 4.0, 12.0, 30.0, -1.0, -4.0)  # times a start's strengths
SHAPES_LADDER = (1.0, 0.5, 2.0)  # of log-normal ones
TRIED = 2  # rungs of a shape that are gone on with,
NEAR = 1.5  # the second where it promises to leave no more than so many times what the first does
PAIRED, ANCHORS = 5, 2  # single causes of which pairs are made, one of them among the first
SATISFIED = 1.03  # RMS over the floor below which no second cause is looked for


JumpAssessed = Assessed[JumpFit]
JumpSearch = Hypotheses[JumpFit]


def search(
    bench: JumpBench, candidates: Sequence[JumpCandidate], say: Callable[[str], None] = lambda text: None
) -> JumpSearch:
    """Find how well each cause, and each promising pair, explains the trials."""
    say("the nominal leg within its tolerances")
    designed = as_designed(bench)
    none = _assess(bench, bench.solve_softly(designed))
    near = {False: designed, True: none.fit}  # where a search begins; what only a lean shows, at the design's best
    say(f"{len({c.key for c in candidates})} single causes")
    best: dict[Key, JumpFit] = {}
    least = none.cost
    for candidate in candidates:
        for start in _starts(bench, candidate, near[candidate.effect.leaning]):
            fit = bench.solve_softly(start, least)
            least = min(least, fit.cost)
            if candidate.key not in best or fit.cost < best[candidate.key].cost:
                best[candidate.key] = fit
    singles = sorted((_assess(bench, fit) for fit in best.values()), key=lambda a: a.cost)
    several: list[JumpAssessed] = []
    if singles and singles[0].ratio > SATISFIED and none.ratio > SATISFIED:
        say("pairs of causes")
        for one, other in combinations(range(min(PAIRED, len(singles))), 2):
            if one < ANCHORS:
                several.append(_pair(bench, singles[one].fit, singles[other].fit, least))
                least = min(least, several[-1].cost)
    return JumpSearch(none, tuple(singles), tuple(sorted(several, key=lambda a: a.cost)))


def as_designed(bench: JumpBench) -> JumpFit:
    """The nominal leg to the letter, each trial's own unknowns estimated; with its derivatives."""
    fit = JumpFit((), np.zeros(bench.n_tolerance), np.zeros((len(bench.trials), 2)))
    own = np.array([found.own for found in score(bench, fit, bench.trials)])
    return bench.evaluate(replace(fit, own=own))


def _starts(bench: JumpBench, candidate: JumpCandidate, base: JumpFit) -> list[JumpFit]:
    """Of a ladder of strengths the rungs that promise to leave least."""
    low, high = candidate.bounds()
    log = [p.prior is not None and p.prior.log for p in candidate.effect.parameters]
    shapes = np.array([log[candidate.effect.index(name)] for name in candidate.shape.free])
    rungs: list[Array] = []
    for start in candidate.starts():
        for factor in SHAPES_LADDER if shapes.all() else LADDER:
            point = np.clip(start + np.log2(factor) if shapes.all() else start * factor, low, high)
            if not any(np.array_equal(point, known) for known in rungs):
                rungs.append(point)
    left = bench.prospects((candidate,), np.array(rungs).T, base)
    order = np.argsort(left, kind="stable")[:TRIED].tolist()
    chosen = [k for k in order if left[k] <= NEAR * left[order[0]]]
    return [JumpFit((candidate,), np.concatenate([base.unknowns, rungs[k]]), base.own) for k in chosen]


def _pair(bench: JumpBench, one: JumpFit, other: JumpFit, best: float) -> JumpAssessed:
    """Two causes together, from either's own fit with half of the other's strength."""
    p = bench.n_tolerance
    fits = []
    for first, second in ((one, other), (other, one)):
        unknowns = np.concatenate([first.unknowns, 0.5 * second.unknowns[p:]])
        fits.append(bench.evaluate(JumpFit((*first.hypothesis, *second.hypothesis), unknowns, first.own)))
    return _assess(bench, bench.solve_softly(min(fits, key=lambda fit: fit.cost), best))


def _assess(bench: JumpBench, fit: JumpFit) -> JumpAssessed:
    total = sum(float(r @ r) / jump.weight for r, jump in zip(fit.residuals, bench.trials, strict=True))
    count = sum(len(r) for r in fit.residuals)
    return JumpAssessed(fit, fit.cost, float(np.sqrt(total / max(count, 1))))
