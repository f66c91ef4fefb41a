"""Tolerances of parts relative to their catalogue rows, with sources.

A tolerance is a limit with a uniform distribution inside: the widest spread within the limit
that does not favour its ends.
"""

from __future__ import annotations

from collections.abc import Mapping
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


ROW, PROJECT = "by the catalogue row", "by the project file"


@dataclass(frozen=True)
class SpringTolerance:
    """Plus or minus: ``rate`` as a share, ``free_angle`` rad, each with its source."""

    rate: float
    free_angle: float
    rate_source: str
    free_angle_source: str

    @property
    def source(self) -> str:
        """Where each quantity comes from."""
        return _stated({"rate": self.rate_source, "free angle": self.free_angle_source})


@dataclass(frozen=True)
class DamperTolerance:
    """``torque`` plus or minus as a share; ``exponents`` of an assumed law, least and greatest; ``per_kelvin`` 1/K."""

    torque: float
    per_kelvin: float
    exponents: tuple[float, float] | None
    torque_source: str
    per_kelvin_source: str

    @property
    def source(self) -> str:
        """Where each quantity comes from."""
        text = _stated({"torque": self.torque_source, "temperature": self.per_kelvin_source})
        if self.exponents is None:
            return text
        return f"{text}; exponent of the assumed law {self.exponents[0]:g} to {self.exponents[1]:g}"


def _stated(sources: Mapping[str, str]) -> str:
    """Each quantity with its source; of all only the source if it is the same."""
    if len(set(sources.values())) == 1:
        return next(iter(sources.values())).removeprefix("by ")
    return "; ".join(f"{name} {source}" for name, source in sources.items())


def free_angle_tolerance(body_coils: float | None) -> float:
    """Rad, plus or minus, by the number of coils."""
    coils = body_coils if body_coils is not None else 0.0
    return next(angle for most, angle in FREE_ANGLE if coils <= most)


def bought_spring(row: TorsionSpringRow) -> SpringTolerance:
    """From the row if stated, else usual values."""
    rate, angle = row.rate_tolerance, row.free_angle_tolerance
    return SpringTolerance(
        RATE if rate is None else rate,
        free_angle_tolerance(row.body_coils) if angle is None else angle,
        RATE_SOURCE if rate is None else ROW,
        FREE_ANGLE_SOURCE if angle is None else ROW,
    )


def bought_damper(row: DamperRow, law: str) -> DamperTolerance:
    """From the row if stated, else assumed; an assumed law's exponent is uncertain as well."""
    torque, per_kelvin = row.torque_tolerance, row.torque_per_kelvin
    return DamperTolerance(
        TORQUE if torque is None else torque,
        PER_KELVIN if per_kelvin is None else per_kelvin,
        CONCAVE_EXPONENT_RANGE if law == CONCAVE else None,
        TORQUE_SOURCE if torque is None else ROW,
        PER_KELVIN_SOURCE if per_kelvin is None else ROW,
    )


def measured_damper(torque: float) -> DamperTolerance:
    """A damper whose curve was measured."""
    return DamperTolerance(torque, PER_KELVIN, None, f"within {torque:.0%} of the measured curve", PER_KELVIN_SOURCE)
