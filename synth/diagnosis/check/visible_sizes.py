"""Smallest visible sizes of causes as they are told: strengths, values of a limit, places of a stop."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synth.arrays import Array
from synth.diagnosis.check.cause_responses import VISIBLE_SIGNAL, CauseResponse
from synth.diagnosis.effect_shape import ShapedEffect, has_size
from synth.estimation.intervals import Estimate
from synth.units import shown_unit


def visible_size(responses: Sequence[CauseResponse]) -> dict[str, Estimate]:
    """The smallest visible size of a cause from its forms, of which one is visible; of a stop its places."""
    response = next(each for each in responses if each.visible is not None)
    if has_size(response.candidate) or response.level is not None:
        return size_at(response, 1.0) or {}
    return _visible_places(responses)


def implausible_size(responses: Sequence[CauseResponse]) -> dict[str, Estimate] | None:
    """The smallest size at which a cause would be visible if it were plausible; None if there is none."""
    for response in responses:
        if response.implausible is not None:
            return _strengths(response.candidate, response.implausible)
    return None


def size_at(response: CauseResponse, factor: float) -> dict[str, Estimate] | None:
    """The size with ``factor`` times the smallest visible signal; None beyond the range of the diagnosis.

    Of a strength that starts from zero, ``factor`` times the smallest visible one; of a limit the value with that
    signal on its ladder. Empty if a place alone makes the cause visible: no strength of it could be larger.
    """
    candidate, visible = response.candidate, response.visible
    assert visible is not None
    if response.level is not None:
        point = response.level.at_signal(VISIBLE_SIGNAL * factor)
        return None if point is None else _strengths(candidate, point)
    if not has_size(candidate):
        return {}
    point = candidate.strengthened(visible, factor)
    low, high = candidate.bounds()
    if np.any(np.abs(point) > np.where(point < 0.0, np.abs(low), np.abs(high)) + 1e-9) and factor > 1.0:
        return None
    return _strengths(candidate, np.clip(point, low, high))


def _strengths(candidate: ShapedEffect, point: Array) -> dict[str, Estimate]:
    """Strengths that are free in the cause's shape at whitened unknowns; of stated ones the change from these."""
    units = {parameter.name: parameter.unit for parameter in candidate.effect.parameters}
    return {
        name: Estimate(
            abs(value - candidate.designed[name]) if name in candidate.designed else value,
            _unit_of_smallest_size(units[name]),
        )
        for name, value in candidate.named(point).items()
        if name in candidate.effect.strengths and name in candidate.shape.free
    }


def designed_size(candidate: ShapedEffect) -> dict[str, Estimate]:
    """The strengths that the design states, of which the sizes of a cause are changes; empty for other causes."""
    units = {parameter.name: parameter.unit for parameter in candidate.effect.parameters}
    return {name: Estimate(value, _unit_of_smallest_size(units[name])) for name, value in candidate.designed.items()}


def _visible_places(responses: Sequence[CauseResponse]) -> dict[str, Estimate]:
    """Where a cause without a size shows: the first visible place at each side; starts are in order from far to near.

    Its stiffness would say nothing: that of a rigid stop, or of the softest that can be told, is no design quantity.
    """
    found: dict[str, Estimate] = {}
    for response in responses:
        if response.visible is None:
            continue
        candidate, named = response.candidate, response.candidate.named(response.visible)
        for parameter in candidate.effect.parameters:
            if parameter.anchor and parameter.name in candidate.shape.free:
                found.setdefault(
                    parameter.name, Estimate(named[parameter.name], _unit_of_smallest_size(parameter.unit))
                )
    return found


def _unit_of_smallest_size(unit: str) -> str:
    """The unit of a smallest size: of shares and delays, which are small here, a smaller one than in other results."""
    return {"1": "%", "s": "ms"}.get(unit, shown_unit(unit))
