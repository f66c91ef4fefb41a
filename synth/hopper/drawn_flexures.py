"""The chosen leg with its flexures as drawn: the film's strain limit makes hinges longer, and therefore softer.

The models have one rate for all five joints, the drawn hinges three. The leg is simulated with the single rate that
stores the same energy between crouch and full extension as the drawn ones; this energy determines the speed at the
end of the stroke, apart from the timing of its release.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from synth.hopper.study import Study
from synth.jump.hopper_leg import HopperLeg
from synth.jump.jump_models import MODELS
from synth.jump.jump_runs import simulate
from synth.units import quantity

SOFTER = 0.98  # of the simulated rate: above it the simulated jump is valid
LEAST_ENERGY = 1e-3  # of the energy in the joints: with a smaller total no single rate is equivalent
JOINTS = {"hip": 2, "knee": 2, "foot": 1}  # hinges of each kind in the two-sided five-bar, which meets in one foot


@dataclass(frozen=True)
class DrawnFlexures:
    """Drawn rates (N m/rad) by joint, the equivalent single rate, and the clearance (m) with it and as simulated."""

    rates: Mapping[str, float]
    rate: float
    clearance: float
    simulated: float
    model: str

    @property
    def note(self) -> str:
        """The warning as text."""
        return (
            f"with its flexures as drawn (equivalent to {self.rate:.3g} N*m/rad for {', '.join(self.rates)}) the leg "
            f"clears {self.clearance * 100:.1f} cm instead of {self.simulated * 100:.1f} cm by model {self.model}"
        )

    def as_json(self) -> dict[str, Any]:
        """The entry ``as_drawn`` under ``parts`` in ``hopper.json``."""
        return {
            "flexure_rates": {name: quantity(rate, "N*m/rad") for name, rate in self.rates.items()},
            "equivalent_rate": quantity(self.rate, "N*m/rad"),
            "clearance": quantity(self.clearance, "cm"),
            "clearance_simulated": quantity(self.simulated, "cm"),
            "model": self.model,
        }


def drawn_flexures(found: Study, gaps: Mapping[str, float], gap: float) -> DrawnFlexures | None:
    """The chosen leg with its drawn hinges; None if they have the simulated rate.

    Parameters
    ----------
    gaps
        free length of film drawn at each joint.
    gap
        the one for the simulated rate, in the same unit.
    """
    leg, motor = found.best_leg, found.best_motor
    rates = {name: leg.flexures.rate * gap / gaps[name] for name in JOINTS}
    rate = equivalent_rate(leg, rates)
    if rate >= SOFTER * leg.flexures.rate:
        return None
    chosen = MODELS[found.project.model]
    model = chosen if chosen.engine == "lanes" else MODELS["A"]
    softer = replace(leg, flexures=replace(leg.flexures, rate=rate))
    before, after = simulate([(leg, motor), (softer, motor)], found.sweep.problem.contact, model)
    name = found.project.model if model is chosen else "A"
    return DrawnFlexures(rates, rate, after.clearance, before.clearance, name)


def equivalent_rate(leg: HopperLeg, rates: Mapping[str, float]) -> float:
    """The single rate (N m/rad) with the energy of these between the crouch and full extension.

    Joint i with rate k_i takes ``1/2 k_i (d_i1^2 - d_i0^2)``, d its angle from rest; hips and knees count twice.
    """
    start, end = _deflections(leg, leg.start), _deflections(leg, leg.extended)
    shares = {name: count * (end[name] ** 2 - start[name] ** 2) for name, count in JOINTS.items()}
    total = sum(shares.values())
    stored = sum(count * (end[name] ** 2 + start[name] ** 2) for name, count in JOINTS.items())
    if abs(total) < LEAST_ENERGY * stored:
        return sum(JOINTS[name] * rates[name] for name in JOINTS) / sum(
            JOINTS.values()
        )  # as much energy returned as stored
    return sum(rates[name] * share for name, share in shares.items()) / total


def _deflections(leg: HopperLeg, upper: float) -> dict[str, float]:
    """Distance (rad) of each joint from rest at an upper link's angle."""
    lower, rest = leg.lower_angle(upper), leg.flexures
    return {
        "hip": upper - rest.hip_rest,
        "knee": upper + lower - rest.knee_rest,
        "foot": 2.0 * lower - rest.foot_rest,
    }
