"""Effects that are a wrong number of the leg which has a tolerance of its own, and the number with both."""

from __future__ import annotations

from collections.abc import Mapping
from math import exp
from typing import TYPE_CHECKING

from synth.arrays import Array
from synth.swing.leg_model import Leg
from synth.swing.tolerances import QUANTITIES, Tolerances

if TYPE_CHECKING:
    pass

# Effect -> its parameters, and the number of the leg that each changes.
NUMBERS_CHANGED: dict[str, tuple[tuple[str, str], ...]] = {
    "link_mass": (("share", "mass"),),
    "link_inertia": (("com", "com"), ("inertia", "inertia")),
    "spring_rate": (("rate", "spring_rate"), ("free_angle", "rest")),
    "viscous_damping": (("rate", "damper_rate"),),
    "spring_preload": (("shift", "rest"),),
    "torque_constant": (("share", "torque_constant"),),
    "winding_resistance": (("share", "resistance"),),
    "torque_gain": (("share", "torque_constant"),),  # where a recorded current tells the torque
}
RATES = ("spring_rate", "damper_rate")  # their values are given in N m/rad, not as a share


def against_design(
    key: tuple[str, str], values: Mapping[str, float], leg: Leg, tolerances: Tolerances, x: Array
) -> dict[str, float]:
    """Parameters of an effect at a place (``key``), in SI, with what the tolerances of the same numbers add to them.

    ``x`` (9 n,) the tolerances' unknowns, which ``Tolerances.apply`` puts on the leg before the effect.
    """
    effect, place = key
    found = dict(values)
    if effect not in NUMBERS_CHANGED or place not in leg.joint_names:
        return found
    joint = leg.joint_names.index(place)
    shifts = (x.reshape(len(QUANTITIES), -1) * tolerances.width)[:, joint]
    for parameter, quantity in NUMBERS_CHANGED[effect]:
        shift = float(shifts[QUANTITIES.index(quantity)])
        if parameter not in found or shift == 0.0 or (effect == "torque_gain" and joint not in tolerances.by_current):
            continue
        if quantity == "rest":
            found[parameter] += leg.joints[joint].sign * shift
        elif quantity in RATES:
            nominal = nominal_rate(leg, joint, quantity)
            found[parameter] = max(nominal * exp(shift) + found[parameter], 0.0) - nominal
        else:
            found[parameter] = exp(shift) * (1.0 + found[parameter]) - 1.0
    return found


def nominal_rate(leg: Leg, joint: int, quantity: str) -> float:
    """N m/rad or N m s/rad of the designed leg; 0 if there is none, or only a curve."""
    spring, damper = leg.joints[joint].spring, leg.joints[joint].damper
    if quantity == "spring_rate":
        return spring.rate if spring is not None else 0.0
    return (damper.rate or 0.0) if damper is not None else 0.0
