"""The configuration of the jumping leg that reproduces the published height, and the quantities that follow from it.

Published: C. Knaup & D. Aukes on a laminate five-bar leg (numbers from its text; its curves have no values). The
numbers of leg and motor are those of the laboratory's own simulation (idealabasu/code_pynamics,
parallel_five_bar_jumper_compliance.py at 6a9e0be, 2019). Neither source gives the crouch. It is calibrated to the
22 cm that model D predicts for the built leg; nothing else is.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import cos, degrees, radians, sin

import numpy as np

from synth.arrays import Array
from synth.hopper.hopper_tolerances import contributions, half_width, intervals, outcomes_of_copies
from synth.jump.hopper_leg import LOCKED, Contact, Flexures, HopperLeg, HopperTolerances, Motor, in_reach
from synth.jump.jump_models import MODELS, lanes
from synth.jump.jump_runs import compiled_jump
from synth.jump.outcomes import CLEARANCE, heights, known_heights
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
LENGTHS = np.round(np.arange(0.06, 0.2001, 0.01), 3)  # m, about the published 8 to 14 cm
SUITABLE = 0.14  # m, the longest leg that the study mentions
BISECTIONS = 24  # of an angle or a logarithm: to a ten-millionth of the range
LIGHTEST, HEAVIEST = 1e-10, 4e-8  # kg m^2, search range of the rotor inertia
SHALLOWEST, LEAST_STROKE = radians(20.0), radians(3.0)  # crouch and stroke from which the search for a crouch starts
ROTOR_DENSITY, ROTOR_LENGTH = 8000.0, 0.008  # kg/m^3 of iron and copper; m, half of the motor's can of 15 mm
# N m of one gear at any instant: these gears' ``torque_limit`` in gearmotors.csv, the maker's 2.0 kgf cm. A motor that
# stalls at 7.4 V gives 2.9 times that through a lossless gear, so the study's legs exceed it; blows go far beyond.
GEAR_LIMIT, MOST_OVER = 0.196, 3.0
TOLERANCES = HopperTolerances(speed=half_width(0.2), current=half_width(0.5))  # the maker's limits of such motors
# What the built leg and its motor give when measured: a run-up of the motor (``hopper-motor``: constants within 2 %,
# rotor inertia within 5 %), a pull-up (joint damping within 10 %), scales (1 %), an angle read to 1 deg.
MEASURED_TOLERANCES = HopperTolerances(
    speed=0.02, current=0.05, torque=0.02, rotor_inertia=0.05, mass=0.01, joint_damping=0.1, crouch=radians(1.0)
)
HALF_WIDTH = 0.1  # of the height: a prediction with a wider 90 % interval tests nothing


@dataclass(frozen=True)
class Configuration:
    """Supply voltage and leg.

    ``supply`` : V. ``damping`` : N m s/rad per joint. ``crouch`` and ``extended`` : rad, the upper link from straight
    down at the start and at the stop. ``inertia`` : of the rotor, kg m^2.
    """

    supply: float = SUPPLY
    damping: float = Flexures.damping
    crouch: float = HopperLeg.crouch
    inertia: float = ROTOR_INERTIA
    extended: float = HopperLeg.extended

    @property
    def leg(self) -> HopperLeg:
        """The leg with upper links of 12 cm; a sweep replaces the length."""
        flexures = Flexures(damping=self.damping)
        return HopperLeg(length=LENGTH, crouch=self.crouch, extended=self.extended, flexures=flexures)

    def motor(self, ratio: float) -> Motor:
        """The laboratory's motor with a lossless gear of this ratio, as in its simulation."""
        stall = self.supply / RESISTANCE
        return Motor(
            name=f"{ratio:.0f}:1",
            gear_ratio=ratio,
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
            back_emf_constant=TORQUE_CONSTANT,
            torque_constant=TORQUE_CONSTANT,
            resistance=RESISTANCE,
        )

    def height(self, model: str, *, ratio: float = RATIO, row: int = CLEARANCE) -> float:
        """Clearance, or the height in outcome ``row``, of the 12 cm leg, m; 0 if it does not jump."""
        return float(self.by_length(model, ratio, np.array([LENGTH]), row)[0])

    def by_length(self, model: str, ratio: float, length: Array, row: int = CLEARANCE) -> Array:
        """Heights (n,) m for upper links of lengths (n,) m; 0 if the leg cannot reach the crouch."""
        found, leg = np.zeros(len(length)), self.leg
        if model == "point_mass":
            return heights(point_mass_outcomes(leg, self.motor(ratio), length), row)
        reach = in_reach(leg, length)
        if reach.any():
            made = lanes(leg, self.motor(ratio), GROUND, MODELS[model], length[reach])
            found[reach] = heights(compiled_jump(leg.bending).run(made), row)
        return found

    def best(self, model: str, longest: float = float(LENGTHS[-1])) -> BestDesign:
        """The design with the highest clearance among the maker's gears and legs of up to ``longest`` m."""
        length = LENGTHS[: int(np.searchsorted(LENGTHS, longest + 1e-9))]
        found = np.array([self.by_length(model, ratio, length) for ratio in RATIOS])
        i, j = np.unravel_index(int(np.argmax(found)), found.shape)
        return BestDesign(float(found[i, j]), RATIOS[i], float(length[j]))

    def interval(self, model: str, tolerances: HopperTolerances = TOLERANCES) -> tuple[float, float, float]:
        """Nominal value and both ends of the 90 % interval of the 12 cm leg's clearance, m."""
        made = outcomes_of_copies(self.leg, self.motor(RATIO), GROUND, MODELS[model], tolerances, np.array([LENGTH]))
        found = known_heights(next(made))
        nominal, low, high = intervals(found[None, :])
        return float(nominal[0]), float(low[0]), float(high[0])


