"""Catalogue rows as objects: each field is a column with its unit and meaning.

A column's header is ``field_name [unit]``; values are stored in SI. ``None`` means unknown.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import Field, dataclass, field, fields, replace
from typing import Any, ClassVar, Literal, Self

from synth.parts.damper_law import CONCAVE, CONCAVE_EXPONENT, LINEAR, TABLE, power_law_curve
from synth.swing.leg_model import Damper, DamperCurve

RPM = math.pi / 30.0  # rad/s
INTERPOLATED = "derived"  # the basis of a gear motor between found ones
# Wire is drawn to steps of half a thousandth of an inch or of a hundredth of a millimetre.
INCH_STEP, METRIC_STEP, SAME_STEP = 0.0254 / 2000.0, 1e-5, 1e-8


State = Literal["", "complete", "usable", "incomplete", "contradiction", "suspect", "alternate", "size only", "other"]
"""Empty before it is determined; ``other`` is any other word that a table's status column begins with."""
DECLARED: tuple[State, ...] = ("usable", "incomplete", "contradiction", "suspect", "alternate", "size only")
SEPARATORS: dict[State, str] = {"incomplete": ", "}  # of reasons in the column; of other states a semicolon


def declared_state(status: str) -> State:
    """The state that a cell of a table's status column begins with."""
    if status in ("", "complete"):
        return "complete" if status else ""
    return next((state for state in DECLARED if status.startswith(state)), "other")


def _quantity(unit: str, shown: str, *, key: bool = False, zero: bool = False, signed: bool = False) -> Any:
    """A column with a unit. ``shown``: display unit. ``zero``, ``signed``: whether values <= 0 are allowed."""
    return field(default=None, metadata={"unit": unit, "shown": shown, "key": key, "zero": zero, "signed": signed})


def _text(*, key: bool = False, choices: tuple[str, ...] = ()) -> Any:
    """A text column. ``key``: identifies a file of this family."""
    return field(default="", metadata={"unit": None, "key": key, "choices": choices})


@dataclass(frozen=True)
class CatalogueRow:
    """The common part of every catalogue row: place, source and status.

    ``status`` is the column: ``state``, with ``reasons`` behind it. ``judged`` sets all three.
    """

    family: ClassVar[str]
    file: str = field(default="", metadata={"column": False})
    line: int = field(default=0, metadata={"column": False})
    status: str = _text()
    source: str = _text()
    as_published: str = _text()
    note: str = _text()
    price: str = field(default="", metadata={"unit": None, "key": False, "choices": (), "currency": True})  # of one
    state: State = field(default="", metadata={"column": False})
    reasons: tuple[str, ...] = field(default=(), metadata={"column": False})

    def judged(self, state: State, reasons: Sequence[str] = ()) -> Self:
        """The row with this state, whose reasons stand behind it in the column."""
        because = f": {SEPARATORS.get(state, '; ').join(reasons)}" if reasons else ""
        return replace(self, state=state, reasons=tuple(reasons), status=f"{state}{because}")

    @property
    def complete(self) -> bool:
        """Whether the row has all required values without contradiction."""
        return self.state == "complete"

    @property
    def choosable(self) -> bool:
        """Whether it may be chosen: complete, or usable within the limits of its status (``usable``)."""
        return self.complete or self.state == "usable"

    @property
    def sound(self) -> bool:
        """Whether it is not declared suspect or an alternate, also before its status is computed."""
        return self.state in ("", "complete")

    @property
    def place(self) -> str:
        """``file:line``."""
        return f"{self.file}:{self.line}"

    @classmethod
    def columns(cls) -> tuple[Field[Any], ...]:
        """The fields that are columns of the CSV."""
        return tuple(item for item in fields(cls) if item.metadata.get("column", True))


