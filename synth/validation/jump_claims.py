"""The jumping leg's published claims beside ours, and the configuration under which the published heights follow.

Published: C. Knaup & D. Aukes on a laminate five-bar leg (all numbers in its text; the curves are figures without
values). The leg's and motor's numbers are those of the laboratory's own simulation (idealabasu/code_pynamics,
parallel_five_bar_jumper_compliance.py at 6a9e0be, 2019). What neither gives, the crouch, is calibrated once: on the
22 cm that model D predicts for the built leg. Everything else follows.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import cos, degrees, radians, sin

import numpy as np

from synth.arrays import Array
from synth.hopper.hopper_tolerances import contributions, groups, intervals
from synth.jump.hopper_leg import LOCKED, Contact, Flexures, HopperLeg, HopperTolerances, Motor, in_reach
from synth.jump.jump_models import MODELS, lanes
from synth.jump.jump_runs import compiled_jump
from synth.jump.outcomes import CLEARANCE, heights
from synth.jump.point_mass import point_mass_outcomes

# The study's text: model D's prediction and the mean of three jumps for the built leg, m; its length and gear.
PREDICTED, MEASURED = 0.22, 0.183
LENGTH, RATIO = 0.12, 210.59
BEST_LENGTHS = "12 to 14 cm"
SHORT_LENGTH, SHORT_RATIO = 0.08, 150.58  # of the better relative height, without a number
# The laboratory's code: "00016*5.7/4.3586" is torque constant (kgf m/A) times volts over ohms, links of 3 g a 12 cm.
TORQUE_CONSTANT, SUPPLY, RESISTANCE = 0.00016 * 9.80665, 5.7, 4.3586
# Its ground stretches by twice the penetration, so that 1 kN/m counts double.
GROUND = Contact(stiffness=2e3, damping=10.0)
FREE_CURRENT = 0.1  # A, of the maker's table for this size of motor (N20 HP at 6 V)
MOTOR_MASS = 0.0095  # kg, the maker's
ROTOR_INERTIA = 1.5e-8  # kg m^2, a public estimate; see hopper.motors
ELECTRICAL_TIME = 0.25e-3  # s, as in hopper.motors
RATIOS = (29.86, 51.45, 75.81, 100.37, 150.58, 210.59, 248.98, 297.92, 379.0)  # the maker's, one size of motor
LENGTHS = np.round(np.arange(0.06, 0.2001, 0.01), 3)  # m
SUITABLE = 0.14  # m, the longest leg that the study speaks of
BISECTIONS = 24  # of an angle or a logarithm: to a ten-millionth of the range
LIGHTEST, HEAVIEST = 1e-10, 4e-8  # kg m^2, between which the rotor inertia is sought
TOLERANCES = HopperTolerances()
HALF_WIDTH = 0.1  # of the height: what a 90 % interval may have at most to test a prediction


@dataclass(frozen=True)
class Configuration:
    """A supply, V, and a leg: ``damping`` N m s/rad a joint, ``crouch`` rad of the upper link from straight down."""

    supply: float = SUPPLY
    damping: float = Flexures.damping
    crouch: float = HopperLeg.crouch
    inertia: float = ROTOR_INERTIA

    @property
    def leg(self) -> HopperLeg:
        """At 12 cm; the sweep gives other lengths."""
        return HopperLeg(length=LENGTH, crouch=self.crouch, flexures=Flexures(damping=self.damping))

    def motor(self, ratio: float) -> Motor:
        """The laboratory's motor line behind a gear without loss, as its simulation has it."""
        stall = self.supply / RESISTANCE
        return Motor(
            name=f"{ratio:.0f}:1",
            ratio=ratio,
            voltage=self.supply,
            stall_torque=TORQUE_CONSTANT * stall * ratio,
            no_load_speed=(self.supply - FREE_CURRENT * RESISTANCE) / (ratio * TORQUE_CONSTANT),
            stall_current=stall,
            no_load_current=FREE_CURRENT,
            mass=MOTOR_MASS,
            inductance=ELECTRICAL_TIME * RESISTANCE,
            rotor_inertia=self.inertia,
            friction=FREE_CURRENT * TORQUE_CONSTANT,
            viscous=0.0,
            back_emf=TORQUE_CONSTANT,
            torque_constant=TORQUE_CONSTANT,
            resistance=RESISTANCE,
        )

    def height(self, model: str, *, ratio: float = RATIO, row: int = CLEARANCE) -> float:
        """Clearance, or another height, of the 12 cm leg, m; 0 where it does not jump."""
        return float(self.by_length(model, ratio, np.array([LENGTH]), row)[0])

    def by_length(self, model: str, ratio: float, length: Array, row: int = CLEARANCE) -> Array:
        """(n,) m for upper links of these lengths (n,) m; 0 where the crouch is out of reach."""
        found, leg = np.zeros(len(length)), self.leg
        if model == "point_mass":
            return heights(point_mass_outcomes(leg, self.motor(ratio), length), row)
        reach = in_reach(leg, length)
        if reach.any():
            made = lanes(leg, self.motor(ratio), GROUND, MODELS[model], length[reach])
            found[reach] = heights(compiled_jump(leg.bending).run(made), row)
        return found

    def best(self, model: str, longest: float = float(LENGTHS[-1])) -> Best:
        """The highest clearance over the maker's gears and these legs."""
        length = LENGTHS[: int(np.searchsorted(LENGTHS, longest + 1e-9))]
        found = np.array([self.by_length(model, ratio, length) for ratio in RATIOS])
        i, j = np.unravel_index(int(np.argmax(found)), found.shape)
        return Best(float(found[i, j]), RATIOS[i], float(length[j]))

    def interval(self, model: str) -> tuple[float, float, float]:
        """Nominal, low and high end of the 90 % interval of the 12 cm leg's clearance, m."""
        made = groups(self.leg, self.motor(RATIO), GROUND, MODELS[model], TOLERANCES, np.array([LENGTH]))
        found = heights(compiled_jump(self.leg.bending).run(made[0]))
        nominal, low, high = intervals(found[None, :])
        return float(nominal[0]), float(low[0]), float(high[0])


