"""Catalogue rows as objects: each field is a column with its unit and meaning.

A column's header is ``field_name [unit]``; values are stored in SI. ``None`` means unknown.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import ClassVar

from synth.files.project_options import WIDEST
from synth.parts.catalogue_row import CatalogueRow, quantity_column, text_column
from synth.parts.damper_law import CONCAVE, CONCAVE_EXPONENT, LINEAR, TABLE, LowSpeedLaw, low_speed_law, power_law_curve
from synth.swing.leg_model import Damper, DamperCurve

RPM = math.pi / 30.0  # rad/s
INTERPOLATED = "derived"  # the basis of a gear motor between found ones
# Wire is drawn to steps of half a thousandth of an inch or of a hundredth of a millimetre.
INCH_STEP, METRIC_STEP, SAME_STEP = 0.0254 / 2000.0, 1e-5, 1e-8

# Pa, limits of what is read, against wrong units: spring wire has 0.7 GPa (phosphor bronze of 10 mm) to 3.3 GPa (music
# wire of 0.1 mm), and the moduli in the catalogue are 38 to 214 GPa.
WEAKEST, STRONGEST = 0.3e9, 5e9
SOFTEST, STIFFEST = 5e9, 500e9


@dataclass(frozen=True)
class TorsionSpringRow(CatalogueRow):
    """A torsion spring that a vendor sells."""

    family: ClassVar[str] = "torsion_springs"
    part: str = text_column(key=True)
    vendor: str = text_column()
    material: str = text_column()
    hand: str = text_column(choices=("left", "right"))
    included_angle: float | None = quantity_column("rad", "deg", zero=True, most=math.tau)
    leg_convention: str = text_column(choices=("tangent", "radial", "axial"))
    rate: float | None = quantity_column("N*m/rad", "N*m/rad", key=True)
    rate_basis: str = text_column()
    wire_diameter: float | None = quantity_column("m", "mm")
    outer_diameter: float | None = quantity_column("m", "mm")
    inner_diameter: float | None = quantity_column("m", "mm")
    body_coils: float | None = quantity_column("1", "1")
    leg_length: float | None = quantity_column("m", "mm")
    body_length: float | None = quantity_column("m", "mm")
    body_length_at_max_torque: float | None = quantity_column("m", "mm")
    max_arbor_diameter: float | None = quantity_column("m", "mm")
    max_torque: float | None = quantity_column("N*m", "N*m")
    max_deflection: float | None = quantity_column("rad", "deg")
    rate_tolerance: float | None = quantity_column("1", "%", most=WIDEST)
    free_angle_tolerance: float | None = quantity_column("rad", "deg", most=math.pi)

    derived: tuple[str, ...] = field(default=(), metadata={"column": False})
    measure: tuple[str, ...] = field(default=(), metadata={"column": False})
    assumed: tuple[str, ...] = field(default=(), metadata={"column": False})  # columns whose value is not the table's

    needed: ClassVar[tuple[str, ...]] = (
        "part", "rate", "material", "wire_diameter", "outer_diameter", "body_coils", "included_angle",
    )  # fmt: skip

    @property
    def mean_diameter(self) -> float | None:
        """Outer less wire diameter, m."""
        if self.outer_diameter is None or self.wire_diameter is None:
            return None
        return self.outer_diameter - self.wire_diameter

    @property
    def inside(self) -> float | None:
        """Inside diameter of the free coil, m: as published, else outer less two wire diameters."""
        if self.inner_diameter is not None:
            return self.inner_diameter
        if self.outer_diameter is None or self.wire_diameter is None:
            return None
        return self.outer_diameter - 2.0 * self.wire_diameter

    @property
    def system(self) -> str | None:
        """``inch`` or ``metric`` from the wire's size, None if unknown or both."""
        if self.wire_diameter is None:
            return None
        inch = abs(math.remainder(self.wire_diameter, INCH_STEP)) < SAME_STEP
        metric = abs(math.remainder(self.wire_diameter, METRIC_STEP)) < SAME_STEP
        return None if inch == metric else "inch" if inch else "metric"

    @property
    def close_wound_length(self) -> float | None:
        """Body length of touching coils d (N + 1), m, used if none is published."""
        if self.wire_diameter is None or self.body_coils is None:
            return None
        return self.wire_diameter * (self.body_coils + 1.0)


