"""A stated effect of another size: the cause that a check asks about where the leg file states the effect.

A candidate takes the stated effect's place whole, and near size 0 it already differs from the designed leg by all that
the file states. What recordings can show is how far the size is from the stated one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property

import numpy as np

from synth.arrays import Array
from synth.diagnosis.effect_shape import ShapedEffect, has_size
from synth.diagnosis.plants.swinging_chain.chain_candidates import Candidate
from synth.diagnosis.plants.swinging_chain.stated_forms import held_as_stated, natural_value
from synth.swing.stated_effects import given_at

WITHIN = 1e-9  # deviations of the prior beyond a bound of the search that are rounding


@dataclass(frozen=True)
class ChangedEffect(Candidate):
    """A candidate whose strengths count from what the leg file states."""

    @cached_property
    def designed(self) -> Mapping[str, float]:
        """Strengths that the leg file states, of those that the shape frees."""
        sizes = {*self.shape.free} & {*self.effect.strengths}
        given = given_at(self.leg, self.place)
        return {name: value for name, value in given.items() if name in sizes and value != 0.0}

    @cached_property
    def absent(self) -> Array:
        """(size,) whitened unknowns at which each strength is the stated one; see ``ShapedEffect``."""
        found = super().absent.copy()
        for k, name in enumerate(self.shape.free):
            if name in self.designed:
                found[k] = coordinate(self, name, self.designed[name])
        return found

    def values(self, x: Array) -> Array:
        """As for any effect; a stated one is as the file has it, and need not be plausible for this leg."""
        return ShapedEffect.values(self, x) if self.designed else super().values(x)

    def starts(self) -> list[Array]:
        """Whitened starting points (size,), at what the leg file states."""
        given = {**self.effect.defaults, **given_at(self.leg, self.place)} if self.designed else {}
        made = []
        for point in super().starts():
            told = [(k, name) for k, name in enumerate(self.shape.free) if name in given]
            for k, name in told:
                if name in self.designed or name not in self.effect.strengths:
                    point[k] = coordinate(self, name, given[name])
            made.append(point)
        return list({tuple(point): point for point in made}.values())


def coordinate(candidate: Candidate, name: str, value: float) -> float:
    """Whitened coordinate of a free parameter's value in SI."""
    prior = candidate.priors[candidate.shape.free.index(name)]
    with np.errstate(divide="ignore"):  # a size of 0 where the prior has none: infinitely far
        parameter = candidate.effect.parameters[candidate.effect.index(name)]
        return float(prior.coordinate(natural_value(candidate, parameter, value)))


def changed_effects(candidates: Sequence[Candidate]) -> list[Candidate]:
    """The candidates, those of stated effects as changes of what the leg file states.

    Without the shapes of a stated effect that do not reach the stated size. A stop stays as it is: it is told by its
    place, and not by a size. Of each cause the shapes with a stated size come first.
    """
    made: list[Candidate] = []
    for candidate in candidates:
        given = given_at(candidate.leg, candidate.place)
        if not given or not has_size(candidate):
            made.append(candidate)
            continue
        changed = _as_change(candidate)
        if changed is not None:
            made.append(changed)
    order = {key: place for place, key in enumerate(dict.fromkeys(each.key for each in made))}
    return sorted(made, key=lambda each: (order[each.key], not each.designed))


def _as_change(candidate: Candidate) -> ChangedEffect | None:
    """The candidate as a change; None if its shape does not reach what the leg file states."""
    fixed = held_as_stated(candidate)
    made = ChangedEffect(**{field.name: getattr(fixed, field.name) for field in fields(Candidate)})
    if not made.designed:
        return made
    given = {**made.effect.defaults, **given_at(made.leg, made.place)}
    low, high = made.bounds()
    beyond = [
        name
        for k, name in enumerate(made.shape.free)
        if (name in made.designed or name not in made.effect.strengths)
        and not low[k] - WITHIN <= coordinate(made, name, given[name]) <= high[k] + WITHIN
    ]
    if {*beyond} & {*made.designed}:
        return None
    # What lies beyond the search, as a friction without any elastic deflection does, stays as stated.
    parameters = {parameter.name: parameter for parameter in made.effect.parameters}
    held = {name: natural_value(made, parameters[name], given[name]) for name in beyond}
    free = tuple(name for name in made.shape.free if name not in beyond)
    made = replace(made, shape=replace(made.shape, free=free, held={**made.shape.held, **held}))
    return made if _is_as_stated(made, given) else None


def _is_as_stated(changed: ChangedEffect, given: Mapping[str, float]) -> bool:
    """Whether the shape, at its start, is what the leg file states, not a bend at another place."""
    values = changed.values(changed.starts()[0][:, None])[:, 0]
    return np.allclose(values, [given[p.name] for p in changed.effect.parameters], rtol=1e-6)
