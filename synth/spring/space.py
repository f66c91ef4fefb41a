"""The space that a torsion spring takes: as it winds, its diameter decreases and its length increases.

Lengths in m, ``travel`` in rad, positive in the direction that winds the coil (the intended direction of loading).
"""

from __future__ import annotations

import math


def wound_mean_diameter(mean_diameter: float, body_coils: float, travel: float) -> float:
    """``D' = Nb D / (Nb + turns)``: the wire's length is constant (Shigley eq. 10-53)."""
    return mean_diameter * body_coils / (body_coils + travel / math.tau)


def wound_inside_diameter(wire_diameter: float, mean_diameter: float, body_coils: float, travel: float) -> float:
    """Inside diameter at ``travel``, ``D' - d``."""
    return wound_mean_diameter(mean_diameter, body_coils, travel) - wire_diameter


def arbor_clearance(
    wire_diameter: float, mean_diameter: float, body_coils: float, travel: float, arbor_diameter: float
) -> float:
    """Diametral clearance to the arbor, ``D' - d - D_arbor`` (Shigley eq. 10-54); at 0 or below the coil grips it."""
    return wound_inside_diameter(wire_diameter, mean_diameter, body_coils, travel) - arbor_diameter


def travel_to_inside_diameter(
    wire_diameter: float, mean_diameter: float, body_coils: float, inside_diameter: float
) -> float:
    """Travel at which the inside diameter is ``inside_diameter``; negative if that of the free coil is smaller."""
    return math.tau * body_coils * (mean_diameter / (inside_diameter + wire_diameter) - 1.0)


def body_length(wire_diameter: float, body_coils: float, gap: float = 0.0, travel: float = 0.0) -> float:
    """Length of the coil body: ``max(d (Nb + 1) + gap Nb, d (Nb + 1 + turns))``.

    Winding adds turns. A close-wound body grows by one wire diameter per turn; spaced coils first close their gaps (as
    in the handbook program ODOP and EN 13906-3).
    """
    free = wire_diameter * (body_coils + 1.0) + gap * body_coils
    return max(free, wire_diameter * (body_coils + 1.0 + travel / math.tau))


def travel_to_body_length(wire_diameter: float, body_coils: float, length: float) -> float:
    """Travel at which a close-wound body has the length ``length``."""
    return math.tau * (length / wire_diameter - body_coils - 1.0)


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
