"""A second and a third cause: sought beside one that is there already, where that one leaves something.

A cause that shows only once another is in the model (dry friction of a tenth of the torque beside a shifted encoder)
does badly alone, and what it alone would be fitted to is the other's trace. So every candidate is tried anew beside the
anchor, with the tolerances, the states and the anchor's own unknowns free to follow.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.diagnosis.candidates import Candidate
from synth.diagnosis.score import fresh
from synth.diagnosis.screening import leverage, prospects
from synth.diagnosis.solve import Fit, Workbench
from synth.diagnosis.start_sizes import strengthened
from synth.swing.lane_layout import MOST_LINKS

WORTH = 3.0  # cost that a further cause must promise to take away
SECANTS = (1.0, 12.0)  # times a start's strengths, at which the change that a cause makes is looked at
LOOKED_AT, STRENGTHS_TRIED = 16, 4  # causes that promise most by secants; of each, starts
AROUND = (0.4, 1.0)  # times the strength that the secant asks for
TRIED = 10  # further causes that are fitted to some of the trials, of those that promise most
KEPT = 5  # of those, that are fitted to all
ROUNDS = (2, 3)  # steps of the fit on some trials, and on all


@dataclass(frozen=True)
class Sifting:
    """Some of the trials at fewer samples, to see what promises: ``few`` their places among all."""

    bench: Workbench
    few: Sequence[int]

    def beside(self, fit: Fit) -> Fit:
        """A fit to all trials as one to these, with its derivatives."""
        here = Fit(fit.hypothesis, fit.unknowns, tuple(fit.states[i] for i in self.few))
        here = self.bench.evaluate([here])[0]
        return replace(here, frame=self.bench.frame(here))


def further(bench: Workbench, sifting: Sifting, anchors: Sequence[Fit], candidates: Sequence[Candidate]) -> list[Fit]:
    """Hypotheses of an anchor and one cause more, those that promise most, fitted to all trials; best first."""
    promising: dict[frozenset[tuple[str, str]], tuple[float, Fit, Fit]] = {}
    for anchor in anchors:
        here = sifting.beside(anchor)
        for left, start in _beside(sifting.bench, here, candidates):
            keys = frozenset(start.keys)
            if here.cost - left > WORTH and (keys not in promising or left < promising[keys][0]):
                promising[keys] = left, start, anchor
    best = sorted(promising.values(), key=lambda item: item[0])[:TRIED]
    origin = {frozenset(start.keys): anchor for _, start, anchor in best}
    fits = sifting.bench.solve([start for _, start, _ in best], None, ROUNDS[0])
    fits = sorted((fit for fit in fits if np.isfinite(fit.cost)), key=lambda fit: fit.cost)[:KEPT]
    spread = [_spread(fit, origin[frozenset(fit.keys)], sifting.few) for fit in fits]
    found = bench.solve(spread, None, ROUNDS[1])
    return sorted((fit for fit in found if np.isfinite(fit.cost)), key=lambda fit: fit.cost)


def _beside(bench: Workbench, here: Fit, candidates: Sequence[Candidate]) -> list[tuple[float, Fit]]:
    """Each further cause's best start beside a fit: cost that it promises, and the start.

    First by secants, a lane or two a start; then those that promise most, at the strengths that the secants ask for.
    """
    first = len(here.unknowns)
    starts = []
    for candidate in candidates:
        if possible(here.hypothesis, candidate):
            plain = replace(here, hypothesis=(*here.hypothesis, candidate), residuals=(), columns=(), cost=np.inf)
            for point in candidate.starts():
                start = fresh(replace(plain, unknowns=np.concatenate([here.unknowns, point])))
                starts += [strengthened(start, first, secant) for secant in SECANTS]
    told = zip(leverage(bench, starts, here), starts, strict=True)
    order = sorted(((left, best, start) for (left, best), start in told), key=lambda item: item[0])
    chosen: dict[tuple[str, str], list[Fit]] = {}
    for left, best, start in order:
        key = start.keys[-1]
        if here.cost - left > WORTH and len(chosen.get(key, ())) < STRENGTHS_TRIED:
            chosen.setdefault(key, []).extend(strengthened(start, first, best * factor) for factor in AROUND)
    tried = [start for key in list(chosen)[:LOOKED_AT] for start in chosen[key]]
    found: dict[tuple[str, str], tuple[float, Fit]] = {}
    for left, start in zip(prospects(bench, tried, here), tried, strict=True):
        if start.keys[-1] not in found or left < found[start.keys[-1]][0]:
            found[start.keys[-1]] = left, start
    return list(found.values())


def possible(hypothesis: Sequence[Candidate], candidate: Candidate) -> bool:
    """Whether a cause may stand beside others: with none of them at odds, and no more links than the engine has."""
    links = len(candidate.leg.joints) + sum(each.links for each in (*hypothesis, candidate))
    return links <= MOST_LINKS and all(compatible(other, candidate) for other in hypothesis)


def compatible(first: Candidate, second: Candidate) -> bool:
    """One cause is not counted twice, and one place holds one structure and one dry friction."""
    if first.key == second.key:
        return False
    if first.key[1] != second.key[1]:
        return True
    both = first.effect.way == second.effect.way == "structure"
    return not both and not (first.effect.kin and first.effect.kin == second.effect.kin)


def _spread(fit: Fit, anchor: Fit, few: Sequence[int]) -> Fit:
    """A fit to some of the trials with the other trials' states and the derivatives from its anchor."""
    states = list(anchor.states)
    for place, i in enumerate(few):
        states[i] = fit.states[place]
    return fresh(replace(fit, states=tuple(states), residuals=(), columns=(), cost=np.inf, frame=anchor.frame))
