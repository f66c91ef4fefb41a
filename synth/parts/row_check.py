"""Missing values and contradictions of catalogue rows."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from typing import TypeVar

from synth.parts.catalogue_row import CatalogueRow
from synth.parts.coil_angle import CONVENTIONS, TOLERANCE, angle_mismatch, included_angle
from synth.parts.coil_rate import rate
from synth.parts.material_names import KnownMaterials
from synth.parts.rows import RPM, CurvePointRow, DamperRow, GearMotorRow, MaterialRow, TorsionSpringRow, WireRow

DISAGREEMENT = 0.25  # published values this far apart contradict each other: vendors' tolerance is 10 %

SIZES_APART = 0.03  # makers hold the outer diameter within 1 to 3 %, and round to three digits

ROUNDING = 1e-6  # relative, of converted units

NO_TRAVEL = "no travel"

R = TypeVar("R", bound=CatalogueRow)


def complete_row(row: TorsionSpringRow) -> TorsionSpringRow:
    """The row with derived values: outer diameter, and rate from torque and deflection."""
    if row.outer_diameter is None and row.inner_diameter is not None and row.wire_diameter is not None:
        row = replace(row, outer_diameter=row.inner_diameter + 2.0 * row.wire_diameter)
    if row.rate is None and row.max_torque is not None and row.max_deflection is not None:
        rate = row.max_torque / row.max_deflection
        row = replace(row, rate=rate, rate_basis="derived = max torque / max deflection")
    return row


def completed_damper(row: DamperRow) -> DamperRow:
    """The row with its torque at the vendor's maximum speed, if no other speed is stated for it."""
    return replace(row, speed=row.max_speed) if row.speed is None and row.max_speed is not None else row


def missing_values(row: CatalogueRow, materials: KnownMaterials) -> list[str]:
    """The missing values of a row, in words; a material of unknown strength is one of them."""
    needed = getattr(row, "needed", ())
    lacking = [f"no {name.replace('_', ' ')}" for name in needed if getattr(row, name) in (None, "")]
    if isinstance(row, TorsionSpringRow) and row.material:
        unknown = materials.unknown_strength(row.material, row.wire_diameter)
        lacking += [unknown] if unknown else []
    if isinstance(row, TorsionSpringRow) and row.part.startswith("("):
        lacking.append("no part number")
    if isinstance(row, DamperRow):
        if row.min_torque is not None and row.max_torque is not None and row.min_torque < row.max_torque:
            lacking.append("torque given only as a range over variants")
        if row.continuous != "yes" and row.travel is None:
            lacking.append(NO_TRAVEL)
    return lacking


def contradictions(row: CatalogueRow, materials: KnownMaterials) -> list[str]:
    """Contradicting published values of a row, in words with the numbers."""
    if isinstance(row, TorsionSpringRow):
        return [*_rate(row, materials), *_angle(row), *_spring_sizes(row)]
    found: list[str] = []
    if isinstance(row, DamperRow):
        found += [*_damper_limits(row), *_damper_sizes(row)]
    elif isinstance(row, WireRow):
        low, high = row.min_tensile_strength, row.max_tensile_strength
        if low is not None and high is not None and low > high:
            found.append(f"least strength {low / 1e6:.4g} MPa above the greatest {high / 1e6:.4g} MPa")
        size, named = row.diameter, row.nominal_size
        # Twice the diameter's tolerance of wire.
        if size is not None and named is not None and abs(size / named - 1.0) > 0.01:
            found.append(f"diameter {size * 1e3:.4g} mm but nominal size {named / 0.0254:.4g} in")
    elif isinstance(row, GearMotorRow):
        found += _motor(row)
    elif isinstance(row, MaterialRow) and (row.max_diameter or math.inf) < (row.min_diameter or 0.0):
        found.append("least diameter above the greatest")
    return found


