"""What a spring's clamped arms give way, before its joint is drawn: an estimate from the joint's walls.

The drawn joint settles it (``synth.design.drawn_springs``); this is near enough to choose by.
"""

from __future__ import annotations

from math import pi, sqrt, tau

from synth.files.project_options import CadOptions

FEWEST = 0.1  # of a spring's coils, that are left when it is opened as far as is reckoned with


def free_arm(wire: float, mean: float, coils: float, opening: float, cad: CadOptions) -> float:
    """Free length of an arm, m: from where it leaves the coil to its seat outside the wall of the coil's pocket.

    ``opening`` rad: that the joint opens the spring, which widens its coil by so much as it loses turns.
    """
    from synth.cad import JointDimensions, SpringDimensions
    from synth.cad.arm_layout import seat_size
    from synth.cad.dimensions import coil_fraction

    angle = 180.0
    spring = SpringDimensions(wire * 1e3, mean * 1e3, round(coils) + coil_fraction(angle), angle)
    seat = seat_size(JointDimensions("spring", spring, 0.0, 0.0, range=(-1.0, 1.0)))
    widest = mean * coils / max(coils - opening / tau, FEWEST * coils)
    wall = widest / 2 + wire / 2 + 2 * cad.clearance + cad.wall
    return sqrt(max(wall**2 - max(0.0, mean / 2 - seat.half_width * 1e-3) ** 2, 0.0))


def softening(wire: float, mean: float, coils: float, opening: float, cad: CadOptions) -> float:
    """Rate of the spring with its arms over that of its body alone."""
    from synth.cad.flexed_wire import effective_length

    arm = free_arm(wire, mean, coils, opening, cad)
    return pi * mean * coils / effective_length(mean / 2, coils, arm)


def leg_that_bends_as_much(wire: float, mean: float, coils: float, opening: float, cad: CadOptions) -> float:
    """Length (m) of a straight leg with a force at its end, two of which soften the body as the clamped arms do.

    Two such legs l add l/(3 pi D) coils each (Shigley eq. 10-48).
    """
    body = pi * mean * coils
    return max(0.0, 1.5 * body * (1.0 / softening(wire, mean, coils, opening, cad) - 1.0))
