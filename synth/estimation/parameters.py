"""Parameters of an effect: units, prior, and starting values of a search.

An effect of any plant is a set of parameters; zero strengths switch it off. A diagnosis works with whitened
unknowns whose prior is the standard normal; ``Prior`` converts between the two.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import ModuleType
from typing import Any, Literal

import numpy as np


@dataclass(frozen=True)
class Prior:
    """Prior of a parameter, in units of the joint's natural size of its dimension.

    Normal with mean ``centre`` and standard deviation ``width``; with ``log`` log-normal with median ``centre``
    with ``width`` in natural logarithm; with ``inverse`` its reciprocal is normal about ``1 / centre`` (0 for an
    infinite centre) with deviation ``width``: a compliance, whose effect is linear while small. Truncated at
    ``lower`` and ``upper``.

    Raises
    ------
    ValueError : an ``inverse`` prior without a finite ``upper``: a compliance of 0 has no value.
    """

    centre: float
    width: float
    log: bool = False
    lower: float = -np.inf
    upper: float = np.inf
    inverse: bool = False

    def __post_init__(self) -> None:
        """Refuse a compliance that may vanish."""
        if self.inverse and not np.isfinite(self.upper):
            raise ValueError(f"a prior with inverse=True needs a finite upper bound, not {self.upper}")

    def value(self, coordinate: Any) -> Any:
        """Value for a whitened coordinate (0 the centre, 1 one standard deviation above), truncated."""
        scaled = self.width * np.asarray(coordinate, dtype=float)
        if self.inverse:
            value = 1.0 / np.maximum(1.0 / self.centre + scaled, 1.0 / self.upper)
        elif self.log:
            # Within a double's range, beyond any prior's.
            value = self.centre * np.exp(np.minimum(np.maximum(scaled, -40.0), 40.0))
        else:
            value = self.centre + scaled
        # np.clip takes five times as long
        value = value if self.lower == -np.inf else np.maximum(value, self.lower)
        return value if self.upper == np.inf else np.minimum(value, self.upper)

    def coordinate(self, value: Any) -> Any:
        """Whitened coordinate of ``value``."""
        value = np.asarray(value, dtype=float)
        if self.inverse:
            return (1.0 / value - 1.0 / self.centre) / self.width
        return np.log(value / self.centre) / self.width if self.log else (value - self.centre) / self.width

    def span(self, most: float) -> tuple[float, float]:
        """Lowest and highest whitened coordinate within the bounds, at most ``most`` deviations from 0."""
        ends = [-np.inf, np.inf]
        for side, bound in enumerate((self.lower, self.upper)):
            if np.isfinite(bound) and not ((self.log or self.inverse) and bound <= 0.0):
                ends[1 - side if self.inverse else side] = float(self.coordinate(bound))
        return max(ends[0], -most), min(ends[1], most)


def stiff(usual: float, upper: float) -> Prior:
    """A stiffness that is infinite in the nominal leg: half-normal in its reciprocal, up to ``upper``."""
    return Prior(np.inf, 1.0 / usual, lower=0.5, upper=upper, inverse=True)


def size(width: float) -> Prior:
    """A strength: half-normal, not negative."""
    return Prior(0.0, width, lower=0.0)


def signed(width: float, most: float = np.inf) -> Prior:
    """A strength of either sign."""
    return Prior(0.0, width, lower=-most, upper=most)


def positive(median: float, width: float, lower: float = 0.0, upper: float = np.inf) -> Prior:
    """A shape: log-normal."""
    return Prior(median, width, log=True, lower=lower, upper=upper)


Form = Literal["value", "change", "share", "relative change"]
DESIGNED = ("spring_rate", "damper_rate")  # quantities of a joint to which an effect adds


@dataclass(frozen=True)
class Parameter:
    """One parameter of an effect.

    ``default``: the value if a file gives none; None: required. ``off``: the value that represents a joint without the
    effect. ``prior`` None: never estimated. A parameter with ``natural`` False has its prior in its own SI unit,
    otherwise in the joint's natural size (see ``chain_candidates``), which counts up to ``largest``, SI. ``anchor``
    "middle": its prior is relative to the middle of the joint's motion, in half its range; "settled": to the spring's
    deflection at the end of the trials. ``of`` : another free parameter by whose value the prior's is multiplied: a
    part that is smaller than another one, or belongs to another effect. ``above``, ``below`` : exclusive limits of a
    value in a file, ``least`` an inclusive one, beside those that follow from the prior. ``label`` : words that people
    read in place of the name; ``form`` : as which they read the value, a change with its sign, a share in per cent.
    ``added_to`` : the quantity of the designed joint that a change is added to, see ``DESIGNED``. ``choices`` : words
    for the values 0 and 1 of a parameter that has no others; a file may give no other one.
    """

    name: str
    unit: str
    default: float | None = None
    prior: Prior | None = None
    off: float = 0.0
    natural: bool = True
    largest: float = np.inf
    anchor: Literal["", "middle", "settled"] = ""
    of: str = ""
    meaning: str = ""
    above: float = -np.inf
    least: float = -np.inf
    below: float = np.inf
    label: str = ""
    form: Form = "value"
    added_to: str = ""
    choices: tuple[str, ...] = ()

    @property
    def words(self) -> str:
        """What people read in place of the name."""
        return self.label or self.name.replace("_", " ")

    def wanted(self, value: float) -> str:
        """What a file must give instead of this value, "at least 0"; empty if it may give it.

        Beside its own limits: a parameter whose prior ends at 0 or above is a size. One that is not 0 where its effect
        is off, nor a ratio that may vanish, divides.
        """
        if self.choices and value not in range(len(self.choices)):
            return " or ".join(f"{number} ({words})" for number, words in enumerate(self.choices))
        if not value > self.above:
            return f"more than {self.above:g}"
        if value < self.least:
            return f"at least {self.least:g}"
        if not value < self.below:
            return f"less than {self.below:g}"
        prior = self.prior
        if prior is None or prior.lower < 0.0 or value > 0.0:
            return ""
        ratio = self.unit == "1" and prior.lower == 0.0
        divides = self.default != 0.0 and not ratio and (prior.log or prior.inverse)
        return "more than 0" if divides else "at least 0" if value < 0.0 else ""


@dataclass(frozen=True)
class Shape:
    """One variant in which the diagnosis tries an effect: its free parameters and starting values.

    ``free`` : names; the others keep their default, or the value in ``held``. ``starts`` : name -> values; a name
    left out starts small. Both in units of the natural size, as ``Prior.centre``. ``needs`` : one of these
    properties that a place must have, in the plant's own words; empty: it applies everywhere. ``richer`` : it is only
    tried where the effect, in a shape with fewer parameters, is among the leading causes: each step costs much more.
    ``explains`` : of a richer one, it is only taken where it leaves hardly more than the noise.
    """

    free: tuple[str, ...]
    held: Mapping[str, float]
    starts: tuple[Mapping[str, float], ...] = ({},)
    needs: tuple[str, ...] = ()
    richer: bool = False
    explains: bool = False


@dataclass(frozen=True)
class SimplerEffect:
    """A simpler effect that an effect is, at the same place, where some of its parameters have certain values.

    By its own formula, in every motion. ``name`` : of the simpler effect; ``where`` : parameter -> value, SI.
    """

    name: str
    where: Mapping[str, float]


@dataclass(frozen=True)
class PlantEffect:
    """An effect of a plant with its parameters in the order of its function.

    ``strengths`` : the parameters that switch it off when all are zero. ``shapes`` : the variants that a diagnosis
    tries. ``phrase`` : the words for a place that has it, "has dry friction". ``module`` : the module of its
    functions. ``stated`` : parameters for a sentence, the most needed first; empty: those ``stated_by_default``.
    ``idle`` : parameter -> another one and its value at which the first does not matter. ``becomes`` : simpler effects
    that it is where its parameters end there: no trial could tell the two apart. ``former`` : earlier names, which
    files may still have.
    """

    name: str
    meaning: str
    formula: str
    source: str
    parameters: tuple[Parameter, ...]
    strengths: tuple[str, ...]
    shapes: tuple[Shape, ...]
    phrase: str = ""
    module: str = ""
    stated: tuple[str, ...] = ()
    idle: Mapping[str, tuple[str, float]] = field(default_factory=dict)
    becomes: tuple[SimplerEffect, ...] = ()
    former: tuple[str, ...] = ()

    @cached_property
    def defaults(self) -> dict[str, float]:
        """Parameter -> default; required parameters count as off."""
        return {p.name: p.off if p.default is None else p.default for p in self.parameters}

    @property
    def stated_by_default(self) -> list[str]:
        """Strengths, and what scales with the motion: what a sentence states, if not ``stated``; a table has all."""
        return [p.name for p in self.parameters if p.natural or p.name in self.strengths]

    def function(self, name: str) -> Callable[..., Any]:
        """A function of its module."""
        found: Callable[..., Any] = getattr(self.loaded, name)
        return found

    @property
    def loaded(self) -> ModuleType:
        """Its module."""
        return importlib.import_module(self.module)

    def index(self, parameter: str) -> int:
        """Index of a parameter."""
        return [p.name for p in self.parameters].index(parameter)
