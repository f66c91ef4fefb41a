"""A torsion spring as a result: its dimensions, its properties, the limits that it violates."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from synth.parts.coil_angle import Convention
from synth.parts.coil_rate import RATE_FORMULA, RateForm
from synth.remarks import decisive, remarks_json
from synth.spring.arms import arm_force, arm_share
from synth.spring.codes import OPENING, CodeCheck, dynamic_factor
from synth.spring.din_2194 import SOURCE, STANDARD, GradeTolerance, grade_tolerances, suitable_grade
from synth.spring.fatigue import Life
from synth.spring.loose_test import LoadPoint, LooseTest, arms_to_ends, load_points
from synth.spring.space import cylinder
from synth.spring.spring_task import Violation
from synth.spring.unit_text import MeasuredText, UnitText
from synth.spring.winding import WindingTolerance, mandrel_diameter, stress_relief, turns_on_mandrel
from synth.spring.wire_load import PeakRatios, WireLoad
from synth.units import quantity

WIRE_ALLOWANCE = 0.060  # m of extra wire per spring: 30 mm at each end to hold in the winder and to trim
DESIGN_LIFE = 1e5  # full-travel cycles; the default requirement, dropped if no spring reaches it
# From this number of coils on, the ends and their tolerance hardly matter. With two coils the attachment of the arms
# takes part of one, and a tolerance of 10 deg on the free angle is 1.4 % of the rate; with three coils it is 0.9 %.
FEWEST_COILS = 3.0


@dataclass(frozen=True)
class SpringDesign:
    """A torsion spring and its properties. SI units, angles in rad.

    ``travel`` winds the coil, ``opening_travel`` opens it. Moments and stresses are computed with ``rate``;
    ``rate_form`` is the formula by which it was designed, ``rate_factor`` that of wound samples on it, which is in
    ``rate`` and in neither ``rate_..._form``. ``moment`` is the torque at the winding travel; in a spring
    with clamped arms of the free length ``clamped_arm`` (None: not clamped) the wire bears more, by ``peaks`` at the
    ends of both travels. ``stress`` is that of the coil at the winding travel, ``opening_stress`` that at the opening
    travel, where less is allowed (``codes.OPENING``). ``codes`` has the checks by other codes.
    ``widest_outer_diameter`` is that of the coil opened by the opening travel.
    ``surge_frequency`` is the lowest natural frequency of the coils, Hz.
    ``arm_stress`` is the largest stress in an arm, ``bend_radius`` the radius of its bend (None for tangent arms).
    ``pitch`` is the axial advance per coil over the wire diameter. ``count`` such springs act in parallel; every number
    is for one of them. ``loose`` is the test of the spring for a joint that clamps its arms, where ``rate`` is that of
    the joint; None: ``rate`` is the one with the loads at the ends of the legs.
    """

    material: str
    wire_diameter: float
    mean_diameter: float
    body_coils: float
    active_coils: float
    included_angle: float
    convention: Convention
    leg_lengths: tuple[float, float]
    elastic_modulus: float
    rate: float
    rate_bending_form: float
    rate_friction_form: float
    index: float
    curvature_factor: float
    tensile_strength: float
    strength_basis: str
    strength_source: str
    yield_stress: float
    yield_source: str
    allowed_stress: float
    travel: float
    opening_travel: float
    moment: float
    stress: float
    body_length: float
    wound_body_length: float
    widest_outer_diameter: float
    inside_diameter: float
    wound_inside_diameter: float
    arbor_diameter: float | None
    wire_length: float
    mass: float
    energy: float
    tolerance: WindingTolerance
    life: Life | None
    arm_stress: float
    bend_radius: float | None
    opening_stress: float = 0.0
    allowed_opening_stress: float = math.inf
    surge_frequency: float = math.inf
    codes: tuple[CodeCheck, ...] = ()
    rate_form: RateForm = "bending"
    spring_back: float = 1.0
    rate_factor: float = 1.0
    violations: tuple[Violation, ...] = ()
    count: int = 1
    hand: str = "right"
    clamped_arm: float | None = None
    peaks: tuple[PeakRatios, PeakRatios] = (PeakRatios(), PeakRatios())
    pitch: float = 1.0
    loose: LooseTest | None = None

    @property
    def outer_diameter(self) -> float:
        """Outer diameter of the free coil, m."""
        return self.mean_diameter + self.wire_diameter

    @property
    def arm_lengths(self) -> tuple[float, float]:
        """Length of each arm to its end, m: past the load at ``leg_lengths``, or in a joint, which clamps it, these."""
        clamped = self.loose is not None or self.clamped_arm is not None
        return self.leg_lengths if clamped else arms_to_ends(self.wire_diameter, self.leg_lengths)

    @property
    def test(self) -> LooseTest:
        """How to measure the loose spring, with the rate to expect."""
        return self.loose or LooseTest(self.leg_lengths, self.active_coils, self.rate)

    @property
    def calculated_rate(self) -> float:
        """Rate of these sizes by the formula of the design, N m/rad, with the factor of wound samples."""
        formula = self.rate_bending_form if self.rate_form == "bending" else self.rate_friction_form
        return formula * self.rate_factor

    @property
    def load(self) -> WireLoad:
        """The load of the wire at any angle."""
        return WireLoad(self.rate, self.wire_diameter, self.mean_diameter, self.body_coils, self.clamped_arm)

    @cached_property
    def free_travel(self) -> float:
        """Angle from the free position to yield when the coil winds, without a safety factor.

        Of the coil's inner fibre, or of the bends of the arms if these yield first.
        """
        return min(self.load.angle(self.yield_stress), self.arms_angle(self.yield_stress))

    @cached_property
    def free_opening_travel(self) -> float:
        """The same when the coil opens: smaller, because less stress is allowed (``codes.OPENING``)."""
        return min(self.load.angle(OPENING * self.yield_stress, -1), self.arms_angle(self.yield_stress))

    def arms_angle(self, stress: float) -> float:
        """Angle from the free position, rad, at which the bends of the arms bear this stress, Pa; inf without bends."""
        reached = max(self.travel, self.opening_travel)
        if self.bend_radius is None or self.arm_stress <= 0.0:
            return math.inf
        return reached * stress / self.arm_stress

    @property
    def peak_moment(self) -> float:
        """Largest bending moment in the wire over both travels, N m."""
        winding, opening = self.peaks
        return self.rate * max(self.travel * winding.coil, self.opening_travel * opening.coil)

    @property
    def cut_length(self) -> float:
        """Length of wire to cut, and to order, for one spring, m."""
        return self.wire_length + WIRE_ALLOWANCE

    @property
    def feasible(self) -> bool:
        """Whether the spring keeps all limits."""
        return not self.violations

    @property
    def opening_moment(self) -> float:
        """Torque at the opening travel, N m."""
        return self.rate * self.opening_travel

    @property
    def largest_moment(self) -> float:
        """The larger torque of both travels, N m."""
        return max(self.moment, self.opening_moment)

    @property
    def use(self) -> float:
        """Largest share of an allowed stress: in the coil at the ends of both travels, and in the arms' bends."""
        in_bends = 0.0 if self.bend_radius is None else self.arm_stress / self.allowed_stress
        return max(self.stress / self.allowed_stress, self.opening_stress / self.allowed_opening_stress, in_bends)

    @property
    def safety(self) -> float:
        """Least ratio of yield stress and stress: in the coil at the ends of both travels, and in the arms' bends."""
        stresses = [self.stress, self.opening_stress / OPENING]
        if self.bend_radius is not None:  # a straight arm has less stress than the coil
            stresses.append(self.arm_stress)
        return self.yield_stress / max(stresses) if max(stresses) > 0.0 else math.inf

    @property
    def arbor_clearance(self) -> float | None:
        """Diametral clearance to the arbor at full travel, m, ``D' - d - D_arbor`` (Shigley eq. 10-54)."""
        return None if self.arbor_diameter is None else self.wound_inside_diameter - self.arbor_diameter

    @property
    def mandrel_diameter(self) -> float:
        """Diameter of the mandrel for the first trial coil, m: its coil springs back to the mean diameter.

        The flow stress is the tensile strength times the factor from wound samples (``spring_back``).
        """
        flow = self.spring_back * self.tensile_strength
        return mandrel_diameter(self.mean_diameter, self.wire_diameter, self.elastic_modulus, flow)

    @property
    def stress_range_en(self) -> float:
        """Stress range over the whole travel with the factor of EN 13906-3 for varying load, Pa."""
        winding, opening = self.peaks
        moment = self.rate * (self.travel * winding.coil + self.opening_travel * opening.coil)
        return dynamic_factor(self.index) * 32.0 * moment / (math.pi * self.wire_diameter**3)

    @property
    def load_points(self) -> tuple[LoadPoint, LoadPoint]:
        """The two angles at which to measure the loose spring's torque, T1 and T2, with its tolerance."""
        return load_points(self.test.rate, self.travel, self.tolerance.rate)

    @property
    def mandrel_turns(self) -> float:
        """Turns to wind on the mandrel; spring-back leaves the body coils."""
        return turns_on_mandrel(self.mean_diameter, self.wire_diameter, self.body_coils, self.mandrel_diameter)

    @property
    def volume(self) -> float:
        """Volume of the cylinder that the coil needs, m^3: at its widest and its longest."""
        return cylinder(self.widest_outer_diameter, self.wound_body_length)

    @property
    def short_life(self) -> str:
        """What the spring may do before ``DESIGN_LIFE``; empty if it lasts, yields at once, or its life is unknown."""
        if self.life is None or self.safety < 1.0 or self.life.factor_1e5 >= 1.0:
            return ""
        return f"may break before 100 000 full turns: strength over stress is {self.life.factor_1e5:.2f} (Gerber)"

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings that do not violate a limit, as sentences."""
        found: list[str] = []
        if self.strength_basis == "law":
            wire = MeasuredText(self.wire_diameter, "m")
            found.append(UnitText("strength by a fitted law: no maker's table lists ", wire, " wire"))
        if self.short_life:
            found.append(decisive(f"it {self.short_life}"))
        low = [check for check in self.codes if check.safety < 1.0 <= self.safety]
        for check in low:
            borne, allowed = (
                MeasuredText(value, "Pa", ".0f", other)
                for value, other in ((check.stress, check.allowed), (check.allowed, check.stress))
            )
            found.append(UnitText(f"{check.code} allows ", allowed, ", its stress formula gives ", borne))
        if self.body_coils < 2.0:
            found.append(f"{self.body_coils:.3g} coils; the theory holds for 2 or more (EN 13906-3)")
        return tuple(found)

    def as_json(self) -> dict[str, Any]:
        """Every number with its unit, for a result file."""
        lengths = ("wire_diameter", "mean_diameter", "outer_diameter", "widest_outer_diameter", "inside_diameter",
                   "wound_inside_diameter", "body_length", "wound_body_length", "wire_length", "cut_length",
                   "arbor_diameter", "arbor_clearance")  # fmt: skip
        stresses = ("stress", "allowed_stress", "yield_stress", "tensile_strength")
        angles = ("included_angle", "travel", "opening_travel", "free_travel", "free_opening_travel")
        rates = ("rate", "rate_bending_form", "rate_friction_form")
        ratios = ("body_coils", "active_coils", "index", "curvature_factor")
        units = {**dict.fromkeys(lengths, "mm"), **dict.fromkeys(stresses, "MPa"), **dict.fromkeys(angles, "deg")}
        units |= {**dict.fromkeys(rates, "N*m/rad"), **dict.fromkeys(ratios, "1")}
        units |= dict.fromkeys(("opening_stress", "stress_range_en"), "MPa")
        units |= {"surge_frequency": "Hz", "elastic_modulus": "GPa", "moment": "N*m", "mass": "g", "energy": "J"}
        if self.clamped_arm is not None:
            units["peak_moment"] = "N*m"
        if self.opening_travel > 0.0:
            units["opening_moment"] = "N*m"
        values = {name: getattr(self, name) for name in units}
        numbers = {name: quantity(value, units[name]) for name, value in values.items() if value is not None}
        if self.rate_factor != 1.0:
            numbers["rate_factor"] = quantity(self.rate_factor, "1")
        if math.isfinite(self.safety):
            numbers["safety"] = quantity(self.safety, "1")
        if math.isfinite(self.allowed_opening_stress):
            numbers["allowed_opening_stress"] = quantity(self.allowed_opening_stress, "MPa")
        return {
            "material": self.material,
            "count": self.count,
            "leg_convention": self.convention,
            "hand": self.hand,
            "leg_lengths": [quantity(length, "mm") for length in self.leg_lengths],
            "arm_lengths": [quantity(length, "mm") for length in self.arm_lengths],
            **numbers,
            **self._lasting(),
            "rate_formula": RATE_FORMULA[self.rate_form],
            "codes": [check.as_json() for check in self.codes],
            "test": self.test.as_json(self.travel),
            "load_points": [point.as_json() for point in self.load_points],
            "grade": self._grade(),
            "stress_relief": stress_relief(self.material),
            "strength_basis": self.strength_basis,
            "strength_source": self.strength_source,
            "yield_source": self.yield_source,
            "violations": [violation.text for violation in self.violations],
            **remarks_json(self.warnings),
        }

    @property
    def grades(self) -> tuple[GradeTolerance, ...]:
        """Tolerances of the three quality grades of DIN 2194; empty outside its scope."""
        return grade_tolerances(
            self.material, self.wire_diameter, self.mean_diameter, self.body_coils, self.arm_lengths
        )

    @property
    def grade(self) -> GradeTolerance | None:
        """The quality grade to order: the coarsest that holds the free angle's tolerance, or the finest."""
        return suitable_grade(self.grades, self.tolerance.free_angle)

    def _grade(self) -> dict[str, Any]:
        chosen = self.grade
        if chosen is None:
            return {"standard": STANDARD, "source": "outside the scope of the standard"}
        return {"standard": STANDARD, **chosen.as_json(), "source": SOURCE}

    def _lasting(self) -> dict[str, Any]:
        """Tolerances, fatigue, arms and mandrel, with their units."""
        plus, force = self.tolerance, self.load.axis_force(self.travel, self.opening_travel)
        pressed = arm_force(self.largest_moment, self.leg_lengths[0]) if self.clamped_arm is None else None
        written: dict[str, Any] = {
            "tolerance": {
                "wire_diameter": quantity(plus.wire_diameter, "mm"),
                "mean_diameter": quantity(plus.mean_diameter, "mm"),
                "body_coils": quantity(plus.coils, "1"),
                "rate": quantity(plus.rate, "percent"),
                "free_angle": quantity(plus.free_angle, "deg"),
            },
            "arms": {
                "stress": quantity(self.arm_stress, "MPa"),
                "share_of_angle": quantity(arm_share(self.body_coils, self.active_coils), "1"),
                **({} if pressed is None else {"force": quantity(pressed, "N")}),
                **({} if force is None else {"axis_force": quantity(force, "N")}),
                **({} if self.bend_radius is None else {"bend_radius": quantity(self.bend_radius, "mm")}),
            },
            "mandrel": {
                "diameter": quantity(self.mandrel_diameter, "mm"),
                "turns": quantity(self.mandrel_turns, "1"),
            },
        }
        if self.life is not None:
            written["fatigue"] = {
                "stress_amplitude": quantity(self.life.amplitude, "MPa"),
                "stress_mean": quantity(self.life.mean, "MPa"),
                **{
                    name: quantity(value, "1")
                    for name, value in (("safety_1e5", self.life.factor_1e5), ("safety_1e6", self.life.factor_1e6))
                    if math.isfinite(value)
                },
                "source": self.life.source,
            }
        return written
