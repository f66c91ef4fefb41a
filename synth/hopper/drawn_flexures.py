"""What the chosen leg does with its flexures as they are drawn: the film's strain makes hinges longer, and so softer.

The models have one rate for all five joints, the drawn hinges three. The leg is simulated with the one rate that takes
as much energy between crouch and full extension as the drawn ones together do; of a stroke that is all that a spring's
rate decides about the speed at its end, what is left is when the energy is taken.
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

SOFTER = 0.98  # of the simulated rate: above it the leg jumps as simulated
LEAST = 1e-3  # of the energy that the joints hold: with less on the whole no one rate stands for several
JOINTS = {"hip": 2, "knee": 2, "foot": 1}  # hinges of a kind in the two-sided five-bar: both sides meet in one foot


@dataclass(frozen=True)
class DrawnFlexures:
    """Rates as drawn (N m/rad) by joint, the one that stands for them, the clearance (m) with it and as simulated."""

    rates: Mapping[str, float]
    rate: float
    clearance: float
    simulated: float
    model: str

    @property
    def note(self) -> str:
        """What to know, for people."""
        return (
            f"with its flexures as drawn ({self.rate:.3g} N*m/rad stand for the {', '.join(self.rates)} ones) the leg "
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
    """The chosen leg with its drawn hinges; None where they have the simulated rate.

    Parameters
    ----------
    gaps
        free length of film drawn at each joint.
    gap
        the one that the simulated rate asks for, in the same unit.
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
    """The one rate (N m/rad) that takes the energy of these between the crouch and full extension.

    Joint i with rate k_i takes ``1/2 k_i (d_i1^2 - d_i0^2)``, d its angle from rest; hips and knees count twice.
    """
    start, end = _deflections(leg, leg.start), _deflections(leg, leg.extended)
    shares = {name: count * (end[name] ** 2 - start[name] ** 2) for name, count in JOINTS.items()}
    total = sum(shares.values())
    stored = sum(count * (end[name] ** 2 + start[name] ** 2) for name, count in JOINTS.items())
    if abs(total) < LEAST * stored:
        return sum(JOINTS[name] * rates[name] for name in JOINTS) / sum(JOINTS.values())  # as much given as taken
    return sum(rates[name] * share for name, share in shares.items()) / total


def _deflections(leg: HopperLeg, upper: float) -> dict[str, float]:
    """How far (rad) each joint is from rest at an upper link's angle."""
    lower, rest = leg.lower_angle(upper), leg.flexures
    return {
        "hip": upper - rest.hip_rest,
        "knee": upper + lower - rest.knee_rest,
        "foot": 2.0 * lower - rest.foot_rest,
    }