@dataclass(frozen=True)
class DamperRow(CatalogueRow):
    """A rotary damper that a vendor sells, with the points of its torque-speed curve if available."""

    family: ClassVar[str] = "dampers"
    part: str = text_column(key=True)
    vendor: str = text_column()
    product_line: str = text_column()
    direction: str = text_column(choices=("both", "clockwise", "counter-clockwise", "one-way"))
    continuous: str = text_column(choices=("yes", "no"))
    travel: float | None = quantity_column("rad", "deg")
    min_torque: float | None = quantity_column("N*m", "N*m")
    max_torque: float | None = quantity_column("N*m", "N*m", key=True)
    speed: float | None = quantity_column("rad/s", "rpm", key=True)
    max_speed: float | None = quantity_column("rad/s", "rpm")
    temperature: float | None = quantity_column("degC", "degC", signed=True)
    reverse_torque: float | None = quantity_column("N*m", "N*m", zero=True)
    outer_diameter: float | None = quantity_column("m", "mm")
    body_length: float | None = quantity_column("m", "mm")
    bolt_circle: float | None = quantity_column("m", "mm")
    bolts: float | None = quantity_column("1", "1")
    bolt_diameter: float | None = quantity_column("m", "mm")
    shaft_side: str = text_column(choices=("shaft", "bore"))
    shaft_form: str = text_column(choices=("round", "d", "square", "hex"))
    shaft_size: float | None = quantity_column("m", "mm")
    min_temperature: float | None = quantity_column("degC", "degC", signed=True)
    max_temperature: float | None = quantity_column("degC", "degC", signed=True)
    torque_tolerance: float | None = quantity_column("1", "%", most=WIDEST)
    torque_per_kelvin: float | None = quantity_column("1/K", "%/K", signed=True)
    curve_speed: tuple[float, ...] = field(default=(), metadata={"column": False})
    curve_torque: tuple[float, ...] = field(default=(), metadata={"column": False})
    torque_range: tuple[float, float] | None = field(default=None, metadata={"column": False})
    ordered: bool = field(default=False, metadata={"column": False})
    derived: tuple[str, ...] = field(default=(), metadata={"column": False})
    measure: tuple[str, ...] = field(default=(), metadata={"column": False})
    assumed: tuple[str, ...] = field(default=(), metadata={"column": False})  # columns whose value is not the table's

    needed: ClassVar[tuple[str, ...]] = ("part", "max_torque", "speed", "direction")

    @property
    def order(self) -> str:
        """The part as ordered: with its torque if the vendor sells a range."""
        return f"{self.part} at {self.max_torque:.3g} N*m" if self.ordered and self.max_torque else self.part

    @property
    def secant_rate(self) -> float | None:
        """Torque over speed at the vendor's point, N m s/rad: the *lowest* linear rate of the damper."""
        if self.max_torque is None or self.speed is None:
            return None
        return self.max_torque / self.speed

    @property
    def default_law(self) -> str:
        """``table`` if two or more points are known, else ``concave``."""
        return TABLE if len(self.curve_speed) >= 2 else CONCAVE

    def allows_travel(self, travel: float) -> bool | None:
        """Whether the damper turns through ``travel`` rad; None if unknown."""
        if self.continuous == "yes":
            return True
        return None if self.travel is None else bool(self.travel >= travel * (1.0 - 1e-9))  # also of a numpy number

    @property
    def below_table(self) -> LowSpeedLaw | None:
        """How its measured points are continued below the lowest one; None if they need not be, or there are none."""
        return low_speed_law(DamperCurve(self.curve_speed, self.curve_torque)) if self.curve_speed else None

    def torque_speed(self, law: str | None = None, exponent: float | None = None) -> DamperCurve:
        """The torque-speed curve by a law.

        Parameters
        ----------
        law : ``table`` (the measured points, continued below the lowest), ``concave`` (power law through the one
            point, see ``damper_law``), ``linear`` (straight through the one point) or None for the default one.
        exponent : of the concave law or below the table; None: the assumed or found one.

        Raises
        ------
        ValueError
            If the row lacks what the law needs or the law is unknown.
        """
        law = law or self.default_law
        if law == TABLE:
            if not self.curve_speed:
                raise ValueError(f"{self.part} has no curve points")
            below = self.below_table
            return DamperCurve(self.curve_speed, self.curve_torque) if below is None else below.curve(exponent)
        if self.max_torque is None or self.speed is None:
            raise ValueError(f"{self.part} ({self.place}) has no torque at a speed: {self.status}")
        if law == LINEAR:
            return DamperCurve((self.speed,), (self.max_torque,))
        if law == CONCAVE:
            return power_law_curve(self.max_torque, self.speed, CONCAVE_EXPONENT if exponent is None else exponent)
        raise ValueError(f"unknown damper law {law!r}; the laws are {TABLE}, {CONCAVE}, {LINEAR}")

    def damper(self, law: str | None = None, exponent: float | None = None) -> Damper:
        """The damper as an element of a leg, named by its part."""
        law = law or self.default_law
        if law == LINEAR:
            curve = self.torque_speed(LINEAR)
            return Damper(rate=curve.torque[0] / curve.speed[0], part=self.part)
        return Damper(curve=self.torque_speed(law, exponent), part=self.part)


