"""The result of a swinging chain's diagnosis, and its JSON."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.diagnosis.diagnosis_result import Diagnosis
from synth.diagnosis.hypotheses import TrialErrors
from synth.diagnosis.plants.swinging_chain.moved_numbers import MovedNumber
from synth.estimation.intervals import Estimate
from synth.remarks import remarks_json
from synth.swing.leg_model import Leg
from synth.units import quantity


@dataclass(frozen=True)
class TrialGap:
    """One trial: measured angles in rad with the predictions of the unchanged nominal leg, of its best fit, and
    with the explanation.

    ``time`` (m,) s; ``measured`` (m, n), nan for samples that do not count; ``as_designed``, ``before``, ``after``
    (m, n);
    ``missing_torque`` (m, n) N m, needed by the nominal leg's best fit to move as measured (nan if
    unknown), ``speed`` (m, n) rad/s and ``deflection`` (m, n) rad from the free angle; ``phase`` (m,) index into
    ``PHASES``. ``scored`` : used for the figures of the gap. ``alone`` : label of a single cause -> (m, n) rad with
    only that cause, for the most probable ones. ``command`` : name of a joint that a servo drives -> (m,) rad, as it
    was told at each sample.
    """

    name: str
    time: Array
    measured: Array
    as_designed: Array
    before: Array
    after: Array
    missing_torque: Array
    speed: Array
    deflection: Array
    phase: NDArray[np.int64]
    held_out: bool
    scored: bool
    alone: Mapping[str, Array] = field(default_factory=dict)
    command: Mapping[str, Array] = field(default_factory=dict)


Over = Literal["deflection", "speed"]  # independent variable of a free torque


@dataclass(frozen=True)
class FreeTorque:
    """A free-form torque at one joint.

    ``over`` : its independent variable. ``place`` (k,) centres of its hat functions, rad from the free angle or rad/s,
    in the measured angle's sense; ``direction`` (k,) of motion, +1 or -1, 0 over speed; ``torque`` (k,) N m in that
    sense, ``low`` and ``high`` its 90 % interval by leaving out one fold of the trials after the other (jackknife).
    ``taken`` : share of the error's RMS above the noise that it removes on left-out trials; ``unseen`` : the error that
    remains there.
    """

    joint: str
    over: Over
    place: Array
    direction: Array
    torque: Array
    low: Array
    high: Array
    taken: float
    unseen: TrialErrors

    def as_json(self) -> dict[str, Any]:
        """One entry of ``free_torque`` in ``gap.json``."""
        unit = "rad" if self.over == "deflection" else "rad/s"
        return {
            "joint": self.joint,
            "over": self.over,
            "taken": quantity(self.taken, "1"),
            "curve": {
                "place": {"value": self.place.tolist(), "unit": unit},
                "direction": self.direction.tolist(),
                "torque": {"value": self.torque.tolist(), "unit": "N*m"},
                "low": {"value": self.low.tolist(), "unit": "N*m"},
                "high": {"value": self.high.tolist(), "unit": "N*m"},
            },
        }


@dataclass(frozen=True)
class GapResult(Diagnosis):
    """The whole diagnosis of a swinging leg.

    ``as_designed``, ``before``, ``after``, ``noise_floor`` : RMS angle errors in rad over joints and samples of the
    ``scored_on`` trials. ``noise`` : joint -> noise, rad. ``best_possible`` : RMS with the best set of effects of
    the library, regardless of probability. ``warnings`` about the data.
    ``diagnosed`` : the nominal leg with the explanation applied. ``free_torque`` : the missing torque, regardless
    of its cause. ``moved_numbers`` : stated numbers that the fit moves far within their tolerances.
    """

    leg: Leg
    as_designed: Estimate
    before: Estimate
    after: Estimate
    noise_floor: Estimate
    shrink: Estimate
    best_possible: Estimate
    noise: Mapping[str, float]
    scored_on: tuple[str, ...]
    trials: tuple[TrialGap, ...]
    diagnosed: Leg
    free_torque: tuple[FreeTorque, ...] = ()
    moved_numbers: tuple[MovedNumber, ...] = ()
    inputs: Mapping[str, str] = field(default_factory=dict)

    def as_json(self) -> dict[str, Any]:
        """``gap.json``."""
        gap = {
            "as_designed": self.as_designed.as_json(),
            "before": self.before.as_json(),
            "after": self.after.as_json(),
            "noise_floor": self.noise_floor.as_json(),
            "best_possible": self.best_possible.as_json(),
            "shrink": self.shrink.as_json(),
            "scored_on": list(self.scored_on),
        }
        return {
            **self.said_as_json(self.leg.name),
            "gap": gap,
            "free_torque": [item.as_json() for item in self.free_torque],
            "moved_numbers": [item.as_json() for item in self.moved_numbers],
            "noise": {name: quantity(value, "deg") for name, value in self.noise.items()},
            "next_experiment": self.next_as_json(),
            **remarks_json(self.warnings),
            "inputs": dict(self.inputs),
        }
