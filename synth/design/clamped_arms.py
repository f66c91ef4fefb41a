"""Compliance of a spring's clamped arms before its joint is drawn, estimated from the joint's wall thicknesses.

The drawn joint gives the exact value (``synth.design.drawn_springs``); the estimate is accurate enough for the choice.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import degrees, pi, sqrt, tau
from typing import TYPE_CHECKING

from synth.design.stop_places import DRAWN_STOP
from synth.files.project_options import CadOptions
from synth.parts.rows import TorsionSpringRow

if TYPE_CHECKING:
    from synth.cad import SpringDimensions

# deg, from a motion to the angles between which seats stay apart. 5 to spare: a neighbouring wire, which the last of
# two searches may end at, changes the angle at which seats meet by so much (0.55 and 0.533 mm: 63, 58 deg).
BEYOND = DRAWN_STOP + 5.0
LEAST_COILS = 0.1  # of a spring's coils: the fewest that remain at the largest opening considered


def free_arm(wire: float, mean: float, coils: float, opening: float, cad: CadOptions) -> float:
    """Free length of an arm, m: from where it leaves the coil to its seat outside the wall of the coil's pocket.

    ``opening`` rad: angle by which the joint opens the spring; the coil loses turns and becomes wider. Lengths in m.
    """
    widest = mean * coils / max(coils - opening / tau, LEAST_COILS * coils)
    wall = widest / 2 + wire / 2 + 2 * cad.clearance + cad.wall
    return sqrt(max(wall**2 - max(0.0, mean / 2 - _half_seat(wire)) ** 2, 0.0))


@lru_cache(maxsize=1024)
def _half_seat(wire: float) -> float:
    """Half of the width of an arm's seat, m, which depends on the wire only."""
    from synth.cad import JointDimensions
    from synth.cad.arm_layout import seat_size

    return seat_size(JointDimensions("spring", _any_coil(wire), 0.0, 0.0, range=(-1.0, 1.0))).half_width * 1e-3


def _any_coil(wire: float) -> SpringDimensions:
    """A spring of this wire (m); an arm's seat depends on the wire only."""
    from synth.cad import SpringDimensions
    from synth.cad.dimensions import coil_fraction

    angle = 180.0
    return SpringDimensions(wire * 1e3, 10.0 * wire * 1e3, 3.0 + coil_fraction(angle), angle)


def seat_length(wire: float, torque: float) -> float:
    """Length of an arm's seat, m, that holds ``torque`` N m of its spring of this wire (m)."""
    from synth.cad import JointDimensions, LoadDimensions
    from synth.cad.arm_layout import seat_size

    loads, turned = LoadDimensions(spring_rate=torque), degrees(1.0)  # N m/rad over a radian
    drawn = JointDimensions("spring", _any_coil(wire), 0.0, 0.0, stops=(-turned, turned), loads=loads)
    return seat_size(drawn).length * 1e-3


def seats_would_meet(spring: SpringDimensions, rate: float, travel: tuple[float, float], cad: CadOptions) -> bool:
    """Whether the seats of both arms of a spring would meet in its joint as drawn.

    ``rate`` : N m/rad. ``travel`` : rad by which the joint winds it from its free angle, and by which it opens it.
    """
    from synth.cad import JointDimensions, LoadDimensions
    from synth.cad.seats_apart import seats_would_meet as would_meet

    winding, opening = degrees(travel[0]) + BEYOND, degrees(travel[1]) + BEYOND
    drawn = JointDimensions(
        "spring", spring, 0.0, 0.0, range=(-winding, opening), stops=(-winding, opening),
        clearance=cad.clearance * 1e3, wall=cad.wall * 1e3, loads=LoadDimensions(spring_rate=rate),
    )  # fmt: skip
    sizes = spring.wire_diameter * 1e-3, spring.mean_diameter * 1e-3, spring.drawn_coils
    return would_meet(drawn, free_arm(*sizes, travel[1], cad) * 1e3)


@dataclass(frozen=True)
class JointArms:
    """The free length (m) of a spring's arms in a joint that opens it by ``opening`` rad, by the spring's sizes."""

    opening: float
    cad: CadOptions

    def __call__(self, wire: float, mean: float, coils: float) -> float:
        """As ``free_arm``."""
        return free_arm(wire, mean, coils, self.opening, self.cad)


def softening_by_arms(wire: float, mean: float, coils: float, opening: float, cad: CadOptions) -> float:
    """Rate of the spring with its arms over that of its body alone; arguments as in ``free_arm``."""
    from synth.cad.flexed_wire import effective_length

    arm = free_arm(wire, mean, coils, opening, cad)
    return pi * mean * coils / effective_length(mean / 2, coils, arm)


def rate_in_joint(row: TorsionSpringRow, opening: float, cad: CadOptions) -> float:
    """Rate (N m/rad) of one bought spring with its clamped arms; vendors state that of the body alone.

    ``opening`` as in ``free_arm``. Of a spring whose sizes are not all known it is the rate as sold.
    """
    assert row.rate is not None
    if not (row.wire_diameter and row.mean_diameter and row.body_coils):
        return row.rate
    return row.rate * softening_by_arms(row.wire_diameter, row.mean_diameter, row.body_coils, opening, cad)


def leg_that_bends_as_much(wire: float, mean: float, coils: float, opening: float, cad: CadOptions) -> float:
    """Length (m) of two straight, end-loaded legs that have the same compliance as the clamped arms.

    Each leg of length l adds l/(3 pi D) active coils (Shigley eq. 10-48). Arguments as in ``free_arm``.
    """
    body = pi * mean * coils
    # Two legs of length l: 2 l / (3 pi D) of the body's coils, solved for l.
    return max(0.0, 1.5 * body * (1.0 / softening_by_arms(wire, mean, coils, opening, cad) - 1.0))