@dataclass(frozen=True)
class TorsionSpringRow(CatalogueRow):
    """A torsion spring that a vendor sells."""

    family: ClassVar[str] = "torsion_springs"
    part: str = _text(key=True)
    vendor: str = _text()
    material: str = _text()
    hand: str = _text(choices=("left", "right"))
    included_angle: float | None = _quantity("rad", "deg", zero=True)
    leg_convention: str = _text(choices=("tangent", "radial", "axial"))
    rate: float | None = _quantity("N*m/rad", "N*m/rad", key=True)
    rate_basis: str = _text()
    wire_diameter: float | None = _quantity("m", "mm")
    outer_diameter: float | None = _quantity("m", "mm")
    inner_diameter: float | None = _quantity("m", "mm")
    body_coils: float | None = _quantity("1", "1")
    leg_length: float | None = _quantity("m", "mm")
    body_length: float | None = _quantity("m", "mm")
    body_length_at_max_torque: float | None = _quantity("m", "mm")
    max_arbor_diameter: float | None = _quantity("m", "mm")
    max_torque: float | None = _quantity("N*m", "N*m")
    max_deflection: float | None = _quantity("rad", "deg")
    rate_tolerance: float | None = _quantity("1", "%")
    free_angle_tolerance: float | None = _quantity("rad", "deg")

    derived: tuple[str, ...] = field(default=(), metadata={"column": False})
    measure: tuple[str, ...] = field(default=(), metadata={"column": False})

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
    part: str = _text(key=True)
    vendor: str = _text()
    product_line: str = _text()
    direction: str = _text(choices=("both", "clockwise", "counter-clockwise", "one-way"))
    continuous: str = _text(choices=("yes", "no"))
    travel: float | None = _quantity("rad", "deg")
    min_torque: float | None = _quantity("N*m", "N*m")
    max_torque: float | None = _quantity("N*m", "N*m", key=True)
    speed: float | None = _quantity("rad/s", "rpm", key=True)
    max_speed: float | None = _quantity("rad/s", "rpm")
    temperature: float | None = _quantity("degC", "degC", signed=True)
    reverse_torque: float | None = _quantity("N*m", "N*m", zero=True)
    outer_diameter: float | None = _quantity("m", "mm")
    body_length: float | None = _quantity("m", "mm")
    bolt_circle: float | None = _quantity("m", "mm")
    bolts: float | None = _quantity("1", "1")
    bolt_diameter: float | None = _quantity("m", "mm")
    shaft_side: str = _text(choices=("shaft", "bore"))
    shaft_form: str = _text(choices=("round", "d", "square", "hex"))
    shaft_size: float | None = _quantity("m", "mm")
    min_temperature: float | None = _quantity("degC", "degC", signed=True)
    max_temperature: float | None = _quantity("degC", "degC", signed=True)
    torque_tolerance: float | None = _quantity("1", "%")
    torque_per_kelvin: float | None = _quantity("1/K", "%/K", signed=True)
    curve_speed: tuple[float, ...] = field(default=(), metadata={"column": False})
    curve_torque: tuple[float, ...] = field(default=(), metadata={"column": False})
    torque_range: tuple[float, float] | None = field(default=None, metadata={"column": False})
    ordered: bool = field(default=False, metadata={"column": False})
    derived: tuple[str, ...] = field(default=(), metadata={"column": False})
    measure: tuple[str, ...] = field(default=(), metadata={"column": False})

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

    def torque_speed(self, law: str | None = None, exponent: float = CONCAVE_EXPONENT) -> DamperCurve:
        """The torque-speed curve by a law.

        Parameters
        ----------
        law : ``table`` (the measured points), ``concave`` (power law through the one point, see ``damper_law``),
            ``linear`` (straight through the one point) or None for the default one.
        exponent : of the concave law.

        Raises
        ------
        ValueError
            If the row lacks what the law needs or the law is unknown.
        """
        law = law or self.default_law
        if law == TABLE:
            if not self.curve_speed:
                raise ValueError(f"{self.part} has no curve points")
            return DamperCurve(self.curve_speed, self.curve_torque)
        if self.max_torque is None or self.speed is None:
            raise ValueError(f"{self.part} ({self.place}) has no torque at a speed: {self.status}")
        if law == LINEAR:
            return DamperCurve((self.speed,), (self.max_torque,))
        if law == CONCAVE:
            return power_law_curve(self.max_torque, self.speed, exponent)
        raise ValueError(f"unknown damper law {law!r}; the laws are {TABLE}, {CONCAVE}, {LINEAR}")

    def damper(self, law: str | None = None, exponent: float = CONCAVE_EXPONENT) -> Damper:
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
    part: str = _text(key=True)
    vendor: str = _text()
    speed: float | None = _quantity("rad/s", "rpm", key=True)
    torque: float | None = _quantity("N*m", "N*m", key=True)

    needed: ClassVar[tuple[str, ...]] = ("part", "speed", "torque")