@dataclass(frozen=True)
class CurvePointRow(CatalogueRow):
    """One point of a damper's torque-speed curve."""

    family: ClassVar[str] = "damper_curves"
    part: str = text_column(key=True)
    vendor: str = text_column()
    speed: float | None = quantity_column("rad/s", "rpm", key=True)
    torque: float | None = quantity_column("N*m", "N*m", key=True)

    needed: ClassVar[tuple[str, ...]] = ("part", "speed", "torque")


@dataclass(frozen=True)
class WireRow(CatalogueRow):
    """A stock size of spring wire, with its strength if listed."""

    family: ClassVar[str] = "wire_diameters"
    series: str = text_column(key=True)
    material: str = text_column()
    grade: str = text_column()
    system: str = text_column(choices=("inch", "metric"))
    gauge: str = text_column()
    diameter: float | None = quantity_column("m", "mm", key=True)
    nominal_size: float | None = quantity_column("m", "in")
    min_tensile_strength: float | None = quantity_column("Pa", "MPa", least=WEAKEST, most=STRONGEST)
    max_tensile_strength: float | None = quantity_column("Pa", "MPa", least=WEAKEST, most=STRONGEST)
    diameter_tolerance: float | None = quantity_column("m", "mm")

    needed: ClassVar[tuple[str, ...]] = ("series", "diameter")


@dataclass(frozen=True)
class MaterialRow(CatalogueRow):
    """One property of one wire material from one source; percentages are fractions of the tensile strength."""

    family: ClassVar[str] = "wire_materials"
    material: str = text_column(key=True)
    name_as_published: str = text_column()
    standard: str = text_column()
    record: str = text_column(key=True)
    min_diameter: float | None = quantity_column("m", "mm")
    max_diameter: float | None = quantity_column("m", "mm")
    strength_at_1_mm: float | None = quantity_column("Pa", "MPa", least=WEAKEST, most=STRONGEST)
    strength_exponent: float | None = quantity_column("1", "1", zero=True)
    log_law_strength_at_1_mm: float | None = quantity_column("Pa", "MPa", least=WEAKEST, most=STRONGEST)
    log_law_drop_per_decade: float | None = quantity_column("Pa", "MPa", zero=True)
    strength_cap: float | None = quantity_column("Pa", "MPa", least=WEAKEST, most=STRONGEST)
    elastic_modulus: float | None = quantity_column("Pa", "GPa", least=SOFTEST, most=STIFFEST)
    shear_modulus: float | None = quantity_column("Pa", "GPa", least=SOFTEST, most=STIFFEST)
    elastic_limit_tension_low: float | None = quantity_column("1", "%")
    elastic_limit_tension_high: float | None = quantity_column("1", "%")
    elastic_limit_torsion_low: float | None = quantity_column("1", "%")
    elastic_limit_torsion_high: float | None = quantity_column("1", "%")
    density: float | None = quantity_column("kg/m^3", "kg/m^3")
    static_bending_limit: float | None = quantity_column("1", "%")
    static_bending_limit_not_relieved: float | None = quantity_column("1", "%")
    repeated_bending_limit_1e5: float | None = quantity_column("1", "%")
    repeated_bending_limit_1e6: float | None = quantity_column("1", "%")
    relative_cost: float | None = quantity_column("1", "1")

    needed: ClassVar[tuple[str, ...]] = ("material", "record")

    def covers(self, diameter: float) -> bool:
        """Whether the record applies to wire of this diameter, m; a missing bound is no limit."""
        low = self.min_diameter if self.min_diameter is not None else 0.0
        high = self.max_diameter if self.max_diameter is not None else math.inf
        return low * (1.0 - 1e-6) <= diameter <= high * (1.0 + 1e-6)  # 1e-6: rounding of converted units

    def strength(self, diameter: float) -> float | None:
        """Tensile strength by the record's law, Pa; None if it has none.

        ``A / d^m`` (Shigley, Mechanical Engineering Design, eq. 10-14) or ``RM0 - DRM log10 d`` (EN 10270), d in mm.
        """
        millimetres = diameter * 1e3
        if self.strength_at_1_mm is not None and self.strength_exponent is not None:
            return self.strength_at_1_mm / float(millimetres**self.strength_exponent)
        if self.log_law_strength_at_1_mm is not None and self.log_law_drop_per_decade is not None:
            value = self.log_law_strength_at_1_mm - self.log_law_drop_per_decade * math.log10(millimetres)
            return value if self.strength_cap is None else min(value, self.strength_cap)
        return None


