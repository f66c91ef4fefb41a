"""What a diagnosis needs of a plant: a swinging chain, a jumping leg, or another one by another adapter.

The plant's adapter knows its trials, its candidates and how they are searched; everything that is said of the
hypotheses, once they are at their best, is the same for all plants (``synth.diagnosis.diagnose``).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, Protocol, Self, TypeVar

from synth.arrays import Array
from synth.diagnosis.diagnosis_result import Cause, Verdict
from synth.diagnosis.effect_shape import ShapedEffect
from synth.diagnosis.hypotheses import HeldOutError, Hypotheses
from synth.diagnosis.prediction_error import PredictionErrors
from synth.diagnosis.sentences import ErrorWording
from synth.diagnosis.verdict import CALIBRATED, Calibration, Judged
from synth.estimation.information import TrialForecast
from synth.estimation.normal_equations import ReducedNormal


class HypothesisFit(Protocol):
    """A hypothesis fitted to trials: its causes and the whitened unknowns, tolerances first."""

    @property
    def hypothesis(self) -> Sequence[ShapedEffect]:
        """Its causes; none for the nominal leg."""

    @property
    def unknowns(self) -> Array:
        """(n_tolerance + n_effect,) whitened."""

    def at(self, unknowns: Array) -> Self:
        """The hypothesis with other unknowns, to predict with."""


F = TypeVar("F", bound=HypothesisFit)
T = TypeVar("T")  # a trial
S = TypeVar("S")  # a trial's prediction


class NamedTrial(Protocol):
    """A trial with a name."""

    @property
    def name(self) -> str:
        """The file."""


@dataclass(frozen=True)
class MenuItem(Generic[T]):
    """A trial that could be made next.

    ``what`` : in words. ``keys`` : of a ``trials:`` entry, ``file`` among them. ``trial`` : as imagined, without
    readings. ``release`` : joint -> measured angle, rad. ``ramp`` : joint, final torque (N m, in the measured angle's
    positive sense) and rise time (s) where a torque is to rise slowly. ``command`` : times (m,) s and, joint ->
    measured angle (m,) rad, where servos are to follow a command.
    """

    what: str
    keys: Mapping[str, object]
    trial: T
    release: Mapping[str, float]
    ramp: tuple[str, float, float] | None = None
    command: tuple[Array, Mapping[str, Array]] | None = None


@dataclass(frozen=True)
class StagePredictions(Generic[F, S]):
    """Scored trials predicted by the nominal leg to the letter, at its best, and with the explanation in.

    ``fits`` : of these three, to all trials to learn from. ``alone`` : label of a single cause -> as predicted with
    just that cause, of the likeliest.
    """

    fits: tuple[F, F, F]
    as_designed: tuple[S, ...]
    before: tuple[S, ...]
    after: tuple[S, ...]
    alone: Mapping[str, tuple[S, ...]]
    errors: PredictionErrors


class Plant(ABC, Generic[F, T, S]):
    """One plant with its trials.

    ``scored`` : the trials that errors are taken on, those ``held_out`` or else all; ``seed`` of the resampling;
    ``warnings`` : of the trials themselves; ``n_tolerance`` : unknowns of the leg itself.
    """

    scored: tuple[T, ...]
    held_out: bool
    seed: int
    warnings: tuple[str, ...]
    n_tolerance: int
    calibration: Calibration = CALIBRATED
    accuracy: float = 0.0  # rad: a gap below it does not matter to the user
    direct_causes: tuple[Cause, ...] = ()  # seen in the readings themselves, without any fit

    @abstractmethod
    def search(self, say: Callable[[str], None]) -> Hypotheses[F]:
        """All hypotheses brought to their best."""

    @abstractmethod
    def designed(self) -> F:
        """The nominal leg to the letter."""

    @abstractmethod
    def normal(self, fit: F) -> ReducedNormal:
        """Normal equations at a fit."""

    @abstractmethod
    def bounds(self, fit: F) -> tuple[Array, Array]:
        """Least and greatest unknowns."""

    @abstractmethod
    def predict(self, fit: F, trials: Sequence[T]) -> tuple[S, ...]:
        """Predictions of trials by a hypothesis held fixed; only what belongs to each trial is estimated."""

    def as_read(self, predicted: tuple[S, ...]) -> tuple[S, ...]:
        """Predictions of the scored trials with the direct causes in; the same where there are none."""
        return predicted

    @abstractmethod
    def squares(self, predicted: Sequence[S]) -> Array:
        """(n_trial, BLOCKS) summed squared errors of the scored trials, rad^2."""

    @abstractmethod
    def samples(self) -> tuple[Array, Array]:
        """(n_trial, BLOCKS) number of samples, and what the noise alone would sum to, rad^2."""

    @abstractmethod
    def left_where(self, predicted: Sequence[S]) -> tuple[Mapping[str, float], Mapping[str, float]]:
        """Shares of the joints, and of the phases, in what predictions of the scored trials leave above the noise."""

    def freely(self, found: Hypotheses[F]) -> HeldOutError | None:
        """What a torque of free shape leaves on unseen trials; None where none was fitted."""
        return None

    def with_direct_causes(self, judged: Judged[F]) -> Judged[F]:
        """The verdict with the direct causes in."""
        return judged

    def remarks(self, stages: StagePredictions[F, S]) -> tuple[str, ...]:
        """Warnings on scored trials, whatever the verdict."""
        return ()

    def doubts(self, found: Hypotheses[F], judged: Judged[F]) -> tuple[str, ...]:
        """Warnings of what the verdict hangs on."""
        return ()

    @abstractmethod
    def wording(self, errors: PredictionErrors) -> ErrorWording:
        """How the sentence speaks of the errors."""

    @abstractmethod
    def cause_text(self, cause: Cause) -> str:
        """A cause in words, as part of the sentence."""

    @abstractmethod
    def short_text(self, cause: Cause) -> str:
        """A cause in a few words."""

    @abstractmethod
    def worse(self, errors: PredictionErrors) -> tuple[str, ...]:
        """A warning where the explanation predicts scored trials no better than the nominal leg does."""

    @abstractmethod
    def menu(self) -> Sequence[MenuItem[T]]:
        """Trials that could be made next."""

    @abstractmethod
    def forecast(self, fit: F, trial: T, covariance: Array) -> TrialForecast | None:
        """What a hypothesis predicts of an imagined trial; ``covariance`` of its unknowns. None where it diverges."""

    def addendum(self, verdict: Verdict, stages: StagePredictions[F, S]) -> str:
        """What is added to the sentence."""
        return ""
