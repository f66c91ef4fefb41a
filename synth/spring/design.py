"""The spring to wind: stock wire and coil count searched, mean diameter solved from the rate; or why there is none.

For one wire the rate fixes D N, so wire length and mass depend on the wire alone; the split between diameter and
coils trades room against arbor and index. The search is over every stock size and every whole number of coils (the
fraction follows from the included angle), which is exhaustive: some thousand candidates.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any, Literal

from synth.errors import UserError
from synth.parts.catalogs import Catalogue
from synth.parts.coil_angle import CONVENTIONS, Convention, coil_fraction
from synth.parts.coil_rate import RATE_FORMULA, RateForm, coil_product, mean_diameter_for
from synth.parts.wire import WireMaterial
from synth.spring.calibration import UNCALIBRATED, WindingCalibration
from synth.spring.codes import OPENING
from synth.spring.evaluate import check_spring, travel_limit
from synth.spring.spring_result import DESIGN_LIFE, FEWEST_COILS, SpringDesign, SpringLimits, SpringTask
from synth.units import quantity

Objective = Literal["mass", "space", "life"]

ROOM = frozenset({"outer_diameter", "body_length"})  # limits that more room in the joint would lift
OTHER_MATERIALS = ("oil tempered", "chrome vanadium", "chrome silicon")  # sold thicker or stronger than music wire
MOST_IN_PARALLEL = 4  # springs side by side: what a joint has room for
# Times the least mass from which lightness decides. The lightest wire that holds does so only as the widest coil of the
# fewest turns, where curvature costs least: a tenth more wire often halves its diameter.
NEARLY_AS_LIGHT = 1.25
SAME_WIRE = 1e-6  # relative, of diameters that are one size
ENDLESS = 1.5  # strength over stress at 1e6 cycles from which a spring does not last any longer
LEAST_TRAVEL = math.radians(1.0)  # rad; a wish for less is most likely a mistake of units


@dataclass(frozen=True)
class SpringWish:
    """What a spring is to do; SI, angles in rad.

    Parameters
    ----------
    rate
        N m/rad.
    travel
        largest angle from rest in the sense that winds the coil.
    opening_travel
        largest angle from rest the other way.
    included_angle, convention
        between the legs of the free spring; sets the fraction of the coils.
    leg_lengths
        each straight leg up to where the load acts.
    material, system
        wire material; ``inch``, ``metric`` or None for both.
    hand
        ``right`` or ``left``, see ``winding.hand_for``.
    rate_form
        formula of the rate: ``bending`` (64) or ``friction`` (10.8 a turn).
    calibration
        what wound samples said of this wire and winder.
    objective
        ``mass``: of those nearly as light as the lightest the one whose diameter and length are least; ``space``:
        smallest cylinder, then lightest; ``life``: strongest against fatigue, then lightest.
    held_wire
        m; a spring of this wire is taken where one keeps all limits and lasts, though another may be lighter.
    """

    rate: float
    travel: float
    opening_travel: float = 0.0
    included_angle: float = math.radians(90.0)
    convention: Convention = "tangent"
    leg_lengths: tuple[float, float] = (0.025, 0.025)
    material: str = "music wire"
    system: str | None = None
    objective: Objective = "mass"
    limits: SpringLimits = field(default_factory=SpringLimits)
    hand: str = "right"
    rate_form: RateForm = "bending"
    calibration: WindingCalibration = UNCALIBRATED
    held_wire: float | None = None

    @property
    def task(self) -> SpringTask:
        """The part that holds for every candidate."""
        return SpringTask(
            self.travel,
            self.opening_travel,
            self.leg_lengths,
            self.convention,
            self.limits,
            self.hand,
            self.rate_form,
            self.calibration,
        )


@dataclass(frozen=True)
class Nearest:
    """A spring that can be made, though it is not all that was asked: ``kind`` and ``text`` say what gives way."""

    kind: Literal["more_room", "parallel", "smaller_travel", "other_material"]
    text: str
    design: SpringDesign

    def as_json(self) -> dict[str, Any]:
        """The entry in a result."""
        return {"kind": self.kind, "text": self.text, "make": self.design.as_json()}


@dataclass(frozen=True)
class SpringResult:
    """The best spring and the next best wires, or what stands in the way and the nearest that can be made.

    ``binding``: the limits in the way, in words with their numbers; empty where there is a spring. ``lasting``: where
    the best does not last ``DESIGN_LIFE``, the nearest springs that do, with the room that they take. ``notes``: why
    the best has few coils, or does not last.
    """

    wish: SpringWish
    best: SpringDesign | None
    alternatives: tuple[SpringDesign, ...]
    binding: tuple[str, ...]
    nearest: tuple[Nearest, ...]
    lasting: tuple[Nearest, ...] = ()
    notes: tuple[str, ...] = ()

    def as_json(self) -> dict[str, Any]:
        """For ``spring.json``."""
        return {
            "format": "synth/spring/1",
            "wanted": {
                "rate": quantity(self.wish.rate, "N*m/rad"),
                "travel": quantity(self.wish.travel, "deg"),
                "opening_travel": quantity(self.wish.opening_travel, "deg"),
                "included_angle": quantity(self.wish.included_angle, "deg"),
                "leg_convention": self.wish.convention,
                "objective": self.wish.objective,
                "hand": self.wish.hand,
                "material": self.wish.material,
                "rate_formula": RATE_FORMULA[self.wish.rate_form],
            },
            "make": None if self.best is None else self.best.as_json(),
            "alternatives": [design.as_json() for design in self.alternatives],
            "binding": list(self.binding),
            "nearest": [item.as_json() for item in self.nearest],
            "design_life": {
                **quantity(self.wish.limits.cycles or DESIGN_LIFE, "1"),
                "asked": self.wish.limits.cycles is not None,
                "kept": None if self.best is None else lasts(self.best, self.wish.limits),
            },
            "lasting": [item.as_json() for item in self.lasting],
            "notes": list(self.notes),
        }


def design_spring(wish: SpringWish, catalogue: Catalogue | None = None, n_alternative: int = 4) -> SpringResult:
    """Find the spring to wind.

    Raises
    ------
    UserError
        If the wish is impossible in itself (a rate or travel that is not positive), with every such mistake at once.
    """
    _require_sense(wish)
    catalogue = catalogue or Catalogue.load()
    material = catalogue.find_material(wish.material)
    if (held := _of_held_wire(wish, material)) is not None:
        return SpringResult(wish, held, (), (), ())
    found = list(candidates(wish, material))
    good = [design for design in found if design.feasible]
    if good:
        kept, notes = _preferred(good, found, wish)
        best, *others = _distinct(_ranked(kept, wish.objective))
        lasting = () if lasts(best, wish.limits) else tuple(_lasting(wish, material, catalogue))
        return SpringResult(wish, best, tuple(others[:n_alternative]), (), (), lasting, notes)
    nearest = _nearest(found, wish, material, catalogue)
    return SpringResult(wish, None, (), tuple(_binding(found, wish)), tuple(nearest))


def _of_held_wire(wish: SpringWish, material: WireMaterial) -> SpringDesign | None:
    """The spring of the wire that is held on to, where it keeps every limit, lasts and has enough coils."""
    if wish.held_wire is None:
        return None
    kept = [
        design
        for design in candidates(wish, material, wish.held_wire)
        if design.feasible and lasts(design, wish.limits) and design.body_coils >= FEWEST_COILS
    ]
    return next(iter(_ranked(kept, wish.objective)), None)


def lasts(design: SpringDesign, limits: SpringLimits) -> bool:
    """Whether the spring lasts as many full turns as asked, or as it is designed for where nothing is asked."""
    cycles = DESIGN_LIFE if limits.cycles is None else limits.cycles
    return design.life is not None and design.life.factor(cycles) >= limits.fatigue_safety


def _preferred(
    good: list[SpringDesign], found: list[SpringDesign], wish: SpringWish
) -> tuple[list[SpringDesign], tuple[str, ...]]:
    """Of springs that keep the limits those that last, of these those of three coils or more; why not, where not."""
    notes = []
    lasting = [design for design in good if lasts(design, wish.limits)]
    if not lasting and good[0].life is None:
        notes.append(f"nothing is known of {good[0].material} wire in fatigue: no design life can be kept")
    elif not lasting:
        notes.append(f"no spring within the limits lasts {DESIGN_LIFE:.0f} full turns; this one holds them statically")
    good = lasting or good
    many = [design for design in good if design.body_coils >= FEWEST_COILS]
    if many or wish.limits.max_coils < FEWEST_COILS:
        return many or good, tuple(notes)
    stiff = [d for d in found if d.body_coils >= FEWEST_COILS and (not lasting or lasts(d, wish.limits))]
    nearest = min(stiff, key=_worst, default=None)
    why = (
        "no stock wire gives the rate with a fitting spring index"
        if nearest is None
        else f"the nearest ({_describe(nearest)}) has " + "; ".join(v.text for v in nearest.violations)
    )
    return good, (*notes, f"fewer than {FEWEST_COILS:.0f} coils, since with more {why}")


def _lasting(wish: SpringWish, material: WireMaterial, catalogue: Catalogue) -> list[Nearest]:
    """The nearest springs that last the design life: what gives way instead is the room, their number or the travel."""
    lasting = replace(wish, limits=replace(wish.limits, cycles=DESIGN_LIFE))
    return _nearest(list(candidates(lasting, material)), lasting, material, catalogue)


def _nearest(
    found: list[SpringDesign], wish: SpringWish, material: WireMaterial, catalogue: Catalogue
) -> list[Nearest]:
    return [
        *_more_room(found),
        *_parallel(wish, material),
        *_smaller_travel(found, wish, material),
        *_other_material(wish, material, catalogue),
    ]


def candidates(wish: SpringWish, material: WireMaterial, only: float | None = None) -> Iterator[SpringDesign]:
    """Every spring of stock wire with the wanted rate and included angle, whether it keeps the limits or not.

    ``only``: of wire of this diameter, m. Index and coil limits are kept already: outside them no formula holds.
    """
    limits = wish.limits
    fraction = coil_fraction(wish.included_angle, wish.convention)
    for row in material.stock(wish.system):
        assert row.diameter is not None
        wire = row.diameter
        if only is not None and not math.isclose(wire, only, rel_tol=SAME_WIRE):
            continue
        modulus = material.properties(wire).elastic_modulus * wish.calibration.rate
        product = coil_product(modulus, wire, wish.rate, wish.rate_form)
        for whole in range(math.floor(limits.max_coils) + 1):
            coils = whole + fraction
            if not limits.min_coils <= coils <= limits.max_coils:
                continue
            mean = mean_diameter_for(product, coils, wish.leg_lengths)
            if limits.index_range[0] <= mean / wire <= limits.index_range[1]:
                yield check_spring(material, wire, mean, coils, wish.task)


def _require_sense(wish: SpringWish) -> None:
    """Refuse what no spring could mean."""
    wrong: list[str] = []
    if not (math.isfinite(wish.rate) and wish.rate > 0.0):
        wrong.append(f"the rate must be above 0, not {wish.rate:.4g} N*m/rad")
    if not (math.isfinite(wish.travel) and wish.travel > 0.0):
        wrong.append(f"the travel must be above 0, not {math.degrees(wish.travel):.4g} deg")
    if not (math.isfinite(wish.opening_travel) and wish.opening_travel >= 0.0):
        wrong.append(f"the opening travel must be 0 or more, not {math.degrees(wish.opening_travel):.4g} deg")
    if min(wish.leg_lengths) < 0.0:
        wrong.append("a leg's length must be 0 or more")
    if wish.convention not in CONVENTIONS:
        wrong.append(f'"{wish.convention}" is no leg convention; choose one of {", ".join(CONVENTIONS)}')
    if wish.limits.cycles is not None and not 1.0 <= wish.limits.cycles <= 1e6:
        wrong.append(f"fatigue is known up to 1e6 cycles, not for {wish.limits.cycles:.4g}")
    if wish.limits.safety < 1.0:
        wrong.append(f"a safety of {wish.limits.safety:.4g} would let the spring yield; it must be 1 or more")
    if not 0.0 <= wish.limits.arbor_gap < 1.0:
        wrong.append(f"the arbor gap is a part of the inside diameter, 0 to below 1, not {wish.limits.arbor_gap:.4g}")
    if wrong:
        raise UserError("; ".join(wrong))


def _ranked(designs: list[SpringDesign], objective: Objective) -> list[SpringDesign]:
    if objective == "life":
        return sorted(designs, key=lambda design: (-lasting(design), design.mass, design.volume))
    if objective == "space":
        return sorted(designs, key=lambda design: (design.volume, design.mass))
    enough = NEARLY_AS_LIGHT * min((design.mass for design in designs), default=0.0)
    light = sorted((d for d in designs if d.mass <= enough), key=lambda d: (_longest(d), d.mass))
    return light + sorted((d for d in designs if d.mass > enough), key=lambda d: (d.mass, d.volume))


def _longest(design: SpringDesign) -> float:
    """Diameter or length of the coil, whichever is more, m."""
    return max(design.outer_diameter, design.wound_body_length)


def lasting(design: SpringDesign) -> float:
    """What ``life`` goes by: strength over stress at 1e6 cycles, or at yield where no fatigue is known of the wire."""
    return min(ENDLESS, design.safety if design.life is None else design.life.factor_1e6)


def _distinct(ranked: list[SpringDesign]) -> list[SpringDesign]:
    """The best spring of each wire; inch and metric sizes within 2 % of each other are no choice."""
    kept: list[SpringDesign] = []
    for design in ranked:
        if all(abs(design.wire_diameter / other.wire_diameter - 1.0) > 0.02 for other in kept):
            kept.append(design)
    return kept


def _broken(design: SpringDesign) -> frozenset[str]:
    return frozenset(violation.limit for violation in design.violations)


def _worst(design: SpringDesign) -> float:
    return max((violation.excess for violation in design.violations), default=1.0)


def _describe(design: SpringDesign) -> str:
    """A spring in one line."""
    return (
        f"wire {design.wire_diameter * 1e3:.4g} mm, mean diameter {design.mean_diameter * 1e3:.4g} mm, "
        f"{design.body_coils:.4g} coils, {design.rate:.4g} N*m/rad"
    )


def _binding(found: list[SpringDesign], wish: SpringWish) -> Iterator[str]:
    """What stands in the way: each limit that alone keeps some spring out, by the spring it keeps out least."""
    if not found:
        low, high = wish.limits.index_range
        yield (
            f"no stock wire of {wish.material} gives {wish.rate:.4g} N*m/rad with a spring index of {low:g} to "
            f"{high:g} and {wish.limits.min_coils:g} to {wish.limits.max_coils:g} coils"
        )
        return
    fewest = min(len(_broken(design)) for design in found)
    for limits in sorted({_broken(design) for design in found if len(_broken(design)) == fewest}, key=sorted):
        design = min((each for each in found if _broken(each) == limits), key=_worst)
        text = "; ".join(violation.text for violation in design.violations)
        if "stress" in limits:
            allowed = design.free_travel * design.allowed_stress / design.yield_stress
            wanted = math.degrees(max(wish.travel, wish.opening_travel))
            text += (
                f"; it yields at {math.degrees(design.free_travel):.3g} deg and may turn "
                f"{math.degrees(allowed):.3g} deg, wanted are {wanted:.3g} deg"
            )
            if design.wire_diameter == max(each.wire_diameter for each in found):
                text += "; no thicker stock wire of this material gives this rate"
        yield f"{' and '.join(sorted(limits))}: the nearest spring ({_describe(design)}) has {text}"


def _more_room(found: list[SpringDesign]) -> Iterator[Nearest]:
    """Thicker wire: a single spring that does it all but takes more room; its ``violations`` say how much more."""
    designs = [design for design in found if design.violations and _broken(design) <= ROOM]
    if designs:
        design = min(designs, key=lambda each: (_worst(each), each.mass))
        needs = " and ".join(violation.text for violation in design.violations)
        yield Nearest("more_room", f"with more room: {_describe(design)}; it has {needs}", design)


def _parallel(wish: SpringWish, material: WireMaterial) -> Iterator[Nearest]:
    """The fewest equal springs side by side, the rate shared."""
    for count in range(2, MOST_IN_PARALLEL + 1):
        shared = replace(wish, rate=wish.rate / count)
        good = _ranked([each for each in candidates(shared, material) if each.feasible], wish.objective)
        if good:
            design = replace(good[0], count=count)
            text = (
                f"{count} in parallel, each within the limits and {wish.rate / count:.4g} N*m/rad: {_describe(design)}"
            )
            yield Nearest("parallel", text, design)
            return


def _smaller_travel(found: list[SpringDesign], wish: SpringWish, material: WireMaterial) -> Iterator[Nearest]:
    """The single spring within the limits that turns furthest."""
    liftable = {"stress", "arms", "fatigue", "arbor", "body_length"}  # the limits that a smaller travel may lift
    reach = [(travel_limit(each, wish.limits), each) for each in found if _broken(each) <= liftable]
    reach = [(travel, each) for travel, each in reach if travel >= LEAST_TRAVEL]
    if not reach:
        return
    furthest = max(travel for travel, _ in reach)
    travel = math.radians(math.floor(math.degrees(furthest) * 10.0) / 10.0)  # a tenth of a degree is what one sets
    opening = min(wish.opening_travel, OPENING * travel)
    shorter = replace(wish, travel=travel, opening_travel=opening)
    good = _ranked([each for each in candidates(shorter, material) if each.feasible], wish.objective)
    if good:
        asked = f"{math.degrees(travel):.3g} deg of {math.degrees(wish.travel):.3g} deg"
        if opening < wish.opening_travel:
            asked += f", opening {math.degrees(opening):.3g} deg of {math.degrees(wish.opening_travel):.3g} deg"
        text = f"a smaller travel, {asked}: {_describe(good[0])}"
        yield Nearest("smaller_travel", text, good[0])


def _other_material(wish: SpringWish, material: WireMaterial, catalogue: Catalogue) -> Iterator[Nearest]:
    """The best single spring within the limits of another wire."""
    designs: list[SpringDesign] = []
    for name in OTHER_MATERIALS:
        other = catalogue.find_material(name)
        if other.name != material.name:
            designs += [each for each in candidates(replace(wish, material=name), other) if each.feasible]
    for design in _ranked(designs, wish.objective)[:1]:
        yield Nearest("other_material", f"{design.material} wire: {_describe(design)}", design)