def _damper_limits(row: DamperRow) -> list[str]:
    """Torques, speeds and temperatures against their limits."""
    found: list[str] = []
    if row.min_torque is not None and row.max_torque is not None and row.min_torque > row.max_torque:
        found.append(f"least torque {row.min_torque:.4g} N*m above the greatest {row.max_torque:.4g} N*m")
    if row.reverse_torque is not None and row.max_torque is not None and row.reverse_torque > row.max_torque:
        found.append(f"reverse torque {row.reverse_torque:.4g} N*m above the torque {row.max_torque:.4g} N*m")
    if row.speed is not None and row.max_speed is not None and row.speed > row.max_speed * (1.0 + ROUNDING):
        found.append(f"torque at {row.speed / RPM:.4g} rpm, above the maximum speed {row.max_speed / RPM:.4g} rpm")
    low, high = row.min_temperature, row.max_temperature
    if low is not None and high is not None and low > high:
        found.append(f"least temperature {low:.4g} degC above the highest {high:.4g} degC")
    return found


def _damper_sizes(row: DamperRow) -> list[str]:
    """Screws and shaft against each other and the body; screws inside a body's outline may hold its face."""
    found: list[str] = []
    if row.bolts is not None and not row.bolts.is_integer():
        found.append(f"{row.bolts:.4g} bolts: they are counted")
    size, body = row.shaft_size, row.outer_diameter
    if size is not None and body is not None and size >= body:
        found.append(f"shaft {size * 1e3:.4g} mm not thinner than the body {body * 1e3:.4g} mm")
    circle, hole = row.bolt_circle, row.bolt_diameter or 0.0
    if size is not None and circle is not None and circle - hole <= size:
        found.append(f"bolts on a circle of {circle * 1e3:.4g} mm meet the shaft of {size * 1e3:.4g} mm")
    return found


def _motor(row: GearMotorRow) -> list[str]:
    """A gear cannot give more torque than its motor's constant times the ratio."""
    stall, free = row.stall_current, row.no_load_current
    if stall is not None and free is not None and stall <= free:
        return [f"stall current {stall:.4g} A not above the no-load current {free:.4g} A"]
    gain = row.torque_gain
    if gain is None or gain <= 1.05:  # 5 %: rounding of published torque and current
        return []
    return [f"stall torque and current with the no-load speed give a gear efficiency of {gain:.3g}"]


def judge_row(row: R, materials: KnownMaterials) -> R:
    """The row with its state: a declared fault is kept; a declared ``complete`` is verified."""
    if not row.sound:
        return row
    if found := contradictions(row, materials):
        return row.judged("contradiction", found)
    if lacking := missing_values(row, materials):
        return row.judged("incomplete", lacking)
    return row.judged("complete")


def geometric_rates(row: TorsionSpringRow, materials: KnownMaterials) -> tuple[float, float] | None:
    """Rate that the published geometry gives, N m/rad: bending form and friction form, without legs."""
    mean = row.mean_diameter
    if row.wire_diameter is None or mean is None or mean <= 0.0 or row.body_coils is None or not row.material:
        return None
    modulus = materials.modulus(row.material, row.wire_diameter)
    if modulus is None:
        return None
    return (
        rate(modulus, row.wire_diameter, mean, row.body_coils, "bending"),
        rate(modulus, row.wire_diameter, mean, row.body_coils, "friction"),
    )


def _rate(row: TorsionSpringRow, materials: KnownMaterials) -> list[str]:
    """A rate far from both forms of the geometry."""
    computed = geometric_rates(row, materials)
    if row.rate is None or computed is None or min(abs(value / row.rate - 1.0) for value in computed) <= DISAGREEMENT:
        return []
    bending, friction = computed
    return [
        f"{row.rate:.3g} N*m/rad published, its geometry gives {bending:.3g} (bending) or {friction:.3g} (friction)"
    ]