@dataclass(frozen=True)
class WireRow(CatalogueRow):
    """A stock size of spring wire, with its strength if listed."""

    family: ClassVar[str] = "wire_diameters"
    series: str = _text(key=True)
    material: str = _text()
    grade: str = _text()
    system: str = _text(choices=("inch", "metric"))
    gauge: str = _text()
    diameter: float | None = _quantity("m", "mm", key=True)
    nominal_size: float | None = _quantity("m", "in")
    min_tensile_strength: float | None = _quantity("Pa", "MPa")
    max_tensile_strength: float | None = _quantity("Pa", "MPa")
    diameter_tolerance: float | None = _quantity("m", "mm")

    needed: ClassVar[tuple[str, ...]] = ("series", "diameter")


@dataclass(frozen=True)
class MaterialRow(CatalogueRow):
    """One property of one wire material from one source; percentages are fractions of the tensile strength."""

    family: ClassVar[str] = "wire_materials"
    material: str = _text(key=True)
    name_as_published: str = _text()
    standard: str = _text()
    record: str = _text(key=True)
    min_diameter: float | None = _quantity("m", "mm")
    max_diameter: float | None = _quantity("m", "mm")
    strength_at_1_mm: float | None = _quantity("Pa", "MPa")
    strength_exponent: float | None = _quantity("1", "1", zero=True)
    log_law_strength_at_1_mm: float | None = _quantity("Pa", "MPa")
    log_law_drop_per_decade: float | None = _quantity("Pa", "MPa", zero=True)
    strength_cap: float | None = _quantity("Pa", "MPa")
    elastic_modulus: float | None = _quantity("Pa", "GPa")
    shear_modulus: float | None = _quantity("Pa", "GPa")
    elastic_limit_tension_low: float | None = _quantity("1", "%")
    elastic_limit_tension_high: float | None = _quantity("1", "%")
    elastic_limit_torsion_low: float | None = _quantity("1", "%")
    elastic_limit_torsion_high: float | None = _quantity("1", "%")
    density: float | None = _quantity("kg/m^3", "kg/m^3")
    static_bending_limit: float | None = _quantity("1", "%")
    static_bending_limit_not_relieved: float | None = _quantity("1", "%")
    repeated_bending_limit_1e5: float | None = _quantity("1", "%")
    repeated_bending_limit_1e6: float | None = _quantity("1", "%")
    relative_cost: float | None = _quantity("1", "1")

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
    part: str = _text(key=True)
    vendor: str = _text()
    product_line: str = _text()
    variant: str = _text()
    items: str = _text()
    gear_ratio: float | None = _quantity("1", "1", key=True)
    voltage: float | None = _quantity("V", "V")
    no_load_speed: float | None = _quantity("rad/s", "rpm", key=True)
    stall_torque: float | None = _quantity("N*m", "N*m", key=True)
    stall_current: float | None = _quantity("A", "A")
    no_load_current: float | None = _quantity("A", "A")
    mass: float | None = _quantity("kg", "g")
    torque_limit: float | None = _quantity("N*m", "N*m")
    speed_tolerance: float | None = _quantity("1", "%", zero=True)
    current_tolerance: float | None = _quantity("1", "%", zero=True)
    resistance: float | None = _quantity("ohm", "ohm")
    inductance: float | None = _quantity("H", "mH")
    rotor_inertia: float | None = _quantity("kg*m^2", "kg*m^2")
    speed_at_best_efficiency: float | None = _quantity("rad/s", "rpm")
    torque_at_best_efficiency: float | None = _quantity("N*m", "N*m")
    current_at_best_efficiency: float | None = _quantity("A", "A")
    size: str = _text()
    shaft_size: float | None = _quantity("m", "mm")
    basis: str = _text()

    needed: ClassVar[tuple[str, ...]] = (
        "part", "gear_ratio", "voltage", "no_load_speed", "stall_torque", "stall_current", "no_load_current", "mass",
    )  # fmt: skip

    @property
    def interpolated(self) -> bool:
        """Whether its values lie between found rows: ``basis`` is the word ``derived``, before any remark on it."""
        return self.basis.partition(";")[0].strip() == INTERPOLATED

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
