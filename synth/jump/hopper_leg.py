"""The five-bar jumping leg, its motor, ground and tolerances as plain values in SI.

Angles of links are measured from straight down, outward positive: the upper link stands at ``a``, the lower one at
``-b`` (pointing inward). Left and right are mirror images. With hips ``spacing`` apart the feet of both sides meet in
one point under the body's middle, which is the closure ``spacing/2 + upper sin a = lower sin b``.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from math import asin, cos, pi, sin
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.drives.motor import GearedMotor

Bending = Literal["none", "upper", "all"]

# Pseudo-rigid-body constants of a cantilever with an end force: Howell, Compliant Mechanisms, 2001, table 5.1; the lab
# uses the same (idealabasu/curating-legs, leg/model.py).
PRB_GAMMA, PRB_STIFFNESS = 0.85, 2.65
LOCKED = 80.0 * pi / 180.0  # lower links flatter than this in the crouch lock


@dataclass(frozen=True)
class Laminate:
    """Materials of links and flexures.

    ``mass_per_length`` kg/m and ``bending_stiffness`` E I (N m^2) of a link, measured or from a flat
    strip (``strip_mass_per_length``, ``strip_bending_stiffness``); both apply to any length.
    """

    mass_per_length: float = 0.025
    bending_stiffness: float = 14.0224 * 0.12 / (PRB_GAMMA * PRB_STIFFNESS)
    width: float = 0.015
    thickness: float = 0.0017
    modulus: float = 10.3e9
    density: float = 1820.0
    flexure_thickness: float = 0.0001
    flexure_modulus: float = 3.8e9  # polyester film

    @property
    def strip_mass_per_length(self) -> float:
        """Density times cross-section, kg/m."""
        return self.density * self.width * self.thickness

    @property
    def strip_bending_stiffness(self) -> float:
        """E w t^3 / 12, N m^2, of a flat strip of this laminate."""
        return self.modulus * self.width * self.thickness**3 / 12.0

    def beam_rate(self, length: float) -> float:
        """Torsion spring equivalent to a link's bending: gamma K_theta E I / l, N m/rad (Howell 2001, eq. 5.49)."""
        return PRB_GAMMA * PRB_STIFFNESS * self.bending_stiffness / length

    def hinge_gap(self, rate: float) -> float:
        """Free length of film for a joint's rate: E w t^3 / (12 k), m (small-length flexure, ibid. 5.2)."""
        return self.flexure_modulus * self.width * self.flexure_thickness**3 / (12.0 * rate)


@dataclass(frozen=True)
class Flexures:
    """The five flexure joints: rate N m/rad, damping N m s/rad, and rest angles (rad).

    ``hip_rest``: upper link's angle; ``knee_rest``: fold between upper and lower link, a + b; ``foot_rest``: angle
    between the two lower links, 2 b. In the lab's simulation the hips rest with the links level, the knees straight and
    the foot laid flat.
    """

    rate: float = 0.0229183
    damping: float = 0.00025
    hip_rest: float = pi / 2
    knee_rest: float = 0.0
    foot_rest: float = pi


@dataclass(frozen=True)
class Contact:
    """The ground under the foot: the parameters of both laws, see ``models``."""

    stiffness: float = 1e4  # N/m
    damping: float = 10.0  # N s/m, of the linear law
    dissipation: float = 5.0  # s/m, of Hunt and Crossley's
    friction: float = 0.7
    slip_speed: float = 0.01  # m/s, over which Coulomb's law is smoothed


@dataclass(frozen=True, kw_only=True)
class Motor(GearedMotor):
    """A gear motor at its supply voltage, as in a catalogue: the maker's line at the output, ``mass`` kg.

    ``torque_constant`` gives the maker's stall torque through a lossless gear, ``back_emf_constant`` the maker's free
    speed: their ratio is the gear's efficiency at stall. ``friction`` N m of the rotor, constant in speed; ``viscous``
    N m s/rad of the rotor. ``rated_voltage`` V, of the maker's statement; None: ``voltage``.
    """

    name: str
    voltage: float
    stall_torque: float
    no_load_speed: float
    stall_current: float
    no_load_current: float
    mass: float
    friction: float
    viscous: float
    back_emf_constant: float
    torque_limit: float | None = None
    rated_voltage: float | None = None


