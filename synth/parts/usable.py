"""Incomplete rows that can be chosen nevertheless: the assumed values, their source and uncertainty.

Nothing is invented. Values that can be measured on receipt (the angle between the legs, the exact coils) are derived
from other published values and must be measured before printing; values settled by the order (the
torque within a range, the number of a row of dimensions) are stated with it; unpublished values (the speed of a
torque) are assumptions whose whole range enters the part's tolerance. The state is then ``usable``, its reasons name
each of these, and ``derived`` lists them.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TypeVar

from synth.parts.coil_angle import CONVENTIONS, TOLERANCE, angle_mismatch, coil_fraction, included_angle
from synth.parts.damper_law import CONCAVE_EXPONENT
from synth.parts.material_names import KnownMaterials
from synth.parts.part_tolerance import TORQUE
from synth.parts.row_check import NO_TRAVEL, judge_row
from synth.parts.rows import RPM, DamperRow, TorsionSpringRow

R = TypeVar("R", TorsionSpringRow, DamperRow)
WHOLE = 1e-6  # coils nearer to a whole number were counted, not measured

# TOK states the torque of its endless dampers at 20 or 30 rpm (jp.rotarydamper-tok-inc.com/technicalinformation-18).
ENDLESS_SPEED = (20.0 * RPM, 30.0 * RPM)
# No vendor of vane dampers in the catalogues states the speed. Stated ones are between 20 rpm (TOK) and 50 (McMaster);
# a vane damper brakes a lid that turns a quarter in one to three seconds, 5 to 15 rpm.
VANE_SPEED = (5.0 * RPM, 50.0 * RPM)
LEVELS = 1.3  # ratio of the torques of a range that are tried: half of it is within a damper's tolerance


def usable_spring(row: TorsionSpringRow, materials: KnownMaterials) -> TorsionSpringRow:
    """The spring with values to measure or order, or unchanged if more is missing.

    A complete row is complete without its hand, but a joint is printed for one hand: it is looked at on receipt.
    """
    if row.complete:
        return row if row.hand else replace(row, measure=("hand",))
    tried, derived, measure = row.judged(""), [], []
    if row.part.startswith("("):
        derived.append("the part number, from the dimensions in the vendor's table")
        tried = replace(tried, part=_by_dimensions(row))
    if row.included_angle is None and row.body_coils is not None:
        angle = included_angle(row.body_coils, "tangent")
        tried = replace(tried, included_angle=angle, free_angle_tolerance=math.pi)
        derived.append(f"included angle {math.degrees(angle):.0f} deg from {row.body_coils:.4g} coils, tangent legs")
        measure.append("included angle")
    elif (coils := _contradicted_coils(row)) is not None:
        tried = replace(tried, body_coils=coils)
        derived.append(f"{coils:.4g} coils from the included angle, tangent legs; {row.body_coils:.4g} were counted")
        measure.append("coils")
    if row.hand == "":
        measure.append("hand")
    if not derived or not judge_row(tried, materials).complete:
        return row
    return _usable(row, tried, derived, measure)


def _by_dimensions(row: TorsionSpringRow) -> str:
    """A name for the order, from what distinguishes this row in its table."""
    wire, outer = row.wire_diameter, row.outer_diameter
    sizes = [f"{value / 0.0254:.3g} in {what}" for value, what in ((wire, "wire"), (outer, "outside")) if value]
    if row.body_coils is not None:
        sizes.append(f"{row.body_coils:.4g} coils")
    return f"{row.vendor} torsion spring {', '.join(sizes)}"


def _contradicted_coils(row: TorsionSpringRow) -> float | None:
    """Coils of a spring whose published whole number contradicts its included angle."""
    angle, coils = row.included_angle, row.body_coils
    if angle is None or coils is None or abs(coils - round(coils)) > WHOLE or row.leg_convention:
        return None
    if abs(angle_mismatch(coils, angle, CONVENTIONS[0])) < TOLERANCE:
        return None
    return round(coils) + coil_fraction(angle)


def usable_damper(row: DamperRow, materials: KnownMaterials) -> DamperRow:
    """The damper with its torque to order and an assumed speed, or unchanged if more is missing."""
    if row.complete or row.max_torque is None or row.part.startswith("family:") or not row.part:
        return row
    if row.state in ("contradiction", "suspect", "alternate"):
        return row
    tried, derived, measure = row.judged(""), [], []
    if row.min_torque is not None and row.min_torque < row.max_torque:
        derived.append(f"torque to order, {row.min_torque:.3g} to {row.max_torque:.3g} N*m")
        tried = replace(tried, min_torque=None, torque_range=(row.min_torque, row.max_torque))
    if row.speed is None:
        endless = row.continuous == "yes"
        low, high = ENDLESS_SPEED if endless else VANE_SPEED
        speed = math.sqrt(low * high)
        share = (high / speed) ** CONCAVE_EXPONENT - 1.0
        given = TORQUE if row.torque_tolerance is None else row.torque_tolerance
        tried = replace(tried, speed=speed, torque_tolerance=math.hypot(given, share))
        derived.append(f"speed {speed / RPM:.0f} rpm, assumed: {low / RPM:.0f} to {high / RPM:.0f} rpm")
        measure.append("torque at a speed")
    if not row.direction:
        derived.append("direction assumed one way, the conservative case; two then form a pair")
        tried = replace(tried, direction="one-way")
        measure.append("direction")
    if row.continuous != "yes" and row.travel is None:
        derived.append("travel unknown: ask the vendor")
        measure.append("travel")
        tried = replace(tried, travel=None)
    if not derived or _lacks_values(tried, materials):
        return row
    return _usable(row, tried, derived, measure)


def offers(row: DamperRow) -> tuple[DamperRow, ...]:
    """The row at each torque of the range to try, or the row itself if it has one torque."""
    if row.torque_range is None:
        return (row,)
    low, high = row.torque_range
    count = math.ceil(math.log(high / low) / math.log(LEVELS)) + 1
    return tuple(
        replace(row, max_torque=low * (high / low) ** (k / (count - 1)), ordered=True) for k in range(count)
    )  # fmt: skip


def _lacks_values(row: DamperRow, materials: KnownMaterials) -> bool:
    """Whether more than the travel is missing."""
    found = judge_row(row, materials)
    return not found.complete and found.reasons != (NO_TRAVEL,)


def _usable(published: R, row: R, derived: list[str], measure: list[str]) -> R:
    """The row, usable, with the columns that differ from the published row."""
    reasons = [*derived, f"measure before printing: {', '.join(measure)}"] if measure else derived
    names = [item.name for item in type(row).columns() if item.name != "status"]
    assumed = tuple(name for name in names if getattr(row, name) != getattr(published, name))
    return replace(row.judged("usable", reasons), derived=tuple(derived), measure=tuple(measure), assumed=assumed)
