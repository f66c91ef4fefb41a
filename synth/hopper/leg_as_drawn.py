"""The chosen leg as drawn: the film's strain limit makes hinges longer and softer, and its links are flat strips.

A project has one rate for all five joints, the drawn hinges three, with which the leg is simulated. No single rate
stands for them: the knees give energy to the stroke while hips and foot may take it. The smallest of the three can be
drawn at every joint. The links have mass and bending stiffness of a flat strip of the laminate, which a link measured
elsewhere (a folded beam, another laminate) need not have.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.hopper.study import Study
from synth.jump.hopper_leg import Bending, Laminate
from synth.jump.jump_layout import LAYOUTS
from synth.jump.jump_models import MODELS, lane
from synth.jump.jump_runs import compiled_jump
from synth.jump.outcomes import outcome_of
from synth.units import quantity

SOFTER = 0.98  # of the simulated rate: where every joint is above it, the simulated jump is valid
SAME_LINK = 1.25  # a quarter of its mass or stiffness: more than a laminate's scatter
JOINTS = ("hip", "knee", "foot")


@dataclass(frozen=True)
class LegAsDrawn:
    """The leg as drawn beside the simulated one.

    ``rates`` (N m/rad) by joint; ``softer``: one is below the simulated rate.
    ``links``: mass per length (kg/m) and bending stiffness (N m^2) as drawn, a flat strip, and ``links_simulated``.
    ``total_mass`` kg as drawn. ``clearance`` m with flexures and links as drawn, ``flexures_alone`` with the simulated
    links, ``simulated`` without either.
    """

    rates: Mapping[str, float]
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
            each = ", ".join(f"{name} {rate:.3g}" for name, rate in self.rates.items())
            what = f"flexures ({each} N*m/rad) and {what}"
            alone = f"; with its flexures alone as drawn {self.flexures_alone * 100:.1f} cm"
        return (
            f"with its {what} the leg clears {self.clearance * 100:.1f} cm instead of {self.simulated * 100:.1f} cm "
            f"by model {self.model}{alone}"
        )

    def as_json(self) -> dict[str, Any]:
        """The entry ``as_drawn`` under ``parts`` in ``hopper.json``."""
        flexures = {
            "flexure_rates": {name: quantity(rate, "N*m/rad") for name, rate in self.rates.items()},
            "rate_for_all_joints": quantity(min(self.rates.values()), "N*m/rad"),
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
    softer, laminate = min(rates.values()) < SOFTER * leg.flexures.rate, leg.laminate
    if not (softer or links_differ(laminate)):
        return None
    chosen = MODELS[found.project.model]
    model = chosen if chosen.engine == "lanes" else MODELS["A"]
    links = laminate.strip_mass_per_length, laminate.strip_bending_stiffness
    strip = replace(laminate, mass_per_length=links[0], bending_stiffness=links[1])
    drawn, contact = replace(leg, laminate=strip), found.sweep.problem.contact
    simulated = lane(leg, motor, contact, model)
    alone, both = (with_hinges(lane(one, motor, contact, model), leg.bending, rates) for one in (leg, drawn))
    lanes = np.column_stack([simulated, alone if softer else simulated, both])
    before, between, after = map(outcome_of, compiled_jump(leg.bending).run(lanes).T)
    return LegAsDrawn(
        rates, softer, links, (laminate.mass_per_length, laminate.bending_stiffness), drawn.total_mass(motor),
        after.clearance, between.clearance, before.clearance, model.name,
    )  # fmt: skip


def with_hinges(parameters: Array, bending: Bending, rates: Mapping[str, float]) -> Array:
    """A lane (n_row,) of ``jump_models.lane`` with ``rates`` N m/rad by joint, each of ``JOINTS``."""
    found = parameters.copy()
    for name in JOINTS:
        found[LAYOUTS[bending].row(f"{name}_rate")] = rates[name]
    return found
