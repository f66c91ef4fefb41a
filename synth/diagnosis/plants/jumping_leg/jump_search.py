"""Search of causes on jumps, called by ``synth.diagnosis.search``."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from synth.arrays import Array
from synth.diagnosis.hypotheses import Assessment, Hypotheses
from synth.diagnosis.plants.jumping_leg.jump_bench import JumpBench, JumpFit
from synth.diagnosis.plants.jumping_leg.jump_candidates import JumpCandidate
from synth.diagnosis.plants.jumping_leg.jump_score import score
from synth.diagnosis.search import CauseSearch, SearchPlan, best_of_each
from synth.diagnosis.search_limits import tolerances_at_limits

STRENGTH_LADDER = (0.1, 1.0, 4.0, 12.0, 30.0, -1.0, -4.0)  # factors on a start's strengths
SHAPE_LADDER = (0.0, -1.0, 1.0)  # added to log-normal ones, in deviations of their priors
RUNGS_FITTED = 2  # rungs of a shape that are fitted
SECOND_RUNG_RATIO = 1.5  # the second only if its predicted cost is at most this multiple of the first's
SINGLES_IN_PAIRS = 5  # single causes that the anchors are paired with
# Pairs are tried if the RMS exceeds 1.03 of the floor; a third cause is not searched.
SEARCH_PLAN = SearchPlan(
    anchors=2, anchor_pairs=0, worth=-np.inf, satisfied=1.03, well=1.03, least_left=np.inf, pays=np.inf
)  # fmt: skip


def search(
    bench: JumpBench, candidates: Sequence[JumpCandidate], say: Callable[[str], None] = lambda text: None
) -> Hypotheses[JumpFit]:
    """Find how well each cause, and each promising pair, explains the trials."""
    return CauseSearch(JumpExplorer(bench, candidates), say).run(len({c.key for c in candidates}))


@dataclass
class JumpExplorer:
    """Fits to jumps; ``least`` : lowest cost so far; fits far above it are not converged fully."""

    bench: JumpBench
    candidates: Sequence[JumpCandidate]
    plan: SearchPlan = SEARCH_PLAN
    least: float = field(default=np.inf, init=False)

    @cached_property
    def _designed(self) -> JumpFit:
        return as_designed(self.bench)

    @cached_property
    def _nominal(self) -> JumpFit:
        return self.bench.solve_softly(self._designed)

    def none(self) -> JumpFit:
        """The nominal leg's best fit within the tolerances."""
        self.least = min(self.least, self._nominal.cost)
        return self._nominal

    def singles(self) -> list[JumpFit]:
        """Each cause alone. Causes that need a lean start from the design's best fit, others from the design."""
        found = []
        for candidate in self.candidates:
            near = self._nominal if candidate.effect.leaning else self._designed
            for start in _ladder_starts(self.bench, candidate, near):
                found.append(self._fit_from_start(start))
        return best_of_each(found)

    def beside(self, anchors: Sequence[Assessment[JumpFit]], singles: Sequence[Assessment[JumpFit]]) -> list[JumpFit]:
        """Each anchor with each of the most probable single causes."""
        found: dict[frozenset[tuple[str, str]], JumpFit] = {}
        for anchor in anchors:
            for other in singles[:SINGLES_IN_PAIRS]:
                keys = frozenset((*anchor.keys, *other.keys))
                if len(keys) > len(anchor.keys) and keys not in found:
                    found[keys] = self._fit_from_start(_start_of_pair(self.bench, anchor.fit, other.fit))
        return list(found.values())

    def alone(self, sets: Sequence[Assessment[JumpFit]], singles: Sequence[Assessment[JumpFit]]) -> list[JumpFit]:
        """None: the pairs are made of the single causes' own fits, and no cause is in pairs only."""
        return []

    def in_place(
        self,
        pair: Assessment[JumpFit],
        alike: Sequence[Assessment[JumpFit]],
        sets: Sequence[Assessment[JumpFit]],
    ) -> list[JumpFit]:
        """None: a third cause is not searched."""
        return []

    def ratio(self, fit: JumpFit) -> float:
        """RMS of a fit over the noise floor."""
        trials = zip(fit.residuals, self.bench.trials, strict=True)
        total = sum(float(residual @ residual) / jump.weight for residual, jump in trials)
        return float(np.sqrt(total / max(sum(len(residual) for residual in fit.residuals), 1)))

    def at_limits(self, fit: JumpFit) -> bool:
        """Whether a tolerance of a fit ends at the limit of its search."""
        return tolerances_at_limits(fit.unknowns[: self.bench.n_tolerance])

    def _fit_from_start(self, start: JumpFit) -> JumpFit:
        """The fit from a start."""
        fit = self.bench.solve_softly(start, self.least)
        self.least = min(self.least, fit.cost)
        return fit


def as_designed(bench: JumpBench) -> JumpFit:
    """The unchanged nominal leg with each trial's own unknowns estimated; with derivatives."""
    fit = JumpFit((), np.zeros(bench.n_tolerance), np.zeros((len(bench.trials), 2)))
    own = np.array([found.own for found in score(bench, fit, bench.trials)])
    return bench.evaluate(fit.start_at(own=own))


def _ladder_starts(bench: JumpBench, candidate: JumpCandidate, base: JumpFit) -> list[JumpFit]:
    """The rungs of a ladder of strengths with the lowest predicted cost."""
    low, high = candidate.bounds()
    log = [p.prior is not None and p.prior.log for p in candidate.effect.parameters]
    shapes = np.array([log[candidate.effect.index(name)] for name in candidate.shape.free])
    rungs: list[Array] = []
    for start in candidate.starts():
        for rung in SHAPE_LADDER if shapes.all() else STRENGTH_LADDER:
            point = np.clip(start + rung if shapes.all() else start * rung, low, high)
            if not any(np.array_equal(point, known) for known in rungs):
                rungs.append(point)
    left = bench.prospects((candidate,), np.array(rungs).T, base)
    order = np.argsort(left, kind="stable")[:RUNGS_FITTED].tolist()
    chosen = [k for k in order if left[k] <= SECOND_RUNG_RATIO * left[order[0]]]
    return [JumpFit((candidate,), np.concatenate([base.unknowns, rungs[k]]), base.own) for k in chosen]


def _start_of_pair(bench: JumpBench, one: JumpFit, other: JumpFit) -> JumpFit:
    """A start of two causes together: the better of either fit with half of the other's strength."""
    p = bench.n_tolerance
    fits = []
    for first, second in ((one, other), (other, one)):
        unknowns = np.concatenate([first.unknowns, 0.5 * second.unknowns[p:]])
        fits.append(bench.evaluate(JumpFit((*first.hypothesis, *second.hypothesis), unknowns, first.own)))
    return min(fits, key=lambda fit: fit.cost)
