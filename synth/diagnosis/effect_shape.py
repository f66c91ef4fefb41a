"""An effect in one of its shapes, as a candidate cause for any plant."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate, pairwise
from math import log

import numpy as np

from synth.arrays import Array
from synth.diagnosis.hypotheses import Key
from synth.estimation.parameters import Parameter, PlantEffect, Prior, Shape

SMALL_STRENGTH = 0.05  # of its prior's width: initial strength
# Bounds of a strength and of a shape parameter, in deviations from the prior's centre.
LARGEST_STRENGTH, FARTHEST_SHAPE = 40.0, 6.0


@dataclass(frozen=True)
class ShapedEffect(ABC):
    """One effect in one shape; the unknowns are the shape's free parameters, whitened by their priors."""

    effect: PlantEffect
    shape: Shape

    @abstractmethod
    def natural_size(self, parameter: Parameter) -> float:
        """The SI size of a parameter's natural unit; 1 if it has none."""

    @property
    def links(self) -> int:
        """Number of links that it adds to the leg."""
        return 0

    @property
    def replaced_links(self) -> int:
        """Number of links of the designed leg that it takes the place of."""
        return 0

    @property
    def designed(self) -> Mapping[str, float]:
        """Its strengths that the design states, if the cause is a change of these; empty otherwise."""
        return {}

    @property
    def replaced_keys(self) -> tuple[Key, ...]:
        """Other effects of the design of which it takes the place."""
        return ()

    @property
    def is_absent(self) -> bool:
        """An effect of the design that is not there: it frees nothing and holds nothing."""
        return not (self.shape.free or self.shape.held)

    @property
    def part(self) -> str:
        """The part of its place that it describes, "spring" or "damper"; empty if none."""
        return ""

    @property
    def nearly_linear(self) -> bool:
        """Whether its unknowns enter almost linearly, like a shifted reading or a mass."""
        return False

    @property
    def is_compliance(self) -> bool:
        """Whether its strength is a compliance: the stiffer, the more expensive to simulate."""
        return False

    def stands_beside(self, others: Sequence[ShapedEffect]) -> bool:
        """Whether it may be combined with the others: no cause is counted twice."""
        return all(other.key != self.key for other in others)

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return len(self.shape.free)

    @cached_property
    def priors(self) -> list[Prior]:
        """The unknowns'."""
        return [_prior(self.effect.parameters[self.effect.index(name)]) for name in self.shape.free]

    @cached_property
    def absent(self) -> Array:
        """(size,) whitened unknowns at which each strength vanishes; 0 for shapes and log-normal strengths.

        Not 0 where the usual strength is not: a damper that thins loses half at its prior's centre.
        """
        found = np.zeros(self.size)
        for k, (name, prior) in enumerate(zip(self.shape.free, self.priors, strict=True)):
            if name in self.effect.strengths and not (prior.log or prior.inverse):
                found[k] = prior.coordinate(0.0)
        return found

    def strengthened(self, unknowns: Array, factor: float) -> Array:
        """Whitened unknowns (size,) with the strengths multiplied by a positive factor; not kept within bounds."""
        made = np.array(unknowns, dtype=float)
        for k, (name, prior) in enumerate(zip(self.shape.free, self.priors, strict=True)):
            if name in self.effect.strengths:
                absent = self.absent[k]
                made[k] = made[k] + log(factor) / prior.width if prior.log else absent + (made[k] - absent) * factor
        return made

    def starts(self) -> list[Array]:
        """Whitened starting points (size,)."""
        made = []
        for start in self.shape.starts or ({},):
            natural = zip(self.shape.free, self.priors, strict=True)
            point = [
                float(prior.coordinate(start[name])) if name in start else SMALL_STRENGTH for name, prior in natural
            ]
            made.append(np.array(point))
        return made

    def bounds(self) -> tuple[Array, Array]:
        """Whitened bounds (size,); a strength keeps its sign if its prior has one."""
        low, high = self._bounds
        return low.copy(), high.copy()

    @cached_property
    def _bounds(self) -> tuple[Array, Array]:
        """The result of ``bounds``, which every step of every fit asks for."""
        low, high = np.empty(self.size), np.empty(self.size)
        for k, (name, prior) in enumerate(zip(self.shape.free, self.priors, strict=True)):
            strength = name in self.effect.strengths and not prior.log
            low[k], high[k] = prior.span(LARGEST_STRENGTH if strength else FARTHEST_SHAPE)
        return low, high

    def values(self, x: Array) -> Array:
        """(n_parameter, n_lane) all parameters in SI and the files' sign convention, from unknowns (size, n_lane)."""
        found = np.empty((len(self.effect.parameters), x.shape[1]))
        for p, parameter in enumerate(self.effect.parameters):
            if parameter.name in self.shape.free:
                value = _prior(parameter).value(x[self.shape.free.index(parameter.name)])
                found[p] = self.in_units(parameter, value)
            else:
                held = self.shape.held.get(parameter.name)
                default = self.effect.defaults[parameter.name]
                found[p] = default if held is None else self.in_units(parameter, np.full(x.shape[1], held))
        for p, parameter in enumerate(self.effect.parameters):
            if parameter.of and {parameter.name, parameter.of} <= {*self.shape.free}:
                found[p] *= found[self.effect.index(parameter.of)]
        return found

    def named(self, x: Array) -> dict[str, float]:
        """Parameters to report, by name, in SI, from whitened unknowns (size,)."""
        values = self.values(x[:, None])[:, 0].tolist()
        freed = {*self.shape.free, *self.shape.held}
        return {
            parameter.name: value
            for parameter, value in zip(self.effect.parameters, values, strict=True)
            if parameter.name in freed or parameter.default is None
        }

    @property
    @abstractmethod
    def key(self) -> Key:
        """Effect and place, as named in files."""

    def in_units(self, parameter: Parameter, value: Array) -> Array:
        """Natural values (n_lane,) of a free parameter in SI."""
        return value * self.natural_size(parameter)


def has_size(candidate: ShapedEffect) -> bool:
    """Whether its strengths start from zero; a stop's stiffness and a limit do not."""
    named = zip(candidate.shape.free, candidate.priors, strict=True)
    return not any(prior.log for name, prior in named if name in candidate.effect.strengths)


def unknown_slices(causes: Sequence[ShapedEffect], first: int) -> list[slice]:
    """Places of each cause's unknowns among those of a hypothesis; ``first`` : number of tolerance unknowns."""
    return [slice(*ends) for ends in pairwise(accumulate((cause.size for cause in causes), initial=first))]


def shape_places(causes: Sequence[ShapedEffect]) -> list[int]:
    """Places among the causes' unknowns of those that give a shape; a strength may have any size, and is none."""
    names = [(cause, name) for cause in causes for name in cause.shape.free]
    return [place for place, (cause, name) in enumerate(names) if name not in cause.effect.strengths]


def _prior(parameter: Parameter) -> Prior:
    """Raise if a free parameter of a shape has no prior."""
    assert parameter.prior is not None
    return parameter.prior
