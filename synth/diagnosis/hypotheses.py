"""Hypotheses at their best, whichever kind of leg they are about: all that odds and a verdict are made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Generic, Protocol, TypeVar

import numpy as np

from synth.arrays import Array

Key = tuple[str, str]  # effect and place, as the files name them


class HypothesisCause(Protocol):
    """One cause of a hypothesis."""

    @property
    def key(self) -> Key:
        """Effect and place, as the files name them."""

    @property
    def size(self) -> int:
        """Number of unknowns."""


class FittedHypothesis(Protocol):
    """A hypothesis fitted to trials."""

    @property
    def hypothesis(self) -> Sequence[HypothesisCause]:
        """Its causes; none for the nominal leg."""


F = TypeVar("F", bound=FittedHypothesis)


@dataclass(frozen=True)
class HeldOutError:
    """What a hypothesis leaves on trials that it was not fitted to.

    ``squares`` (n_trial, n_block) mean squared error of the samples that count, in squared noise floors; ``counts``
    (n_trial, n_block) how many these are; ``independent`` (n_trial,) how many of a trial's errors are independent.
    ``spread`` : standard deviation of the unknowns by leaving out one fold after the other (jackknife), empty where it
    was not taken.
    """

    squares: Array
    counts: Array
    independent: Array
    spread: Array = field(default_factory=lambda: np.zeros(0))

    def without(self, trial: int) -> HeldOutError:
        """Of all trials but one."""
        squares, counts, independent = (
            np.delete(each, trial, axis=0) for each in (self.squares, self.counts, self.independent)
        )
        return HeldOutError(squares, counts, independent, self.spread)

    @property
    def ratio(self) -> float:
        """RMS over the noise floor."""
        return float(np.sqrt((self.squares * self.counts).sum() / max(float(self.counts.sum()), 1.0)))

    @property
    def above(self) -> float:
        """RMS above the noise, in floors: quadratically subtracted."""
        return float(np.sqrt(max(self.ratio**2 - 1.0, 0.0)))

    def taken_of(self, before: HeldOutError) -> float:
        """Share of another's RMS above the noise that this one takes away; 0 where that is none."""
        return 1.0 - self.above / before.above if before.above > 0.0 else 0.0

    @property
    def typical(self) -> float:
        """Geometric mean over the trials of their RMS over the noise floor.

        One trial that a hypothesis sends astray (a pendulum that turns over once more) does not decide.
        """
        return float(np.exp(0.5 * np.mean(np.log(np.maximum(self.by_trial, 1e-9)))))

    @property
    def by_trial(self) -> Array:
        """(n_trial,) mean squares."""
        return np.asarray((self.squares * self.counts).sum(axis=1) / np.maximum(self.counts.sum(axis=1), 1.0))


@dataclass(frozen=True)
class Assessed(Generic[F]):
    """A hypothesis at its best: ``cost`` of the trials it was fitted to, ``ratio`` their RMS over the noise floor.

    ``unseen`` : what it leaves on trials left out of its fit; None where that was not taken.
    """

    fit: F
    cost: float
    ratio: float
    unseen: HeldOutError | None = None

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
