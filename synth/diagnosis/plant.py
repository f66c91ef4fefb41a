"""The interface of a plant to the diagnosis: a swinging chain, a jumping leg, or another adapter.

The adapter defines trials, candidates and their search. Everything derived from the fitted hypotheses
is the same for all plants (``synth.diagnosis.cause_findings``).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, Protocol, Self, TypeVar

import numpy as np

from synth.arrays import Array
from synth.diagnosis.diagnosis_result import Cause, Verdict
from synth.diagnosis.effect_shape import ShapedEffect
from synth.diagnosis.hypotheses import FittedHypothesis, Hypotheses, TrialErrors
from synth.diagnosis.prediction_error import PredictionErrors
from synth.diagnosis.sentences import ErrorWording
from synth.diagnosis.verdict import CALIBRATED, Calibration, Judgement, open_explanations
from synth.estimation.information import RIVALS, TrialForecast
from synth.estimation.normal_equations import ReducedNormal


class HypothesisFit(FittedHypothesis, Protocol):
    """A fitted hypothesis: causes and whitened unknowns, tolerances first."""

    @property
    def hypothesis(self) -> Sequence[ShapedEffect]:
        """Its causes; empty for the nominal leg."""

    @property
    def unknowns(self) -> Array:
        """(n_tolerance + n_effect,) whitened."""

    def at(self, unknowns: Array) -> Self:
        """The hypothesis with other unknowns, for predictions."""


F = TypeVar("F", bound=HypothesisFit)
T = TypeVar("T")  # a trial
S = TypeVar("S")  # a trial's prediction


@dataclass(frozen=True)
class MenuItem(Generic[T]):
    """A possible next trial.

    ``what`` : in words. ``keys`` : of a ``trials:`` entry, including ``file``. ``trial`` : the imagined trial, without
    readings. ``release`` : joint -> measured angle, rad. ``ramp`` : joint, final torque (N m, in the measured angle's
    positive sense) and rise time (s) of a slowly rising torque. ``command`` : times (m,) s and, joint ->
    measured angle (m,) rad, a command for servos. ``source`` : from which the plant makes variations.
    ``state`` : in words, what is taken for granted beside.
    """

    what: str
    keys: Mapping[str, object]
    trial: T
    release: Mapping[str, float]
    ramp: tuple[str, float, float] | None = None
    command: tuple[Array, Mapping[str, Array]] | None = None
    source: object = None
    state: str = ""


@dataclass(frozen=True)
class StagePredictions(Generic[F, S]):
    """Scored trials predicted by the unchanged nominal leg, by its best fit, and with the explanation.

    ``fits`` : these three, fitted to all training trials. ``alone`` : label of a single cause -> prediction with
    only that cause, for the most probable ones. ``unread`` : ``after`` as it was before the direct causes were applied;
    empty if they were not.
    """

    fits: tuple[F, F, F]
    as_designed: tuple[S, ...]
    before: tuple[S, ...]
    after: tuple[S, ...]
    alone: Mapping[str, tuple[S, ...]]
    errors: PredictionErrors
    unread: tuple[S, ...] = ()


class Plant(ABC, Generic[F, T, S]):
    """One plant with its trials.

    ``scored`` : the trials used for scoring, those ``held_out`` or else all; ``scored_names`` : files of the recordings
    that they are, rows of ``squares``; ``seed`` of the resampling;
    ``warnings`` about the trials; ``n_tolerance`` : number of the leg's own unknowns.
    """

    scored: tuple[T, ...]
    scored_names: tuple[str, ...]
    held_out: bool
    seed: int
    warnings: tuple[str, ...]
    n_tolerance: int
    calibration: Calibration = CALIBRATED
    accuracy: float = 0.0  # rad: a smaller gap does not matter to the user
    # RMS of the motion over the noise, or what takes its place if an accuracy is required, and of the trials in any
    # case; infinite: a gap's share of it tells nothing.
    motion: float = np.inf
    own_motion: float = np.inf
    direct_causes: tuple[Cause, ...] = ()  # found directly in the readings, without a fit
    most_rivals: int = RIVALS  # explanations that a further trial should separate
    independent: float = np.inf  # errors of a trial that count as independent; infinite: all, and of known size

    @abstractmethod
    def search(self, say: Callable[[str], None]) -> Hypotheses[F]:
        """All hypotheses, fitted."""

    @abstractmethod
    def designed(self) -> F:
        """The unchanged nominal leg."""

    @abstractmethod
    def normal(self, fit: F) -> ReducedNormal:
        """Normal equations at a fit."""

    def prior_cost(self, fit: F) -> float:
        """What a fit's unknowns add to its cost; here they are standard normal."""
        return 0.5 * float(fit.unknowns @ fit.unknowns)

    def covariance(self, fit: F) -> Array:
        """(p, p) covariance of the errors of a fit's unknowns, of residuals as large as those that it leaves."""
        return self.normal(fit).covariance(self.remainder(fit) ** 2)

    def against_design(
        self, candidate: ShapedEffect, values: Mapping[str, float], tolerances: Array
    ) -> dict[str, float]:
        """A cause's parameters with what the tolerances (n_tolerance,), whitened, of the same numbers add to them.

        Unchanged where the plant has no such tolerance.
        """
        return dict(values)

    @abstractmethod
    def bounds(self, fit: F) -> tuple[Array, Array]:
        """Bounds of the unknowns."""

    @abstractmethod
    def predict(self, fit: F, trials: Sequence[T]) -> tuple[S, ...]:
        """Predictions of trials by a fixed hypothesis; only per-trial unknowns are estimated."""

    def within_uncertainty(self, fit: F) -> tuple[S, ...] | None:
        """Predictions of the held-out trials by a hypothesis moved to them as far as the other trials let it.

        None if the plant cannot move it.
        """
        return None

    def as_read(self, predicted: tuple[S, ...]) -> tuple[S, ...]:
        """Predictions of the scored trials with the direct causes applied; unchanged if there are none."""
        return predicted

    @abstractmethod
    def squares(self, predicted: Sequence[S]) -> Array:
        """(n_trial, BLOCKS_A_TRIAL) summed squared errors of the scored trials, rad^2."""

    @abstractmethod
    def samples(self, unread: Sequence[S] = ()) -> tuple[Array, Array]:
        """(n_trial, BLOCKS_A_TRIAL) number of samples, and the sum expected from noise alone, rad^2.

        ``unread`` : predictions, if the sum is about them with the direct causes applied.
        """

    def rms(self, predicted: Sequence[S]) -> float:
        """RMS error of the scored trials, rad."""
        return float(np.sqrt(self.squares(predicted).sum() / max(float(self.samples()[0].sum()), 1.0)))

    @abstractmethod
    def left_where(
        self, predicted: Sequence[S], unread: Sequence[S] = ()
    ) -> tuple[Mapping[str, float], Mapping[str, float]]:
        """Shares of the joints and of the phases in the errors of the scored trials above the noise."""

    def freely(self, found: Hypotheses[F]) -> TrialErrors | None:
        """The error of a free-form torque on unseen trials; None if none was fitted."""
        return None

    def with_direct_causes(self, judged: Judgement[F]) -> Judgement[F]:
        """The verdict with the direct causes included."""
        return judged

    def remarks(self, stages: StagePredictions[F, S]) -> tuple[str, ...]:
        """Warnings on scored trials, independent of the verdict."""
        return ()

    def doubts(self, found: Hypotheses[F], judged: Judgement[F], motion: float) -> tuple[tuple[str, ...], float]:
        """Warnings about recordings that the verdict depends on, and the probability that a further one changes it.

        ``motion`` : with which it was judged, in noise floors.
        """
        return (), 0.0

    @abstractmethod
    def wording(self, errors: PredictionErrors) -> ErrorWording:
        """The words of the sentence for the errors."""

    @abstractmethod
    def cause_text(self, cause: Cause) -> str:
        """A cause in words, as part of the sentence."""

    @abstractmethod
    def short_text(self, cause: Cause) -> str:
        """A cause in a few words."""

    @abstractmethod
    def worse(self, errors: PredictionErrors, moved: PredictionErrors | None, words: str) -> tuple[str, ...]:
        """Warnings if the explanation predicts scored trials no better than the nominal leg.

        ``moved`` : errors of the explanation moved to held-out trials within its uncertainty, if known; ``words`` : for
        the explanation.
        """

    @abstractmethod
    def menu(self) -> Sequence[MenuItem[T]]:
        """Possible next trials."""

    @abstractmethod
    def forecast(self, fit: F, trial: T, covariance: Array) -> TrialForecast | None:
        """The prediction of a hypothesis for an imagined trial; ``covariance`` of its unknowns. None if it diverges."""

    def rivals(self, judged: Judgement[F]) -> list[tuple[F, float]]:
        """Explanations that a further trial should separate, with their weights."""
        return open_explanations(judged)

    def present_odds(self, judged: Judgement[F]) -> list[tuple[F, float]]:
        """Explanations with their present weights, where ``rivals`` holds more; none where it is the same."""
        return []

    @abstractmethod
    def remainder(self, fit: F) -> float:
        """RMS of what a fit leaves in the existing trials, over their noise; at least 1."""

    def variations(self, best: Sequence[MenuItem[T]], number: int) -> Sequence[MenuItem[T]]:
        """Further trials for the menu in round ``number``, similar to the ``best`` so far; none if it is complete."""
        return ()

    def addendum(self, verdict: Verdict, stages: StagePredictions[F, S]) -> str:
        """Text appended to the sentence."""
        return ""
