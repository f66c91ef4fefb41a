"""The room that a torsion spring takes: it closes on its arbor and grows in length as it winds.

Lengths in m, ``travel`` in rad, positive in the sense that winds the coil (the only sense to use it in).
"""

from __future__ import annotations

import math


def wound_mean_diameter(mean_diameter: float, body_coils: float, travel: float) -> float:
    """``D' = Nb D / (Nb + turns)``: the wire's length stays (Shigley eq. 10-53)."""
    return mean_diameter * body_coils / (body_coils + travel / math.tau)


def wound_inside_diameter(wire_diameter: float, mean_diameter: float, body_coils: float, travel: float) -> float:
    """``D' - d``."""
    return wound_mean_diameter(mean_diameter, body_coils, travel) - wire_diameter


def arbor_clearance(
    wire_diameter: float, mean_diameter: float, body_coils: float, travel: float, arbor_diameter: float
) -> float:
    """``D' - d - D_arbor``, on the diameter (Shigley eq. 10-54). Not above 0: the coil grips."""
    return wound_inside_diameter(wire_diameter, mean_diameter, body_coils, travel) - arbor_diameter


def travel_to_inside_diameter(
    wire_diameter: float, mean_diameter: float, body_coils: float, inside_diameter: float
) -> float:
    """Travel at which the inside has closed to ``inside_diameter``; negative where the free coil is smaller already."""
    return math.tau * body_coils * (mean_diameter / (inside_diameter + wire_diameter) - 1.0)


def body_length(wire_diameter: float, body_coils: float, gap: float = 0.0, travel: float = 0.0) -> float:
    """Length of the coil body: ``max(d (Nb + 1) + gap Nb, d (Nb + 1 + turns))``.

    Winding adds turns; touching coils grow by a wire diameter a turn, spaced ones use up their gaps first (as the
    handbook program ODOP and EN 13906-3 have it).
    """
    free = wire_diameter * (body_coils + 1.0) + gap * body_coils
    return max(free, wire_diameter * (body_coils + 1.0 + travel / math.tau))


def travel_to_body_length(wire_diameter: float, body_coils: float, length: float) -> float:
    """Travel at which touching coils have grown to ``length``."""
    return math.tau * (length / wire_diameter - body_coils - 1.0)


def wire_length(
    wire_diameter: float,
    mean_diameter: float,
    body_coils: float,
    leg_lengths: tuple[float, float] = (0.0, 0.0),
    gap: float = 0.0,
) -> float:
    """Wire in the coil's helix and the two straight legs."""
    pitch = wire_diameter + gap
    return body_coils * math.hypot(math.pi * mean_diameter, pitch) + sum(leg_lengths)


def wire_mass(density: float, wire_diameter: float, length: float) -> float:
    """Kg of round wire."""
    return density * math.pi * wire_diameter**2 / 4.0 * length
