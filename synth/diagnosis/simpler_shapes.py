"""A simpler shape of a cause instead of a richer one that explains hardly more.

An effect has shapes with few and with more unknowns. Fits are kept by their cost alone while they are not finished, so
the richer shape is kept even where it ends as the simpler one: friction that falls with speed, by nothing. The odds
would then charge a cause for unknowns that it does not need: rounding would decide which shape is kept, and the price
of the idle unknowns could move the first place to a rival that errs by more.
"""

from __future__ import annotations

from collections.abc import Sequence

from synth.diagnosis.effect_shape import ShapedEffect
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.restarts import refine
from synth.diagnosis.workbench import Workbench


def prefer_simpler_shapes(
    bench: Workbench, fits: Sequence[EvaluatedHypothesis], candidates: Sequence[ShapedEffect], price: float
) -> list[EvaluatedHypothesis]:
    """Each of these fits, or that of a simpler shape of its causes if the odds prefer it; in the same order.

    ``fits`` : with their own derivatives. ``price`` : what an unknown must take off the cost, ``price_of_unknown``.
    """
    starts = [_fits_in_simpler_shapes(bench, fit, candidates) for fit in fits]
    ends = iter(refine(bench, bench.evaluate([start for own in starts for start in own])))
    return [
        min([fit, *(next(ends) for _ in own)], key=lambda each: cost_with_unknowns(each, price))
        for fit, own in zip(fits, starts, strict=True)
    ]


def cost_with_unknowns(fit: EvaluatedHypothesis, price: float) -> float:
    """Its cost, with its causes' unknowns charged."""
    return fit.cost + price * sum(candidate.size for candidate in fit.hypothesis)


def _fits_in_simpler_shapes(
    bench: Workbench, fit: EvaluatedHypothesis, candidates: Sequence[ShapedEffect]
) -> list[EvaluatedHypothesis]:
    """The fit with one of its causes in a shape that frees fewer of the same parameters, at the same values."""
    made = []
    for k, (cause, place) in enumerate(zip(fit.hypothesis, fit.slices, strict=True)):
        own = fit.unknowns[place]
        for other in candidates:
            if _is_simpler(other, cause):
                kept = own[[cause.shape.free.index(name) for name in other.shape.free]]
                start = fit.with_cause(k, other, kept)
                made.append(start if other.links == cause.links else bench.held(start))
    return made


def _is_simpler(one: ShapedEffect, other: ShapedEffect) -> bool:
    """Whether a shape of the same cause frees some of the other's parameters, and adds as many links; or is none."""
    if one.is_absent:  # or of a cause in the place of the absent effect
        return one.key in (other.key, *other.replaced_keys) and not other.is_absent
    return one.key == other.key and one.links == other.links and {*one.shape.free} < {*other.shape.free}
