"""The arms of a torsion spring: their bending stress, and their contribution to the spring's angle.

Symbols as in EN 13906-3: D mean diameter, d wire diameter, R distance of the load from the axis. r is the inside radius
of the bend where a radial or axial arm leaves the coil; tangent arms have no bend.
"""

from __future__ import annotations

import math

from synth.parts.coil_angle import Convention


def bend_factor(bend_radius: float, wire_diameter: float) -> float:
    """Stress concentration factor at the inside of the bend, ``(2 r/d + 1.07) / (2 r/d + 0.25)`` (EN 13906-3)."""
    ratio = 2.0 * bend_radius / wire_diameter
    return (ratio + 1.07) / (ratio + 0.25)


def arm_stress(
    moment: float, wire_diameter: float, convention: Convention, bend_radius: float, lever: float = 0.0
) -> float:
    """Bending stress where an arm meets the coil, Pa: ``q 32 M / (pi d^3)``, q = 1 for tangent arms.

    ``moment`` in N m: at that point it is the spring's whole moment for any length of the arm. Lengths in m.
    ``lever`` : length of an axial arm over the coil's mean radius; its force, M over that radius, bends the wire there
    by ``lever`` times M about a radial line too, at right angles to M.
    """
    factor = 1.0 if convention == "tangent" else bend_factor(bend_radius, wire_diameter)
    return factor * 32.0 * moment * math.hypot(1.0, lever) / (math.pi * wire_diameter**3)


def lever_of(convention: Convention, leg_lengths: tuple[float, float], mean_diameter: float) -> float:
    """The longer axial arm over the coil's mean radius; 0 for arms in the coil's plane. Lengths in m."""
    return 2.0 * max(leg_lengths) / mean_diameter if convention == "axial" else 0.0


def arm_force(moment: float, length: float) -> float | None:
    """Force at the end of an arm of ``length`` m under ``moment`` N m, N; None for a length of 0."""
    return moment / length if length > 0.0 else None


def arm_share(body_coils: float, active_coils: float) -> float:
    """Fraction of the spring's angle that comes from bending of the arms."""
    return 1.0 - body_coils / active_coils
