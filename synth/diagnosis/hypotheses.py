"""Fitted hypotheses of any plant, the input of odds and verdict."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Generic, Protocol, TypeVar

import numpy as np

from synth.arrays import Array

Key = tuple[str, str]  # effect and place, as named in files


class HypothesisCause(Protocol):
    """One cause of a hypothesis."""

    @property
    def key(self) -> Key:
        """Effect and place, as named in files."""

    @property
    def size(self) -> int:
        """Number of unknowns."""

    @property
    def links(self) -> int:
        """Number of links that it adds to the leg."""

    @property
    def replaced_links(self) -> int:
        """Number of links of the designed leg that it takes the place of."""

    @property
    def part(self) -> str:
        """The part of its place that it describes, "spring" or "damper"; empty if none."""


class FittedHypothesis(Protocol):
    """A hypothesis fitted to trials."""

    @property
    def hypothesis(self) -> Sequence[HypothesisCause]:
        """Its causes; empty for the nominal leg."""

    @property
    def shapes(self) -> Array:
        """(n, 2) of each unknown that gives a cause its shape: its whitened value, 0 where usual, and how far the
        trials determine it: squared change of the residuals for one unit, over the squared residuals.
        """


F = TypeVar("F", bound=FittedHypothesis)


@dataclass(frozen=True)
class TrialErrors:
    """The error of a hypothesis trial by trial: on trials that it was fitted to, or that were left out of its fit.

    ``squares`` (n_trial, n_block) mean squared error of the counted samples, in squared noise floors; ``counts``
    (n_trial, n_block) their number; ``independent`` (n_trial,) number of independent errors of a trial.
    ``by_fold`` (n_fold, p) : unknowns of the fit without each fold of trials, and ``refitted`` (n_trial, p) those of
    the fit that each trial was left out of; both empty if none was.
    """

    squares: Array
    counts: Array
    independent: Array
    by_fold: Array = field(default_factory=lambda: np.zeros((0, 0)))
    refitted: Array = field(default_factory=lambda: np.zeros((0, 0)))

    def without(self, trial: int) -> TrialErrors:
        """The errors of all trials but one."""
        squares, counts, independent = (
            np.delete(each, trial, axis=0) for each in (self.squares, self.counts, self.independent)
        )
        return TrialErrors(squares, counts, independent, self.by_fold)

    @property
    def ratio(self) -> float:
        """RMS over the noise floor."""
        return float(np.sqrt((self.squares * self.counts).sum() / max(float(self.counts.sum()), 1.0)))

    @property
    def above(self) -> float:
        """RMS above the noise, in floors, by quadratic subtraction."""
        return float(np.sqrt(max(self.ratio**2 - 1.0, 0.0)))

    def taken_in_all(self, before: TrialErrors) -> float:
        """Share by which another's RMS above the noise over all trials is reduced; 0 if that is zero."""
        return 1.0 - self.above / before.above if before.above > 0.0 else 0.0

    @property
    def typical(self) -> float:
        """Geometric mean over the trials of RMS over the noise floor.

        A single badly predicted trial (a pendulum with one more revolution) then does not dominate.
        """
        return float(np.exp(0.5 * np.mean(np.log(np.maximum(self.by_trial, 1e-9)))))

    @property
    def by_trial(self) -> Array:
        """(n_trial,) mean squares."""
        return np.asarray((self.squares * self.counts).sum(axis=1) / np.maximum(self.counts.sum(axis=1), 1.0))


@dataclass(frozen=True)
class Assessment(Generic[F]):
    """A fitted hypothesis: ``cost`` of its trials, ``ratio`` of their RMS to the noise floor.

    ``unseen`` : its error on each trial when that is left out of the fit; ``seen`` : on each trial of the fit itself;
    None if not computed.
    """

    fit: F
    cost: float
    ratio: float
    unseen: TrialErrors | None = None
    seen: TrialErrors | None = None

    @property
    def above(self) -> float:
        """RMS of the fitted trials above the noise, in floors, by quadratic subtraction."""
        return float(np.sqrt(max(self.ratio**2 - 1.0, 0.0)))

    @property
    def keys(self) -> tuple[Key, ...]:
        """Effect and place of each cause."""
        return tuple(cause.key for cause in self.fit.hypothesis)

    @property
    def n_unknown(self) -> int:
        """Number of unknowns of all its causes."""
        return sum(cause.size for cause in self.fit.hypothesis)

    @property
    def n_state(self) -> int:
        """Number of initial states of added links, rotation and rate, that are estimated in each trial.

        Beyond those of the designed leg: the states of links that a cause takes the place of are estimated without it.
        """
        return 2 * sum(max(cause.links - cause.replaced_links, 0) for cause in self.fit.hypothesis)


@dataclass(frozen=True)
class Hypotheses(Generic[F]):
    """All fitted hypotheses of a search: ``none``, ``singles``, and ``several`` with two or three causes.

    Each in order of cost. ``small`` : small causes beside which the leading hypotheses were fitted too.
    """

    none: Assessment[F]
    singles: tuple[Assessment[F], ...]
    several: tuple[Assessment[F], ...]
    small: tuple[Key, ...] = ()
