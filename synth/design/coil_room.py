"""The room inside a coil in a joint, which clamps both arms: bent by them the coil is neither round nor on the axis.

A centred coil of 3.17 turns of 20 mm, closed by 90 deg, is 16.5 mm wide inside; as the joint holds it, 14.9 mm.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from math import degrees

import numpy as np

from synth.design.clamped_arms import free_arm
from synth.design.stop_places import DRAWN_STOP
from synth.files.project_options import CadOptions
from synth.spring.space import wound_inside_diameter
from synth.spring.spring_requirements import SpringRequirements
from synth.spring.spring_result import SpringDesign

ESTIMATED = 0.05e-3  # m, of the inside: the arms' free length is estimated to 0.3 mm before the joint is drawn


def arbor_of(cad: CadOptions) -> float:
    """Diameter (m) inside the coil that the shaft takes with its clearance."""
    return cad.shaft_diameter + 2.0 * cad.clearance


def fits_round_shaft(wire: float, mean: float, coils: float, travel: float, opening: float, cad: CadOptions) -> bool:
    """Whether the bent coil is clear of the shaft between the farthest stops that may be drawn.

    Lengths in m. ``travel``, ``opening`` : rad from the free angle by which the motion winds it and opens it.
    """
    return inside_in_joint(wire, mean, coils, travel, opening, cad) >= arbor_of(cad) + ESTIMATED


def inside_in_joint(wire: float, mean: float, coils: float, travel: float, opening: float, cad: CadOptions) -> float:
    """Diameter (m) of the largest shaft on the axis that the bent coil leaves free; 0 if it cannot be bent so far.

    Arguments as in ``fits_round_shaft``.
    """
    closed, opened = degrees(travel) + DRAWN_STOP, degrees(opening) + DRAWN_STOP
    arm = free_arm(wire, mean, coils, opening, cad)
    least = min(_inner_radius(mean * 1e3 / 2, coils, arm * 1e3, angle) for angle in (closed, -opened))
    return max(0.0, 2 * least * 1e-3 - wire)


@lru_cache(maxsize=4096)
def _inner_radius(radius: float, coils: float, arm: float, closing: float) -> float:
    """Least distance (mm) of the bent coil's centre line from the axis; 0 if there is no shape."""
    from synth.cad.flexed_wire import flex_wire

    bent = flex_wire(radius, coils, arm, closing)
    return 0.0 if bent is None else float(np.hypot(*bent.points[bent.first : bent.last + 1].T).min())


def with_room(
    wish: SpringRequirements, found: SpringDesign, travel: tuple[float, float], cad: CadOptions
) -> SpringRequirements:
    """The requirements with so much more room on the arbor as the found spring's bent coil takes.

    ``travel`` : rad by which the motion winds and opens it.
    """
    sizes = found.wire_diameter, found.mean_diameter, found.body_coils
    lost = wound_inside_diameter(*sizes, wish.travel) - inside_in_joint(*sizes, *travel, cad) + ESTIMATED
    gap = 1.0 - arbor_of(cad) / (arbor_of(cad) + max(lost, 0.0))
    return replace(wish, limits=replace(wish.limits, arbor_gap=max(wish.limits.arbor_gap, gap)))
