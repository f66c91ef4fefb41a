"""What the diagnosis of a swinging chain found, and how it writes itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.diagnosis.diagnosis_result import Diagnosis
from synth.diagnosis.hypotheses import HeldOutError
from synth.estimation.intervals import Estimate
from synth.swing.leg_model import Leg
from synth.units import quantity


@dataclass(frozen=True)
class TrialGap:
    """One trial: measured angles in rad beside the nominal leg to the letter, at its best, and with the explanation.

    ``time`` (m,) s; ``measured`` (m, n), nan where no sample counts; ``as_designed``, ``before``, ``after`` (m, n);
    ``missing_torque`` (m, n) N m, that the nominal leg at its best lacks to have moved as measured (nan where it is
    not known), ``speed`` (m, n) rad/s and ``deflection`` (m, n) rad from the free angle; ``phase`` (m,) index into
    ``PHASES``. ``scored`` : the gap's figures are taken on it. ``alone`` : label of a single cause -> (m, n) rad with
    just that cause in, of the likeliest.
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


Over = Literal["deflection", "speed"]  # what a free torque depends on


@dataclass(frozen=True)
class FreeTorque:
    """A torque of free shape at one joint.

    ``over`` : what its hats depend on. ``place`` (k,) their middles, rad from the free angle or rad/s, in the measured
    angle's sense; ``direction`` (k,) of motion, +1 or -1, 0 where they are over speed; ``torque`` (k,) N m in that
    sense, ``low`` and ``high`` its 90 % interval by leaving out one trial after the other (jackknife).
    ``taken`` : share of the error's RMS above the noise that it takes away on trials that took no part; ``unseen`` :
    what it leaves there.
    """

    joint: str
    over: Over
    place: Array
    direction: Array
    torque: Array
    low: Array
    high: Array
    taken: float
    unseen: HeldOutError

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
    ``scored_on`` trials. ``noise`` : joint -> its noise, rad. ``best_possible`` : RMS that the best set of effects of
    the library reaches there, however unlikely. ``warnings`` : what the data themselves leave in doubt.
    ``diagnosed`` : the nominal leg with the explanation in. ``free_torque`` : what is missing, whatever its cause.
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
            "noise": {name: quantity(value, "deg") for name, value in self.noise.items()},
            "next_experiment": self.next_as_json(),
            "warnings": list(self.warnings),
            "inputs": dict(self.inputs),
        }