def _angle(row: TorsionSpringRow) -> list[str]:
    """An included angle that contradicts the coils, by the stated convention or tangent legs."""
    if row.included_angle is None or row.body_coils is None:
        return []
    coils, angle = row.body_coils, row.included_angle
    stated = next((each for each in CONVENTIONS if each == row.leg_convention), CONVENTIONS[0])
    if abs(angle_mismatch(coils, angle, stated)) <= TOLERANCE:
        return []
    given = math.degrees(included_angle(coils, stated))
    text = (
        f"included angle {math.degrees(angle):.4g} deg, but {coils:.4g} coils with {stated} legs give {given:.4g} deg"
    )
    fitting = [each for each in CONVENTIONS if abs(angle_mismatch(coils, angle, each)) <= TOLERANCE]
    if fitting:
        text += f" (with {' or '.join(fitting)} legs they agree: write leg_convention {fitting[0]} if intended)"
    elif not row.leg_convention:
        text += " (no leg_convention is given, so tangent is assumed; no other fits either)"
    return [text]


def _spring_sizes(row: TorsionSpringRow) -> list[str]:
    """Lengths and torques against each other."""
    found: list[str] = []
    inner = row.inside
    if row.inner_diameter is not None and row.outer_diameter is not None and row.wire_diameter is not None:
        outer = row.inner_diameter + 2.0 * row.wire_diameter
        if abs(outer / row.outer_diameter - 1.0) > SIZES_APART:
            found.append(
                f"inner diameter {row.inner_diameter * 1e3:.4g} mm and twice the wire {row.wire_diameter * 1e3:.4g} mm "
                f"make {outer * 1e3:.4g} mm, outer diameter {row.outer_diameter * 1e3:.4g} mm"
            )
    if inner is not None and inner <= 0.0:
        found.append("the outer diameter leaves no hole in the coil")
    elif inner is not None and row.max_arbor_diameter is not None and row.max_arbor_diameter > inner:
        found.append(f"arbor {row.max_arbor_diameter * 1e3:.4g} mm thicker than the hole {inner * 1e3:.4g} mm")
    if leg := _leg_inside(row):
        found.append(leg)
    close, body = row.close_wound_length, row.body_length
    if close is not None and body is not None and body < close * (1.0 - DISAGREEMENT):
        found.append(f"body length {body * 1e3:.4g} mm, but touching coils take {close * 1e3:.4g} mm")
    wound = row.body_length_at_max_torque
    if wound is not None and body is not None and wound < body * (1.0 - SIZES_APART):
        found.append(f"body length {wound * 1e3:.4g} mm at max torque, {body * 1e3:.4g} mm free: winding lengthens it")
    if row.max_torque is not None and row.max_deflection is not None and row.rate is not None:
        reached = row.rate * row.max_deflection
        if abs(reached / row.max_torque - 1.0) > DISAGREEMENT:
            found.append(f"rate times max deflection is {reached:.3g} N*m, max torque {row.max_torque:.3g} N*m")
    return found


def _leg_inside(row: TorsionSpringRow) -> str:
    """A leg that ends before it leaves the coil, tangent or radial; empty if there is none."""
    if row.leg_length is None or row.outer_diameter is None or row.wire_diameter is None:
        return ""
    outer, mean = row.outer_diameter / 2.0, (row.outer_diameter - row.wire_diameter) / 2.0
    if row.leg_convention == "axial" or math.hypot(row.leg_length, mean) >= outer:
        return ""
    return (
        f"legs of {row.leg_length * 1e3:.4g} mm from the axis end inside the coil, whose outer radius is "
        f"{outer * 1e3:.4g} mm"
    )


def curve_problems(points: list[CurvePointRow]) -> list[str]:
    """Faults of the points of one damper, sorted by speed."""
    found: list[str] = []
    for before, after in pairwise(points):
        if before.speed is None or after.speed is None or before.torque is None or after.torque is None:
            continue
        if after.speed == before.speed:
            found.append(f"two torques at one speed ({before.place} and {after.place})")
        elif after.torque < before.torque:
            found.append(f"torque falls with speed from {before.place} to {after.place}")
    return found