@dataclass(frozen=True)
class MotorOptions:
    """Properties of all motors in a project; None: from the catalogue row, else estimated.

    ``supply`` V; ``friction_share`` of the no-load torque that is constant in speed, the rest being viscous.
    """

    supply: float | None = None
    rotor_inertia: float | None = None
    inductance: float | None = None
    resistance: float | None = None
    friction_share: float = 1.0


@dataclass(frozen=True)
class HopperLeg:
    """The leg without its motors. ``length``: of an upper link; a lower one is ``lower_ratio`` times that."""

    length: float = 0.12
    lower_ratio: float = 1.0
    hip_spacing: float = 0.03
    structure_mass: float = 0.0179  # body without the two motors
    foot_mass: float = 0.0
    body_inertia: float = 5e-6  # about its centre, for the planar form
    bending: Bending = "upper"
    laminate: Laminate = field(default_factory=Laminate)
    flexures: Flexures = field(default_factory=Flexures)
    crouch: float = pi / 2 - 0.89  # of the upper link
    crouch_lower: float | None = None  # of the lower link, instead: legs of all lengths then fold equally
    extended: float = 10.0 * pi / 180.0
    stop_rate: float = 20.0  # N m/rad
    stop_dissipation: float = 0.5  # s/rad
    gravity: float = 9.81

    @property
    def lower_length(self) -> float:
        """Length of a lower link, m."""
        return self.length * self.lower_ratio

    @property
    def link_mass(self) -> tuple[float, float]:
        """Upper and lower link's mass, kg."""
        density = self.laminate.mass_per_length
        return density * self.length, density * self.lower_length

    def total_mass(self, motor: Motor) -> float:
        """Body, two motors, four links and the foot, kg."""
        return self.structure_mass + 2 * motor.mass + 2 * sum(self.link_mass) + self.foot_mass

    def with_length(self, length: float) -> HopperLeg:
        """The same leg with upper links of this length (m); lower ones keep their ratio."""
        return replace(self, length=length)

    def crouch_angle(self, length: Array) -> Array:
        """Upper link's angle in the crouch (rad) for these lengths (m); nan if the lower link's is impossible."""
        if self.crouch_lower is None:
            return np.full_like(length, self.crouch)
        share = self.lower_ratio * np.sin(self.crouch_lower) - 0.5 * self.hip_spacing / length
        return np.asarray(np.arcsin(np.where(np.abs(share) < 1.0, share, np.nan)))

    @property
    def start(self) -> float:
        """Upper link's angle in the crouch at this length, rad."""
        return float(self.crouch_angle(np.array([self.length]))[0])

    def lower_angle(self, upper: float) -> float:
        """Lower link's angle b (rad) at an upper link's angle a by the closure.

        Raises
        ------
        ValueError : the lower links cannot reach.
        """
        share = (0.5 * self.hip_spacing + self.length * sin(upper)) / self.lower_length
        if abs(share) >= 1.0:
            raise ValueError(f"with the upper link at {upper * 180 / pi:.1f} deg the lower links cannot reach the foot")
        return asin(share)

    @property
    def largest_crouch(self) -> float:
        """Largest upper angle at which the lower links reach (they are then level, and lock), rad; at most 90 deg."""
        share = (self.lower_length - 0.5 * self.hip_spacing) / self.length
        return asin(share) if share < 1.0 else pi / 2

    def height(self, upper: float) -> float:
        """Hips above the foot with rigid links, m."""
        return self.length * cos(upper) + self.lower_length * cos(self.lower_angle(upper))

    def centre_height(self, motor: Motor, upper: float) -> float:
        """Centre of mass above the foot with rigid links, m; body and motors are at the hips.

        Raises
        ------
        ValueError : the lower links cannot reach.
        """
        hips, knees = self.height(upper), self.lower_length * cos(self.lower_angle(upper))
        above, below = self.link_mass
        body = self.structure_mass + 2 * motor.mass
        return (body * hips + above * (hips + knees) + below * knees) / self.total_mass(motor)

    def leverage(self, upper: float) -> float:
        """Rise of the hips per radian of both upper links, m/rad: l (sin a + cos a tan b)."""
        b = self.lower_angle(upper)
        return self.length * (sin(upper) + cos(upper) * sin(b) / cos(b))

    def problems(self) -> list[str]:
        """Reasons why it cannot jump: impossible geometry, a crouch out of reach, links that cross or lock."""
        degrees = 180.0 / pi
        if min(self.length, self.lower_length) <= 0.0:
            return ["a link has no length"]
        found = []
        if self.hip_spacing < 0.0:
            found.append("the hips are a negative distance apart")
        if self.lower_length <= 0.5 * self.hip_spacing:
            return [*found, "the lower links are too short to meet under hips so far apart"]
        start = self.start
        if not start < self.largest_crouch:
            text = f"the crouch of {start * degrees:.1f} deg cannot be reached: the lower links are level,"
            found.append(f"{text} and lock, at {self.largest_crouch * degrees:.1f} deg")
        elif self.lower_angle(start) > LOCKED:
            angle = self.lower_angle(start) * degrees
            found.append(
                f"in the crouch the lower links lie {angle:.1f} deg from straight down: above 80 deg they lock"
            )
        if self.extended >= start:
            found.append("the leg is extended before it starts: extended must be less than crouch")
        knee = 0.5 * self.hip_spacing + self.length * sin(self.extended)
        if knee <= 0.0:
            text = f"extended to {self.extended * degrees:.1f} deg the upper links cross: their knees meet at"
            found.append(f"{text} {asin(max(-1.0, -0.5 * self.hip_spacing / self.length)) * degrees:.1f} deg")
        return found


