"""A torsion spring as a result: what it is, what it does, which limits it breaks."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from synth.parts.coil_angle import Convention
from synth.spring.arms import arm_force, arm_share
from synth.spring.fatigue import Life
from synth.spring.winding import WindingTolerance, mandrel_diameter, stress_relief, turns_on_mandrel
from synth.units import quantity


@dataclass(frozen=True)
class SpringLimits:
    """What a spring must keep to; lengths in m, None where there is no limit.

    Parameters
    ----------
    arbor_diameter
        shaft inside the coil.
    arbor_gap
        part of the wound inside diameter that stays free around the arbor; vendors ask for about 10 %.
    min_inside_diameter
        of the free coil.
    max_outer_diameter
        of the coil when it is widest: free, or opened by ``opening_travel``.
    max_body_length
        of the coil at full travel, when it is longest.
    index_range
        D/d: below 4 the wire cracks when wound, above 20 the coil does not hold its diameter (EN 13906-3).
    min_coils, max_coils
        of the body. With less than 2 the theory does not hold (EN 13906-3).
    safety
        yield over the allowed stress at full travel.
    cycles, fatigue_safety
        how often it is to turn, 1e5 or 1e6 at most, and strength over stress for that; None: not asked.
    bend_radius
        inside radius of the bend where a radial or axial arm leaves the coil; None: as much as the wire's diameter.
    """

    arbor_diameter: float | None = None
    arbor_gap: float = 0.10
    min_inside_diameter: float | None = None
    max_outer_diameter: float | None = None
    max_body_length: float | None = None
    index_range: tuple[float, float] = (4.0, 20.0)
    min_coils: float = 2.0
    max_coils: float = 30.0
    safety: float = 1.1
    cycles: float | None = None
    fatigue_safety: float = 1.0
    bend_radius: float | None = None

    def least_wound_inside(self) -> float | None:
        """Wound inside diameter that leaves the arbor its gap, m."""
        return None if self.arbor_diameter is None else self.arbor_diameter / (1.0 - self.arbor_gap)


@dataclass(frozen=True)
class Violation:
    """A limit that a spring does not keep; ``excess`` is how many times the limit it has (or the limit it)."""

    limit: str
    excess: float
    text: str


@dataclass(frozen=True)
class SpringDesign:
    """A torsion spring and what it does. SI; angles in rad; ``travel`` winds the coil, ``opening_travel`` opens it.

    ``rate`` is the one that moments and stresses are reckoned with. ``free_travel`` is from rest to yield of the inner
    fibre, no safety in it. ``arm_stress`` is where an arm meets the coil, ``bend_radius`` that of its bend (None:
    tangent arms have none). ``count`` such springs stand in parallel; every number is of one of them.
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
    free_travel: float
    body_length: float
    wound_body_length: float
    outer_diameter: float
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
    violations: tuple[Violation, ...] = ()
    count: int = 1
    hand: str = "right"

    @property
    def feasible(self) -> bool:
        """Whether it keeps all limits."""
        return not self.violations

    @property
    def safety(self) -> float:
        """Yield stress over the stress at full travel."""
        return self.yield_stress / self.stress if self.stress > 0.0 else math.inf

    @property
    def arbor_clearance(self) -> float | None:
        """Wound inside diameter less the arbor, m."""
        return None if self.arbor_diameter is None else self.wound_inside_diameter - self.arbor_diameter

    @property
    def mandrel_diameter(self) -> float:
        """Where to begin, m: the coil that is wound on it springs back to the wanted one."""
        return mandrel_diameter(self.mean_diameter, self.wire_diameter, self.elastic_modulus, self.tensile_strength)

    @property
    def mandrel_turns(self) -> float:
        """Turns on the mandrel that leave the coils of the body."""
        return turns_on_mandrel(self.mean_diameter, self.wire_diameter, self.body_coils, self.mandrel_diameter)

    @property
    def volume(self) -> float:
        """Cylinder that the coil needs, m^3: widest times longest."""
        return math.pi / 4.0 * self.outer_diameter**2 * self.wound_body_length

    @property
    def warnings(self) -> tuple[str, ...]:
        """What to know before winding it, though no limit is broken."""
        found: list[str] = []
        if self.strength_basis == "law":
            found.append(f"strength by a fitted law, no maker's table has {self.wire_diameter * 1e3:.4g} mm wire")
        if self.life is not None and self.safety >= 1.0 and self.life.factor_1e5 < 1.0:
            found.append(
                f"it may break before 100 000 full turns: strength over stress is {self.life.factor_1e5:.2f} (Gerber)"
            )
        if self.body_coils < 2.0:
            found.append(f"{self.body_coils:.3g} coils are under the 2 from which the theory holds (EN 13906-3)")
        return tuple(found)

    def as_json(self) -> dict[str, Any]:
        """Every number beside its unit, for a result file."""
        lengths = ("wire_diameter", "mean_diameter", "outer_diameter", "inside_diameter", "wound_inside_diameter",
                   "body_length", "wound_body_length", "wire_length", "arbor_diameter", "arbor_clearance")  # fmt: skip
        stresses = ("stress", "allowed_stress", "yield_stress", "tensile_strength")
        angles = ("included_angle", "travel", "opening_travel", "free_travel")
        rates = ("rate", "rate_bending_form", "rate_friction_form")
        ratios = ("body_coils", "active_coils", "index", "curvature_factor")
        units = {**dict.fromkeys(lengths, "mm"), **dict.fromkeys(stresses, "MPa"), **dict.fromkeys(angles, "deg")}
        units |= {**dict.fromkeys(rates, "N*m/rad"), **dict.fromkeys(ratios, "1")}
        units |= {"elastic_modulus": "GPa", "moment": "N*m", "mass": "g", "energy": "J"}
        values = {name: getattr(self, name) for name in units}
        numbers = {name: quantity(value, units[name]) for name, value in values.items() if value is not None}
        if math.isfinite(self.safety):
            numbers["safety"] = quantity(self.safety, "1")
        return {
            "material": self.material,
            "count": self.count,
            "leg_convention": self.convention,
            "hand": self.hand,
            "leg_lengths": [quantity(length, "mm") for length in self.leg_lengths],
            **numbers,
            **self._lasting(),
            "stress_relief": stress_relief(self.material),
            "strength_basis": self.strength_basis,
            "strength_source": self.strength_source,
            "yield_source": self.yield_source,
            "violations": [violation.text for violation in self.violations],
            "warnings": list(self.warnings),
        }

    def _lasting(self) -> dict[str, Any]:
        """Tolerances, fatigue, arms and mandrel, beside their units."""
        plus, force = self.tolerance, arm_force(self.moment, self.leg_lengths[0])
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
                **({} if force is None else {"force": quantity(force, "N")}),
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


@dataclass(frozen=True)
class SpringTask:
    """Travel, legs and hand of a spring: what holds for every candidate."""

    travel: float
    opening_travel: float = 0.0
    leg_lengths: tuple[float, float] = (0.0, 0.0)
    convention: Convention = "tangent"
    limits: SpringLimits = field(default_factory=SpringLimits)
    hand: str = "right"