@dataclass(frozen=True)
class GearMotorRow(CatalogueRow):
    """A gear motor that a vendor sells, at one voltage; torque and speeds at the output shaft."""

    family: ClassVar[str] = "gearmotors"
    part: str = text_column(key=True)
    vendor: str = text_column()
    product_line: str = text_column()
    variant: str = text_column()
    items: str = text_column()
    gear_ratio: float | None = quantity_column("1", "1", key=True)
    voltage: float | None = quantity_column("V", "V")
    no_load_speed: float | None = quantity_column("rad/s", "rpm", key=True)
    stall_torque: float | None = quantity_column("N*m", "N*m", key=True)
    stall_current: float | None = quantity_column("A", "A")
    no_load_current: float | None = quantity_column("A", "A")
    mass: float | None = quantity_column("kg", "g")
    torque_limit: float | None = quantity_column("N*m", "N*m")
    speed_tolerance: float | None = quantity_column("1", "%", zero=True, most=WIDEST)
    current_tolerance: float | None = quantity_column("1", "%", zero=True, most=WIDEST)
    resistance: float | None = quantity_column("ohm", "ohm")
    inductance: float | None = quantity_column("H", "mH")
    rotor_inertia: float | None = quantity_column("kg*m^2", "kg*m^2")
    speed_at_best_efficiency: float | None = quantity_column("rad/s", "rpm")
    torque_at_best_efficiency: float | None = quantity_column("N*m", "N*m")
    current_at_best_efficiency: float | None = quantity_column("A", "A")
    size: str = text_column()
    shaft_size: float | None = quantity_column("m", "mm")
    basis: str = text_column()

    needed: ClassVar[tuple[str, ...]] = (
        "part", "gear_ratio", "voltage", "no_load_speed", "stall_torque", "stall_current", "no_load_current", "mass",
    )  # fmt: skip

    @property
    def interpolated(self) -> bool:
        """Whether its values lie between found rows: ``basis`` is the word ``derived``, before any remark on it."""
        return self.basis.partition(";")[0].strip() == INTERPOLATED

    @property
    def basis_remark(self) -> str:
        """What ``basis`` says after its word, as ``currents are those of the 50:1``; empty if nothing."""
        return self.basis.partition(";")[2].strip()

    @property
    def same_motor(self) -> tuple[str, ...]:
        """What rows of one motor behind different gears have in common; without a product line a row is alone."""
        return (self.vendor, self.product_line, self.variant) if self.product_line else (self.vendor, self.part)

    @property
    def torque_gain(self) -> float | None:
        """Torque constant seen through the gear over the back-EMF constant: the gear's efficiency at stall.

        K_t = T_stall / (G (I_stall - I_free)), K_e = (V - I_free R) / (G omega_free), R = V / I_stall.
        """
        known = (self.voltage, self.no_load_speed, self.stall_torque, self.stall_current, self.no_load_current)
        voltage, speed, torque, stall, free = known
        if voltage is None or speed is None or torque is None or stall is None or free is None or stall <= free:
            return None
        return torque * speed / ((stall - free) * voltage * (1.0 - free / stall))


FAMILIES: dict[str, type[CatalogueRow]] = {
    row.family: row for row in (TorsionSpringRow, DamperRow, CurvePointRow, WireRow, MaterialRow, GearMotorRow)
}
