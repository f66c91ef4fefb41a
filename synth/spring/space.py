"""The space that a torsion spring takes: as it winds, its diameter decreases and its length increases.

Lengths in m, ``travel`` in rad, positive in the direction that winds the coil (the intended direction of loading).
The whole travel is taken for the body's. Of it the arms bend the share ``1 - Nb/Na`` (``arms.arm_share``), so a real
body changes less, and clearances to an arbor, a tube and cheeks err on the safe side: for 4.17 coils of 23.67 mm with
4.60 active ones, wound by 14.5 deg, the inside is 18.69 mm here, 18.72 mm by the body's own turns.
"""

from __future__ import annotations

import math


def wound_mean_diameter(mean_diameter: float, body_coils: float, travel: float) -> float:
    """``D' = Nb D / (Nb + turns)``: the wire's length is constant (Shigley eq. 10-53, of the body's turns)."""
    return mean_diameter * body_coils / (body_coils + travel / math.tau)


def wound_inside_diameter(wire_diameter: float, mean_diameter: float, body_coils: float, travel: float) -> float:
    """Inside diameter at ``travel``, ``D' - d``."""
    return wound_mean_diameter(mean_diameter, body_coils, travel) - wire_diameter


def travel_to_inside_diameter(
    wire_diameter: float, mean_diameter: float, body_coils: float, inside_diameter: float
) -> float:
    """Travel at which the inside diameter is ``inside_diameter``; negative if that of the free coil is smaller."""
    return math.tau * body_coils * (mean_diameter / (inside_diameter + wire_diameter) - 1.0)


def body_length(wire_diameter: float, body_coils: float, travel: float = 0.0, pitch: float = 1.0) -> float:
    """Length of the coil body, ``d + p (Nb + turns)``: each turn of the travel adds one.

    ``pitch`` is the axial advance per coil over the wire diameter, 1 for touching coils. A joint that holds both arms
    keeps it; a coil whose arms are free first closes its gaps.
    """
    return wire_diameter * (1.0 + pitch * (body_coils + travel / math.tau))


def travel_to_body_length(wire_diameter: float, body_coils: float, length: float, pitch: float = 1.0) -> float:
    """Travel at which a body has the length ``length``; ``pitch`` as in ``body_length``."""
    return math.tau * ((length / wire_diameter - 1.0) / pitch - body_coils)


def wire_length(
    wire_diameter: float,
    mean_diameter: float,
    body_coils: float,
    leg_lengths: tuple[float, float] = (0.0, 0.0),
    gap: float = 0.0,
) -> float:
    """Length of the wire in the helix and the two straight legs, m."""
    pitch = wire_diameter + gap
    return body_coils * math.hypot(math.pi * mean_diameter, pitch) + sum(leg_lengths)


def wire_mass(density: float, wire_diameter: float, length: float) -> float:
    """Mass of round wire, kg; ``density`` in kg/m^3."""
    return density * math.pi * wire_diameter**2 / 4.0 * length


def cylinder(diameter: float, length: float) -> float:
    """Volume of a cylinder, m^3."""
    return math.pi / 4.0 * diameter**2 * length