def height_spreads(given: Configuration, model: str) -> dict[str, tuple[float, float]]:
    """Quantity -> lowest and highest clearance, m, of the 12 cm leg over the tolerance of that quantity alone."""
    made = outcomes_of_copies(given.leg, given.motor(RATIO), GROUND, MODELS[model], TOLERANCES, np.array([LENGTH]))
    found = known_heights(next(made))
    return {name: (float(found[0] + min(ends)), float(found[0] + max(ends)))
            for name, ends in contributions(found).items()}  # fmt: skip


@dataclass(frozen=True)
class BestDesign:
    """The best design of a sweep: clearance m, gear ratio, length of the upper link m."""

    clearance: float
    ratio: float
    length: float


def deepest_crouch() -> float:
    """The deepest crouch of the 12 cm leg at which its lower links do not lock, rad."""
    leg = HopperLeg(length=LENGTH)
    return float(np.arcsin(leg.lower_ratio * sin(LOCKED) - 0.5 * leg.hip_spacing / LENGTH)) - 1e-6


def calibrate_crouch(given: Configuration, row: int = CLEARANCE) -> Configuration | None:
    """The configuration with the crouch at which the 12 cm leg of model D reaches the published 22 cm.

    ``row`` : the height that is compared. None: the deepest crouch does not reach it.
    """

    def at(crouch: float) -> Configuration:
        return replace(given, crouch=crouch)

    low, high = max(SHALLOWEST, given.extended + LEAST_STROKE), deepest_crouch()
    if at(high).height("D", row=row) < PREDICTED:
        return None
    return at(_rising_root(lambda crouch: at(crouch).height("D", row=row) - PREDICTED, low, high))


def inertia_for(given: Configuration, target: float = MEASURED) -> float | None:
    """The rotor inertia, kg m^2, with which the full model clears ``target`` m; None if there is none in range."""

    def excess(logarithm: float) -> float:
        return target - replace(given, inertia=float(np.exp(logarithm))).height("full")

    low, high = float(np.log(LIGHTEST)), float(np.log(HEAVIEST))
    return None if excess(low) > 0.0 or excess(high) < 0.0 else float(np.exp(_rising_root(excess, low, high)))


def rotor_diameter(inertia: float) -> float:
    """Diameter (m) of a solid rotor of iron and copper with this inertia (kg m^2): J = pi rho L d^4 / 32."""
    return float((32.0 * inertia / (np.pi * ROTOR_DENSITY * ROTOR_LENGTH)) ** 0.25)


def is_the_studys(best: BestDesign) -> bool:
    """Whether a best design is 210:1 with 12 to 14 cm, the published one, or a neighbour: 180 to 240:1, 11 to 15 cm."""
    return 180.0 <= best.ratio <= 240.0 and 0.11 <= best.length <= 0.15


def _rising_root(rising: Callable[[float], float], low: float, high: float) -> float:
    """The root of a rising function, by bisection."""
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if rising(middle) < 0.0 else (low, middle)
    return 0.5 * (low + high)


def printed_work_share(crouch: float, extended: float) -> float:
    """Share of the motors' work that the printed force F = T cos(theta)/l does on a mass that rises by l sin(theta).

    F dy = T cos^2(theta) dtheta, but a lossless link does the work T dtheta. ``crouch``, ``extended`` : rad from
    straight down.
    """
    first, last = 0.5 * np.pi - crouch, 0.5 * np.pi - extended
    whole = last - first
    return float((0.5 * whole + 0.25 * (sin(2 * last) - sin(2 * first))) / whole)


def constant_torque_point_mass(given: Configuration) -> float:
    """Ballistic height, m, of the printed point mass with the stall torque at all speeds."""
    leg, motor = given.leg, given.motor(RATIO)
    work = 2 * motor.stall_torque * (leg.crouch - leg.extended) * printed_work_share(leg.crouch, leg.extended)
    rise = LENGTH * (cos(leg.extended) - cos(leg.crouch))
    return work / (leg.total_mass(motor) * leg.gravity) - rise


def description(given: Configuration) -> str:
    """Text such as ``5.7 V, crouch 59.1 deg, 2.5e-4 N*m*s/rad per joint``."""
    return f"{given.supply:g} V, crouch {degrees(given.crouch):.1f} deg, {given.damping:.2g} N*m*s/rad per joint"
