"""Tolerances of parts relative to their catalogue rows, with sources.

A tolerance is a limit with a uniform distribution inside: the widest spread within the limit
that does not favour its ends.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import log, radians

from synth.parts.damper_law import CONCAVE, CONCAVE_EXPONENT_RANGE
from synth.parts.rows import DamperRow, TorsionSpringRow

RATE = 0.10  # see RATE_SOURCE
RATE_SOURCE = "usual: Lee and Century state torque within 10 %"
TORQUE = 0.15  # see TORQUE_SOURCE
TORQUE_SOURCE = "assumed: no vendor in the catalogues states a damper's tolerance"

# Coils up to -> free angle within; Lee Spring, http://www.leespring.com/torsion_tol.asp
FREE_ANGLE = ((10.5, radians(10.0)), (float("inf"), radians(15.0)))
FREE_ANGLE_SOURCE = "usual: Lee states 10 deg to 10 coils, 15 deg beyond"

# A lid with a TOK TD14 closes in 7.3 s at 0 degC and in 6 s at 40 degC: the torque falls in proportion
# (http://tok-inc-official-blog.blogspot.com/2018/06/characteristics-of-temperature-and.html).
PER_KELVIN = log(6.0 / 7.3) / 40.0
PER_KELVIN_SOURCE = "TOK TD14: 7.3 s at 0 degC, 6 s at 40 degC"


@dataclass(frozen=True)
class SpringTolerance:
    """Plus or minus: ``rate`` as a share, ``free_angle`` rad."""

    rate: float
    free_angle: float
    source: str


@dataclass(frozen=True)
class DamperTolerance:
    """``torque`` plus or minus as a share; ``exponents`` of an assumed law, least and greatest; ``per_kelvin`` 1/K."""

    torque: float
    per_kelvin: float
    exponents: tuple[float, float] | None
    source: str


def free_angle_tolerance(body_coils: float | None) -> float:
    """Rad, plus or minus, by the number of coils."""
    coils = body_coils if body_coils is not None else 0.0
    return next(angle for most, angle in FREE_ANGLE if coils <= most)


def bought_spring(row: TorsionSpringRow) -> SpringTolerance:
    """From the row if stated, else usual values."""
    sources = []
    rate, angle = row.rate_tolerance, row.free_angle_tolerance
    if rate is None:
        rate = RATE
        sources.append(f"rate {RATE_SOURCE}")
    if angle is None:
        angle = free_angle_tolerance(row.body_coils)
        sources.append(f"free angle {FREE_ANGLE_SOURCE}")
    return SpringTolerance(rate, angle, "; ".join(sources) or "the catalogue row")


def bought_damper(row: DamperRow, law: str) -> DamperTolerance:
    """From the row if stated, else assumed; an assumed law's exponent is uncertain as well."""
    sources = []
    torque, per_kelvin = row.torque_tolerance, row.torque_per_kelvin
    if torque is None:
        torque = TORQUE
        sources.append(f"torque {TORQUE_SOURCE}")
    if per_kelvin is None:
        per_kelvin = PER_KELVIN
        sources.append(f"temperature {PER_KELVIN_SOURCE}")
    exponents = CONCAVE_EXPONENT_RANGE if law == CONCAVE else None
    if exponents is not None:
        sources.append(f"exponent of the assumed law {exponents[0]:g} to {exponents[1]:g}")
    return DamperTolerance(torque, per_kelvin, exponents, "; ".join(sources) or "the catalogue row")


def measured_damper(torque: float) -> DamperTolerance:
    """A damper whose curve was measured."""
    return DamperTolerance(
        torque, PER_KELVIN, None, f"measured curve within {torque:.0%}; temperature {PER_KELVIN_SOURCE}"
    )
