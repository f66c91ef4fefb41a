"""What a spring's sizes tell without its load: room and mass, and which springs break a limit for certain.

A search looks at hundreds of candidates, of which few are worth the load's time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from synth.parts.coil_rate import active_coils, coil_product, mean_diameter_for, rate
from synth.parts.wire import WireMaterial
from synth.spring import space, stress
from synth.spring.loose_test import arms_to_ends
from synth.spring.spring_task import SpringTask
from synth.spring.wire_load import LEAST_RATIO

ROUNDED = 1e-6  # relative: far above the rounding of a rate, and above ``SLACK``
SLACK = 1e-9  # relative: a limit that is reached exactly counts as kept despite rounding
MOST_UNWOUND = 0.9 * math.tau  # rad per coil: the formula of the opened coil diverges when none is left


@dataclass(frozen=True)
class Room:
    """Wire length (m), mass (kg), outer diameter at the widest and body length at the longest (m) of a spring."""

    wire_length: float
    mass: float
    widest_outer_diameter: float
    wound_body_length: float


def surely_broken(material: WireMaterial, sizes: tuple[float, float, float], task: SpringTask) -> bool:
    """Whether a spring violates the limit on stress, diameter, length or arbor; False leaves it to ``check_spring``.

    A twentieth of the time of ``check_spring``, for a search in which most candidates are of too thin a wire.
    ``sizes``: wire diameter m, mean diameter m, body coils, as there.
    """
    d, mean, coils = sizes
    wire, limits, more = material.properties(d), task.limits, 1.0 + SLACK
    active = active_coils(coils, mean, task.leg_lengths, task.convention)
    used = rate(wire.elastic_modulus * task.calibration.rate, d, mean, active, task.rate_form)
    least = 1.0 if task.free_arm is None else LEAST_RATIO
    moment = used * max(task.travel, task.opening_travel) * least
    if stress.bending_stress(moment, d, mean) > wire.static_limit * wire.strength.value / limits.safety * more:
        return True
    widest = limits.max_outer_diameter
    if widest is not None and _opened_diameter(mean, coils, task) + d > widest * more:
        return True
    longest, inside = limits.max_body_length, limits.least_wound_inside()
    if longest is not None and space.body_length(d, coils, task.travel, task.pitch) > longest * more:
        return True
    return inside is not None and space.wound_inside_diameter(d, mean, coils, task.travel) < inside * (1.0 - SLACK)


def may_bear(wanted: float, task: SpringTask, material: WireMaterial, wire_diameter: float) -> bool:
    """Whether ``surely_broken`` may leave a spring of this wire (m) with the rate ``wanted`` (N m/rad).

    By the stress without curvature, whose factor is above 1; the candidates have the rate but for rounding.
    """
    wire = material.properties(wire_diameter)
    least = 1.0 if task.free_arm is None else LEAST_RATIO
    moment = wanted * max(task.travel, task.opening_travel) * least
    straight = 32.0 * moment / (math.pi * wire_diameter**3)
    return straight <= wire.static_limit * wire.strength.value / task.limits.safety * (1.0 + ROUNDED)


def least_mass(wanted: float, task: SpringTask, material: WireMaterial, wire_diameter: float) -> float:
    """Lower bound (kg) on the mass of the springs of this wire (m) with the rate ``wanted`` (N m/rad): without pitch.

    With tangent arms the product of mean diameter and coils is the same for all of them. Of others the bound is that of
    arms without the coil, which the rate may leave next to nothing.
    """
    wire = material.properties(wire_diameter)
    product = coil_product(wire.elastic_modulus * task.calibration.rate, wire_diameter, wanted, task.rate_form)
    coil = mean_diameter_for(product, 1.0, task.leg_lengths) if task.convention == "tangent" else 0.0
    length = math.pi * coil + sum(_arms(task, wire_diameter))
    return space.wire_mass(wire.density, wire_diameter, max(length, 0.0)) * (1.0 - ROUNDED)


def room_of(material: WireMaterial, sizes: tuple[float, float, float], task: SpringTask) -> Room:
    """Mass and room of a spring, without its load; ``sizes`` as in ``surely_broken``."""
    d, mean, coils = sizes
    length = space.wire_length(d, mean, coils, _arms(task, d))
    return Room(
        length,
        space.wire_mass(material.properties(d).density, d, length),
        _opened_diameter(mean, coils, task) + d,
        space.body_length(d, coils, task.travel, task.pitch),
    )


def _arms(task: SpringTask, wire_diameter: float) -> tuple[float, float]:
    """Lengths of the arms' wire, m: past the load; of arms that a joint clamps those to their ends are given."""
    return task.leg_lengths if task.free_arm is not None else arms_to_ends(wire_diameter, task.leg_lengths)


def _opened_diameter(mean: float, coils: float, task: SpringTask) -> float:
    """Mean diameter at the end of the opening travel, m."""
    return space.wound_mean_diameter(mean, coils, -min(task.opening_travel, MOST_UNWOUND * coils))
