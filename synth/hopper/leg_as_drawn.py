"""The chosen leg as drawn: the film's strain limit makes hinges longer and softer, and its links are flat strips.

The models have one rate for all five joints, the drawn hinges three. The leg is simulated with the single rate that
stores the same energy between crouch and full extension as the drawn ones; this energy determines the speed at the
end of the stroke, apart from the timing of its release. The links have mass and bending stiffness of a flat strip of
the laminate, which a link measured elsewhere (a folded beam, another laminate) need not have.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from synth.hopper.study import Study
from synth.jump.hopper_leg import HopperLeg, Laminate
from synth.jump.jump_models import MODELS
from synth.jump.jump_runs import simulate
from synth.units import quantity

SOFTER = 0.98  # of the simulated rate: above it the simulated jump is valid
LEAST_ENERGY = 1e-3  # of the energy in the joints: with a smaller total no single rate is equivalent
SAME_LINK = 1.25  # a quarter of its mass or stiffness: more than a laminate's scatter
JOINTS = {"hip": 2, "knee": 2, "foot": 1}  # hinges of each kind in the two-sided five-bar, which meets in one foot


@dataclass(frozen=True)
class LegAsDrawn:
    """The leg as drawn beside the simulated one.

    ``rates`` (N m/rad) by joint and the equivalent single ``rate``; ``softer``: it is below the simulated one.
    ``links``: mass per length (kg/m) and bending stiffness (N m^2) as drawn, a flat strip, and ``links_simulated``.
    ``total_mass`` kg as drawn. ``clearance`` m with flexures and links as drawn, ``flexures_alone`` with the simulated
    links, ``simulated`` without either.
    """

    rates: Mapping[str, float]
    rate: float
    softer: bool
    links: tuple[float, float]
    links_simulated: tuple[float, float]
    total_mass: float
    clearance: float
    flexures_alone: float
    simulated: float
    model: str

    @property
    def note(self) -> str:
        """The warning as text."""
        strip, own = (
            f"{1e3 * mass:.3g} g/m and E I = {bend:.3g} N*m^2" for mass, bend in (self.links, self.links_simulated)
        )
        what = f"links as drawn ({strip} instead of {own}; the leg weighs {1e3 * self.total_mass:.1f} g)"
        alone = ""
        if self.softer:
            what = f"flexures (equivalent to {self.rate:.3g} N*m/rad for {', '.join(self.rates)}) and {what}"
            alone = f"; with its flexures alone as drawn {self.flexures_alone * 100:.1f} cm"
        return (
            f"with its {what} the leg clears {self.clearance * 100:.1f} cm instead of {self.simulated * 100:.1f} cm "
            f"by model {self.model}{alone}"
        )

    def as_json(self) -> dict[str, Any]:
        """The entry ``as_drawn`` under ``parts`` in ``hopper.json``."""
        flexures = {
            "flexure_rates": {name: quantity(rate, "N*m/rad") for name, rate in self.rates.items()},
            "equivalent_rate": quantity(self.rate, "N*m/rad"),
            "clearance_flexures_alone": quantity(self.flexures_alone, "cm"),
        }
        return {
            **(flexures if self.softer else {}),
            "link_mass_per_length": quantity(self.links[0], "kg/m"),
            "link_bending_stiffness": quantity(self.links[1], "N*m^2"),
            "total_mass": quantity(self.total_mass, "g"),
            "clearance": quantity(self.clearance, "cm"),
            "clearance_simulated": quantity(self.simulated, "cm"),
            "model": self.model,
        }


def links_differ(laminate: Laminate) -> bool:
    """Whether a flat strip of it is another link than the simulated one, in mass or bending."""
    shares = (
        laminate.mass_per_length / laminate.strip_mass_per_length,
        laminate.bending_stiffness / laminate.strip_bending_stiffness,
    )
    return not all(1.0 / SAME_LINK < share < SAME_LINK for share in shares)


def leg_as_drawn(found: Study, gaps: Mapping[str, float], gap: float) -> LegAsDrawn | None:
    """The chosen leg with its drawn hinges and links; None if they are those simulated.

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
    softer, laminate = rate < SOFTER * leg.flexures.rate, leg.laminate
    if not (softer or links_differ(laminate)):
        return None
    chosen = MODELS[found.project.model]
    model = chosen if chosen.engine == "lanes" else MODELS["A"]
    links = laminate.strip_mass_per_length, laminate.strip_bending_stiffness
    strip = replace(laminate, mass_per_length=links[0], bending_stiffness=links[1])
    alone = replace(leg, flexures=replace(leg.flexures, rate=rate if softer else leg.flexures.rate))
    drawn = replace(alone, laminate=strip)
    before, between, after = simulate(
        [(leg, motor), (alone, motor), (drawn, motor)], found.sweep.problem.contact, model
    )
    return LegAsDrawn(
        rates, rate, softer, links, (laminate.mass_per_length, laminate.bending_stiffness), drawn.total_mass(motor),
        after.clearance, between.clearance, before.clearance, model.name,
    )  # fmt: skip


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