def lower_angles(leg: HopperLeg, length: Array) -> Array:
    """(n,) rad, the lower links' angles in the crouch of legs of these lengths (m); nan where they cannot reach."""
    share = (0.5 * leg.hip_spacing + length * np.sin(leg.crouch_angle(length))) / (length * leg.lower_ratio)
    return np.asarray(np.arcsin(np.where(np.abs(share) < 1.0, share, np.nan)))


def in_reach(leg: HopperLeg, length: Array, most: float = LOCKED) -> NDArray[np.bool_]:
    """Lengths whose lower links reach the foot in the crouch, and stand below ``most`` rad there."""
    return np.asarray((lower_angles(leg, length) < most) & (leg.crouch_angle(length) > leg.extended))


def segments(leg: HopperLeg) -> tuple[list[float], list[float], int]:
    """Lengths and masses of one side's rigid pieces from hip to foot, and the index of the first lower piece."""
    upper, lower = leg.link_mass
    halves = {"none": (1, 1), "upper": (2, 1), "all": (2, 2)}[leg.bending]
    lengths = [leg.length / halves[0]] * halves[0] + [leg.lower_length / halves[1]] * halves[1]
    masses = [upper / halves[0]] * halves[0] + [lower / halves[1]] * halves[1]
    return lengths, masses, halves[0]


@dataclass(frozen=True)
class HopperTolerances:
    """90 % half widths as shares of the value, ``crouch`` in rad; ``current`` is that without load."""

    speed: float = 0.2
    current: float = 0.5
    torque: float = 0.1
    rotor_inertia: float = 0.5
    mass: float = 0.05
    joint_damping: float = 0.5
    crouch: float = 0.035