def spreads(given: Configuration, model: str) -> dict[str, tuple[float, float]]:
    """Lowest and highest clearance, m, of the 12 cm leg over each quantity's tolerance; see ``hopper_tolerances``."""
    made = groups(given.leg, given.motor(RATIO), GROUND, MODELS[model], TOLERANCES, np.array([LENGTH]))
    found = heights(compiled_jump(given.leg.bending).run(made[0]))
    return {name: (float(found[0] + min(ends)), float(found[0] + max(ends)))
            for name, ends in contributions(found).items()}  # fmt: skip


@dataclass(frozen=True)
class Best:
    """The best design of a sweep: clearance m, gear ratio, upper link's length m."""

    clearance: float
    ratio: float
    length: float


def deepest() -> float:
    """The deepest crouch of the 12 cm leg before its lower links lock, rad."""
    leg = HopperLeg(length=LENGTH)
    return float(np.arcsin(leg.lower_ratio * sin(LOCKED) - 0.5 * leg.hip_spacing / LENGTH)) - 1e-6


def calibrated(given: Configuration, row: int = CLEARANCE) -> Configuration | None:
    """With the crouch at which D's 12 cm leg clears the published 22 cm (or another height's row); None for none."""

    def at(crouch: float) -> Configuration:
        return replace(given, crouch=crouch)

    high = deepest()
    if at(high).height("D", row=row) < PREDICTED:
        return None
    return at(_crossing(lambda crouch: at(crouch).height("D", row=row) - PREDICTED, radians(20.0), high))


def inertia_for(given: Configuration, target: float = MEASURED) -> float | None:
    """The rotor inertia, kg m^2, with which the full model clears ``target`` m; None where none does."""

    def off(logarithm: float) -> float:
        return target - replace(given, inertia=float(np.exp(logarithm))).height("full")

    low, high = float(np.log(LIGHTEST)), float(np.log(HEAVIEST))
    return None if off(low) > 0.0 or off(high) < 0.0 else float(np.exp(_crossing(off, low, high)))


def _crossing(rising: Callable[[float], float], low: float, high: float) -> float:
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if rising(middle) < 0.0 else (low, middle)
    return 0.5 * (low + high)


def printed_work_share(crouch: float, extended: float) -> float:
    """Of the motors' work, what the printed F = T cos(theta)/l puts on a mass that rises by l sin(theta).

    F dy = T cos^2(theta) dtheta, where a link pushing without loss would do T dtheta. ``crouch``, ``extended`` : rad
    from straight down.
    """
    first, last = 0.5 * np.pi - crouch, 0.5 * np.pi - extended
    whole = last - first
    return float((0.5 * whole + 0.25 * (sin(2 * last) - sin(2 * first))) / whole)


def tireless_point_mass(given: Configuration) -> float:
    """Ballistic height, m, of the printed point mass if the motors' torque did not fall with speed."""
    leg, motor = given.leg, given.motor(RATIO)
    work = 2 * motor.stall_torque * (leg.crouch - leg.extended) * printed_work_share(leg.crouch, leg.extended)
    rise = LENGTH * (cos(leg.extended) - cos(leg.crouch))
    return work / (leg.total_mass(motor) * leg.gravity) - rise


def in_words(given: Configuration) -> str:
    """``5.7 V, crouch 59.1 deg, 2.5e-4 N*m*s/rad a joint``."""
    return f"{given.supply:g} V, crouch {degrees(given.crouch):.1f} deg, {given.damping:.2g} N*m*s/rad a joint"
