"""Forms of a cause that takes the place of an effect that the leg file states.

A shape holds what it does not free at the defaults. Where the file states such a parameter, that is the designed value:
a channel that is filtered as stated may be late besides.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from synth.diagnosis.plants.swinging_chain.chain_candidates import Candidate
from synth.estimation.parameters import Parameter
from synth.swing.effects import effect_named
from synth.swing.leg_model import Leg
from synth.swing.stated_effects import Place, given_at


def in_stated_forms(found: Sequence[Candidate]) -> list[Candidate]:
    """The candidates, those at the place of a stated effect, or of its kin, in the forms that take its place.

    What the file states and a shape does not free is held as stated; a size also off, because the rig may have the
    other form instead of the stated one.
    """
    made = []
    for candidate in found:
        candidate = replace(candidate, replaced=kin_stated(candidate.leg, candidate.place))
        fixed = held_as_stated(candidate)
        kept = {*fixed.shape.held} - {*candidate.shape.held}
        forms = [candidate, fixed] if kept & {*candidate.effect.strengths} else [fixed]
        made += [each for each in forms if each.has_room]
    return made


def kin_stated(leg: Leg, place: Place) -> tuple[str, ...]:
    """The stated effects at a place with which an effect there cannot stand: another dry friction."""
    name, joint = place
    effect = effect_named(name)
    if effect.where == "base" or not effect.kin:
        return ()
    return tuple(
        other for other in leg.joints[joint].effects if other != name and effect_named(other).kin == effect.kin
    )


def natural_value(candidate: Candidate, parameter: Parameter, value: float) -> float:
    """A parameter's value in SI in the natural units of its place."""
    zero, one = candidate.in_units(parameter, np.array([0.0, 1.0])) + np.zeros(2)
    return float((value - zero) / (one - zero))


def held_as_stated(candidate: Candidate) -> Candidate:
    """The candidate, its shape with what the leg file states of the effect instead of the defaults."""
    parameters = {parameter.name: parameter for parameter in candidate.effect.parameters}
    held = {
        name: natural_value(candidate, parameters[name], value)
        for name, value in given_at(candidate.leg, candidate.place).items()
        if name not in candidate.shape.free
        and _is_default(candidate, parameters[name])
        and not (name in candidate.effect.strengths and value == 0.0)
    }
    return (
        replace(candidate, shape=replace(candidate.shape, held={**candidate.shape.held, **held})) if held else candidate
    )


def _is_default(candidate: Candidate, parameter: Parameter) -> bool:
    """Whether the shape holds a parameter at its default: another value is a form of its own, a bend at mid-length."""
    held = candidate.shape.held.get(parameter.name)
    default = candidate.effect.defaults[parameter.name]
    return held is None or bool(np.all(candidate.in_units(parameter, np.array([held])) == default))
