"""The result of a diagnosis, and its JSON."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from synth.arrays import Array
from synth.diagnosis.remainder import Remainder
from synth.estimation.intervals import Estimate
from synth.units import quantity

FORMAT = "synth/gap/1"
Verdict = Literal["effect", "none", "tie", "unknown"]
# How the scored trials were predicted: left out of the diagnosis, each by a fit to the others, each piece of the one
# recording by a fit to the other pieces, or by the fit to the one trial itself.
ScoredBy = Literal["held_out", "in_turn", "pieces_in_turn", "fitted"]
PHASES = ("release", "swing", "settle", "rest")
THIRDS = ("low", "middle", "high")


@dataclass(frozen=True)
class Cause:
    """One effect at one place with its parameters; ``joint`` is a joint's name or ``base``.

    ``absent`` : the design states the effect, and it is not there.
    """

    effect: str
    joint: str
    parameters: Mapping[str, Estimate]
    absent: bool = False

    def as_json(self) -> dict[str, Any]:
        """The entry under ``explanation``."""
        written = {name: estimate.as_json() for name, estimate in self.parameters.items()}
        return {"effect": self.effect, "joint": self.joint, "parameters": written}


@dataclass(frozen=True)
class RankedCause:
    """A single candidate cause: its probability, and its reduction of the gap on scored trials when alone.

    ``shrink`` is None if the cause was fitted beside others only.
    """

    cause: Cause
    probability: float
    shrink: Estimate | None

    def as_json(self) -> dict[str, Any]:
        """The entry under ``ranked``."""
        shrink = {} if self.shrink is None else {"shrink": self.shrink.as_json()}
        return {**self.cause.as_json(), "probability": self.probability, **shrink}


@dataclass(frozen=True)
class Where:
    """Shares of the gap, each mapping summing to 1; by joint, phase, speed, deflection, load and time.

    ``speed``, ``position``, ``load`` and ``time``: label of a bin, "low", "middle" or "high" third -> share.
    """

    joint: Mapping[str, float]
    phase: Mapping[str, float]
    speed: Mapping[str, float]
    position: Mapping[str, float]
    load: Mapping[str, float]
    time: Mapping[str, float]

    def as_json(self) -> dict[str, Any]:
        """The entry ``where``."""
        names = ("joint", "phase", "speed", "position", "load", "time")
        return {name: dict(getattr(self, name)) for name in names}


def shares(labels: Sequence[str], total: Array) -> dict[str, float]:
    """Label -> its share of the positive values; equal shares if there are none."""
    positive = np.maximum(total, 0.0)
    if positive.sum() <= 0.0:
        return dict.fromkeys(labels, 1.0 / len(labels))
    return {label: float(value) for label, value in zip(labels, positive / positive.sum(), strict=True)}


COMMAND_FILE = "next_command.csv"  # in the output folder


@dataclass(frozen=True)
class Experiment:
    """The trial that would best separate the remaining explanations: reason, ``trials:`` entry, and release.

    ``trial`` : keys of a ``trials:`` entry in addition to ``file``; ``release`` joint name -> measured angle, rad;
    ``information`` : expected information in bits; ``menu`` : all considered trials with theirs; ``ramp`` : joint,
    final torque (N m, in the measured angle's positive sense) and rise time (s) of a slowly rising torque;
    ``command`` : times (m,) s and, joint -> measured angle (m,) rad, a command for servos.
    """

    why: str
    trial: Mapping[str, Any]
    release: Mapping[str, float]
    information: float
    menu: tuple[tuple[str, float], ...] = ()
    ramp: tuple[str, float, float] | None = None
    command: tuple[Array, Mapping[str, Array]] | None = None

    def as_json(self) -> dict[str, Any]:
        """The entry ``next_experiment``."""
        release = {name: quantity(angle, "deg") for name, angle in self.release.items()}
        menu = [{"what": what, "information": quantity(bits, "bit")} for what, bits in self.menu]
        information = quantity(self.information, "bit")
        written: dict[str, Any] = {"why": self.why, "trial": dict(self.trial), "release": release}
        if self.ramp is not None:
            joint, torque, time = self.ramp
            written["torque"] = {"joint": joint, "rises_to": quantity(torque, "N*m"), "in": quantity(time, "s")}
        if self.command is not None:
            written["command"] = COMMAND_FILE
        return written | {"information": information, "menu": menu}


@dataclass(frozen=True)
class Diagnosis:
    """The diagnosis of a built leg, swinging or jumping.

    ``explanation`` : the accepted causes, or the nearest ones if no known cause explains the trials;
    ``tied`` : other sets of causes that explain the trials equally well. ``remainder`` : the unexplained part.
    ``within_accuracy`` : the gap is below the required accuracy, so causes were not judged: verdict "none".
    """

    verdict: Verdict
    sentence: str
    explanation: tuple[Cause, ...]
    ranked: tuple[RankedCause, ...]
    probability_none: float
    probability_unknown: float
    tied: tuple[tuple[Cause, ...], ...]
    where: Where
    remainder: Remainder
    next_experiment: Experiment | None
    warnings: tuple[str, ...]
    scored_by: ScoredBy
    within_accuracy: bool

    def said_as_json(self, name: str) -> dict[str, Any]:
        """The entries of ``gap.json`` up to ``where``; ``name`` of the leg."""
        return {
            "format": FORMAT,
            "name": name,
            "verdict": self.verdict,
            "within_accuracy": self.within_accuracy,
            "sentence": self.sentence,
            "explanation": [cause.as_json() for cause in self.explanation],
            "ranked": [entry.as_json() for entry in self.ranked],
            "probability_none": self.probability_none,
            "probability_unknown": self.probability_unknown,
            "tied": [[cause.as_json() for cause in causes] for causes in self.tied],
            "where": self.where.as_json(),
            "remainder": self.remainder.as_json(),
            "scored_by": self.scored_by,
        }

    def next_as_json(self) -> dict[str, Any] | None:
        """The entry ``next_experiment``."""
        return None if self.next_experiment is None else self.next_experiment.as_json()
