"""Effects of the design that are not there: hypotheses without them, where the found size does nothing that shows.

A cause in the place of an effect that the design states has a size that the trials find. Where the rig lacks the
effect, that size ends at 0, or of a compliance at the largest stiffness tried, and is no finding: the design is wrong
in stating it. Left out whole it has no unknowns, so the odds prefer that unless a size takes off more than it costs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from synth.diagnosis.angle_search import rms_over_noise
from synth.diagnosis.effect_shape import ShapedEffect
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.hypotheses import Assessment, Hypotheses
from synth.diagnosis.odds import Calibration, price_of_unknown
from synth.diagnosis.restarts import refine
from synth.diagnosis.simpler_shapes import prefer_simpler_shapes
from synth.diagnosis.workbench import Workbench


def with_absent_effects(
    bench: Workbench,
    found: Hypotheses[EvaluatedHypothesis],
    absent: Sequence[ShapedEffect],
    calibration: Calibration,
) -> Hypotheses[EvaluatedHypothesis]:
    """The hypotheses, each stated effect among their causes left out whole where the odds prefer that.

    ``absent`` : the stated effects that a cause may take the place of, as shapes that free nothing.
    """
    every = [found.none, *found.singles, *found.several]
    price = price_of_unknown(min(item.ratio for item in every), bench.total, calibration)
    stated = {each.key for each in absent}
    open_items = [
        item for item in every if any(stated & {cause.key, *cause.replaced_keys} for cause in item.fit.hypothesis)
    ]
    # At its optimum each: one that is not there yet would lose to the fit without the effect, which is refined.
    fits = refine(bench, [item.fit for item in open_items]) if open_items else []
    for each in absent:
        fits = prefer_simpler_shapes(bench, fits, [each], price) if fits else []
    ends = {
        id(item): replace(item, fit=fit, cost=fit.cost, ratio=rms_over_noise(bench, fit))
        for item, fit in zip(open_items, fits, strict=True)
        if any(cause.is_absent for cause in fit.hypothesis)
    }

    def in_order(items: Sequence[Assessment[EvaluatedHypothesis]]) -> tuple[Assessment[EvaluatedHypothesis], ...]:
        known = sorted((ends.get(id(item), item) for item in items), key=lambda item: item.cost)
        # A cause in the place of an absent one of its kin ends as that: one entry of both.
        return tuple({frozenset(item.keys): item for item in reversed(known)}.values())[::-1]

    return replace(found, singles=in_order(found.singles), several=in_order(found.several))
