"""Hypotheses at their best, whichever kind of leg they are about: all that odds and a verdict are made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

Key = tuple[str, str]  # effect and place, as the files name them


class HypothesisCause(Protocol):
    """One cause of a hypothesis."""

    @property
    def key(self) -> Key:
        """Effect and place, as the files name them."""

    @property
    def size(self) -> int:
        """Number of unknowns."""


class Fitted(Protocol):
    """A hypothesis fitted to trials."""

    @property
    def hypothesis(self) -> Sequence[HypothesisCause]:
        """Its causes; none for the nominal leg."""


F = TypeVar("F", bound=Fitted)


@dataclass(frozen=True)
class Assessed(Generic[F]):
    """A hypothesis at its best: ``cost`` of the trials it was fitted to, ``ratio`` their RMS over the noise floor."""

    fit: F
    cost: float
    ratio: float

    @property
    def keys(self) -> tuple[Key, ...]:
        """Effect and place of each cause."""
        return tuple(cause.key for cause in self.fit.hypothesis)

    @property
    def n_unknown(self) -> int:
        """Unknowns of all its causes."""
        return sum(cause.size for cause in self.fit.hypothesis)


@dataclass(frozen=True)
class Hypotheses(Generic[F]):
    """All that a search brought to their best: ``none``, ``singles``, and ``several`` of two causes or three.

    Each in order of cost.
    """

    none: Assessed[F]
    singles: tuple[Assessed[F], ...]
    several: tuple[Assessed[F], ...]
