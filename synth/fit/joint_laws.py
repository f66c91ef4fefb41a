"""Laws of a joint's torque that a leg of springs and linear dampers lacks most often, and what a search has found.

Of a spring's odd laws the cube of the deflection is the first beside the linear one (Duffing). ``synth gap`` has more.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.estimation.intervals import NORMAL90
from synth.fit.model_error import ModelError
from synth.swing.leg_model import Leg
from synth.units import quantity


@dataclass(frozen=True)
class JointLaw:
    """A torque beside spring and damper: the ``effect``, its ``key`` and ``unit``, what it is called, ``where`` it is.

    It is proportional to the ``power`` of speed, which it opposes, or with ``of_deflection`` to that of the spring's
    deflection, and then of either sign. ``residue`` : of the mean squared error above the samples' scatter, what it
    must leave at most to be part of the leg.
    """

    effect: str
    key: str
    unit: str
    words: str
    where: str
    power: int
    residue: float
    of_deflection: bool = False


# Of an error above the scatter, what a law must leave at most to be named. The right law leaves what the links' errors
# make; where a hand is the cause, a law of speed takes little of what acts at first only. Between the two it is a
# choice; ``make laws`` counts the legs on either side.
LAW_RESIDUE = 0.2
# The same of a spring: let go at a large deflection, a damped leg never comes back there, and the cube of deflection
# takes much of a hand's torque. What it leaves of it shows all the same (``make laws``).
SPRING_RESIDUE = 0.05

# Sought by a fit in this order; the one that leaves least is taken.
LAWS = (
    JointLaw("coulomb_friction", "torque", "N*m", "dry friction", "joint rubs", 0, LAW_RESIDUE),
    JointLaw(
        "quadratic_damping",
        "coefficient",
        "N*m*s^2/rad^2",
        "damping that grows with the square of speed",
        "joint rubs",
        2,
        LAW_RESIDUE,
    ),
    JointLaw(
        "hardening_spring",
        "stiffening",
        "N*m",
        "a spring torque that grows with the cube of deflection, given at 1 rad and softening where negative,",
        "spring is not linear",
        3,
        SPRING_RESIDUE,
        of_deflection=True,
    ),
)


@dataclass(frozen=True)
class AnotherLaw:
    """``size`` (n,) of the law's coefficient at each joint, SI, 0 where it does not act, ``deviation`` (n,) of it.

    ``leg`` : the given one with it as its effect. ``of_rates`` : error of the common unknowns by that of the
    coefficients. ``left`` : share of the error that stays. ``values`` (p,) of the common unknowns beside it, ``rms``
    (n,) rad of what they leave. ``named`` : whether it explains so much that it is part of the leg.
    """

    law: JointLaw
    leg: Leg
    size: Array
    deviation: Array
    of_rates: ModelError
    left: float
    values: Array
    rms: Array
    named: bool = False

    @property
    def coefficients_in_words(self) -> str:
        """The coefficients with their intervals."""
        return ", ".join(
            f"{joint.name} {size:.3g} +- {NORMAL90 * deviation:.2g} {self.law.unit}"
            for joint, size, deviation in zip(self.leg.joints, self.size, self.deviation, strict=True)
            if size != 0.0
        )

    def error_of_cut(self, values: Array) -> ModelError:
        """The error of a fit to later samples that explains no more, whose common unknowns are ``values`` (p,).

        Its whole distance from the fit with the law is one standard deviation, of all unknowns together.
        """
        sentence = (
            f"release: {self.law.words} explains all samples as well as a torque at first explains the others: "
            f"{self.coefficients_in_words}. These recordings do not tell which, and the intervals include the "
            f"difference of the rates. If the {self.law.where}, write "
            f"effects: [{{{self.law.effect}: {{{self.law.key}: ...}}}}] in the leg file, and release: recorded"
        )
        return ModelError((self.values - values)[:, None], sentence)

    @property
    def error(self) -> ModelError:
        """The error of the coefficients, with the finding and how to write it."""
        law = self.law
        explained = 100 * min(1 - self.left, 1.0)
        sentence = (
            f"{law.words} explains {explained:.0f} % of what springs and linear dampers leave: "
            f"{self.coefficients_in_words}. It is part of the fitted leg and its uncertainty is in the intervals. "
            f"To state it beforehand, write effects: [{{{law.effect}: {{{law.key}: ...}}}}] at the joint in the leg "
            "file; to fit without it, laws: linear"
        )
        return replace(self.of_rates, sentence=sentence)

    def as_json(self) -> dict[str, Any]:
        """The entry ``law`` of ``fit.json``."""
        least = -np.inf if self.law.of_deflection else 0.0
        sizes = {
            joint.name: quantity(size, self.law.unit, (max(least, size - NORMAL90 * width), size + NORMAL90 * width))
            for joint, size, width in zip(self.leg.joints, self.size.tolist(), self.deviation.tolist(), strict=True)
            if size != 0.0
        }
        return {"effect": self.law.effect, self.law.key: sizes, "explains": min(1.0 - self.left, 1.0)}


def with_law(leg: Leg, law: JointLaw, size: Array) -> Leg:
    """The leg with coefficients (n,) of the law at its joints, none where they are zero."""
    return leg.with_joints(**{
        joint.name: {"effects": {law.effect: {law.key: float(each)}}}
        for joint, each in zip(leg.joints, size, strict=True)
        if each != 0.0
    })  # fmt: skip
