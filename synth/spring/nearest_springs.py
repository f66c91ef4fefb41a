"""If no spring keeps all limits: which limits prevent it, and the nearest springs that can be made instead."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain
from typing import Any, Literal

from synth.parts.catalogs import Catalogue
from synth.parts.wire import WireMaterial
from synth.remarks import unlike
from synth.spring.calibration import UNCALIBRATED
from synth.spring.codes import OPENING
from synth.spring.evaluate import travel_limit
from synth.spring.preferred_springs import prefer_springs
from synth.spring.spring_requirements import SpringRequirements
from synth.spring.spring_result import DESIGN_LIFE, SpringDesign
from synth.spring.spring_search import candidates, describe, feasible_candidates, rank_springs, worst_excess
from synth.spring.unit_text import MeasuredText, UnitText, join_texts

ROOM = frozenset({"outer_diameter", "body_length"})  # limits that more room in the joint would lift
OTHER_MATERIALS = ("oil tempered", "chrome vanadium", "chrome silicon")  # sold thicker or stronger than music wire
MOST_IN_PARALLEL = 4  # springs side by side: a joint has room for no more
LEAST_TRAVEL = math.radians(1.0)  # rad; a request for less is most likely a mistake of units


@dataclass(frozen=True)
class NearestSpring:
    """A spring that can be made but does not meet one requirement, which ``kind`` and ``lead`` name.

    ``notes``: preferences that it does not meet either. ``text`` describes the spring from ``design``, so that both
    stay the same where the spring is sized again for its joint.
    """

    kind: Literal["more_room", "parallel", "smaller_travel", "other_material"]
    lead: str
    design: SpringDesign
    notes: tuple[str, ...] = ()

    @property
    def text(self) -> UnitText:
        """The requirement that it does not meet, the spring, and what it exceeds or lacks."""
        over = [violation.text for violation in self.design.violations] if self.kind == "more_room" else []
        needs = [UnitText("it has ", join_texts(" and ", over))] if over else []
        return join_texts("; ", (UnitText(self.lead, describe(self.design)), *needs, *self.notes))

    def as_json(self) -> dict[str, Any]:
        """The entry in a result."""
        return {"kind": self.kind, "text": self.text, "make": self.design.as_json()}


def nearest_lasting(wish: SpringRequirements, material: WireMaterial, catalogue: Catalogue) -> list[NearestSpring]:
    """The nearest springs that last the design life: with more room, several in parallel, or a smaller travel."""
    lasting = replace(wish, limits=replace(wish.limits, cycles=DESIGN_LIFE))
    return list(nearest_springs(list(candidates(lasting, material)), lasting, material, catalogue))


def nearest_springs(
    found: list[SpringDesign], wish: SpringRequirements, material: WireMaterial, catalogue: Catalogue
) -> Iterator[NearestSpring]:
    """What can be made instead: with more room, in parallel, with a smaller travel, of another material.

    If none of these helps on its own: springs in parallel with a smaller travel. Each is sought when it is asked for.

    ``found``: the candidates for ``wish``, of which none keeps all limits.
    """
    helped = False
    for nearest in chain(
        _more_room(found),
        _parallel(wish, material),
        _smaller_travel(found, wish, material),
        _other_material(wish, material, catalogue),
    ):
        helped = True
        yield nearest
    if not helped:
        yield from _parallel_of_smaller_travel(wish, material)


def _violated_limits(design: SpringDesign) -> frozenset[str]:
    return frozenset(violation.limit for violation in design.violations)


def limits_in_the_way(found: list[SpringDesign], wish: SpringRequirements) -> Iterator[str]:
    """The smallest sets of limits that exclude a candidate, each described by the candidate that exceeds it least."""
    if not found:
        low, high = wish.limits.index_range
        yield UnitText(
            *("no stock wire of ", wish.material, _allowed_wire(wish), " gives ", MeasuredText(wish.rate, "N*m/rad")),
            f" with a spring index of {low:g} to {high:g} and {wish.limits.min_coils:g} to "
            f"{wish.limits.max_coils:g} coils",
        )
        return
    fewest = min(len(_violated_limits(design)) for design in found)
    for limits in sorted(
        {_violated_limits(design) for design in found if len(_violated_limits(design)) == fewest}, key=sorted
    ):
        design = min((each for each in found if _violated_limits(each) == limits), key=worst_excess)
        text = join_texts("; ", (violation.text for violation in design.violations))
        if "stress" in limits:
            allowed = math.degrees(design.load.angle(design.allowed_stress))
            wanted, may = unlike(math.degrees(max(wish.travel, wish.opening_travel)), allowed, ".3g")
            text = UnitText(
                *(text, f"; it yields at {math.degrees(design.free_travel):.3g} deg and may turn "),
                f"{may} deg; {wanted} deg are required",
            )
            if design.wire_diameter == max(each.wire_diameter for each in found):
                text = UnitText(text, "; no thicker stock wire of this material gives this rate")
        yield UnitText(f"{' and '.join(sorted(limits))}: the nearest spring (", describe(design), ") has ", text)


def _allowed_wire(wish: SpringRequirements) -> str:
    """The wires to which the search is restricted, in words; empty: any."""
    low, high = wish.wire_range
    words: list[str] = [f"{wish.system} sizes"] if wish.system is not None else []
    words += [UnitText("at least ", MeasuredText(low, "m"))] if low > 0.0 else []
    words += [UnitText("at most ", MeasuredText(high, "m"))] if math.isfinite(high) else []
    return UnitText(" (", join_texts(", ", words), ")") if words else ""


def _more_room(found: list[SpringDesign]) -> Iterator[NearestSpring]:
    """A single spring, usually of thicker wire, that violates only limits on room; ``violations`` gives the excess."""
    designs = [design for design in found if design.violations and _violated_limits(design) <= ROOM]
    if designs:
        design = min(designs, key=lambda each: (worst_excess(each), each.mass))
        yield NearestSpring("more_room", "with more room: ", design)


def _parallel(wish: SpringRequirements, material: WireMaterial) -> Iterator[NearestSpring]:
    """The smallest number of equal springs in parallel that share the rate and keep the limits.

    Of these the preferred ones; the text states a preference that none meets.
    """
    for count in range(2, MOST_IN_PARALLEL + 1):
        shared = replace(wish, rate=wish.rate / count)
        good = list(feasible_candidates(shared, material))
        if good:
            kept, notes = prefer_springs(good, partial(candidates, shared, material), shared)
            design = replace(rank_springs(kept, wish.objective)[0], count=count)
            each = MeasuredText(wish.rate / count, "N*m/rad")
            lead = UnitText(f"{count} in parallel, each within the limits and ", each, ": ")
            yield NearestSpring("parallel", lead, design, tuple(notes))
            return


def _smaller_travel(
    found: list[SpringDesign], wish: SpringRequirements, material: WireMaterial
) -> Iterator[NearestSpring]:
    """The single spring within the limits that has the largest travel."""
    liftable = {"stress", "arms", "fatigue", "arbor", "body_length"}  # the limits that a smaller travel may lift
    reach = [(travel_limit(each, wish.limits), each) for each in found if _violated_limits(each) <= liftable]
    reach = [(travel, each) for travel, each in reach if travel >= LEAST_TRAVEL]
    if not reach:
        return
    furthest = max(travel for travel, _ in reach)
    travel = math.radians(math.floor(math.degrees(furthest) * 10.0) / 10.0)  # users set angles to a tenth of a degree
    opening = min(wish.opening_travel, OPENING * travel)
    shorter = replace(wish, travel=travel, opening_travel=opening)
    good = list(feasible_candidates(shorter, material))
    if good:
        kept, notes = prefer_springs(good, partial(candidates, shorter, material), shorter)
        design = rank_springs(kept, wish.objective)[0]
        asked = f"{math.degrees(travel):.3g} deg of {math.degrees(wish.travel):.3g} deg"
        if opening < wish.opening_travel:
            asked += f", opening {math.degrees(opening):.3g} deg of {math.degrees(wish.opening_travel):.3g} deg"
        yield NearestSpring("smaller_travel", f"a smaller travel, {asked}: ", design, tuple(notes))


def _parallel_of_smaller_travel(wish: SpringRequirements, material: WireMaterial) -> Iterator[NearestSpring]:
    """Springs in parallel with the largest travel: both requirements are given up."""
    reached = []
    for count in range(2, MOST_IN_PARALLEL + 1):
        shared = replace(wish, rate=wish.rate / count)
        for item in _smaller_travel(list(candidates(shared, material)), shared, material):
            lead = UnitText(
                f"{count} in parallel, each of ", MeasuredText(shared.rate, "N*m/rad"), ", with ", item.lead
            )
            reached.append(replace(item, lead=lead, design=replace(item.design, count=count)))
    yield from sorted(reached, key=lambda item: -item.design.travel)[:1]


def _other_material(wish: SpringRequirements, material: WireMaterial, catalogue: Catalogue) -> Iterator[NearestSpring]:
    """The best single spring of another wire material that keeps the limits; no calibration is known for it."""
    designs: list[SpringDesign] = []
    for name in OTHER_MATERIALS:
        other = catalogue.find_material(name)
        if other.name != material.name:
            designs += feasible_candidates(replace(wish, material=name, calibration=UNCALIBRATED), other)
    for design in rank_springs(designs, wish.objective)[:1]:
        wire = f"{design.material} wire{'' if wish.calibration == UNCALIBRATED else ', which is not calibrated'}"
        yield NearestSpring("other_material", f"{wire}: ", design)
