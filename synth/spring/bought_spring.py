"""A bought spring in a joint: whether it yields, breaks early, or passes its vendor's limits in the joint's travel."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import degrees

from synth.errors import UserError
from synth.parts.catalogs import Catalogue
from synth.parts.rows import TorsionSpringRow
from synth.remarks import unlike
from synth.spring.evaluate import broken_limits, check_spring
from synth.spring.spring_result import SpringDesign
from synth.spring.spring_task import FreeArm, SpringLimits, SpringTask
from synth.spring.stress import free_travel

ANY_INDEX = (1.0, 100.0)  # spring index; that of a spring on sale is not ours to limit
ROUNDING = 1.0 + 1e-6  # of converted units


@dataclass(frozen=True)
class PassedLimit:
    """A limit of a bought spring that the joint's travel passes.

    ``reason`` is the same for all springs of a joint, so that they can be counted; ``text`` has this spring's numbers.
    """

    reason: str
    text: str


def check_bought(
    row: TorsionSpringRow,
    catalogue: Catalogue,
    travel: float,
    opening: float = 0.0,
    *,
    arm: FreeArm | None = None,
    rate: float | None = None,
) -> SpringDesign | None:
    """The spring over ``travel`` and ``opening`` rad; None if too few data of it are known.

    ``arm`` : of arms that the joint clamps, with which the spring's ``rate`` is given, N m/rad; None: the published
    rate, and a moment that is the same along the wire.
    """
    if not (row.material and row.wire_diameter and row.mean_diameter and row.body_coils):
        return None
    task = SpringTask(travel, opening, limits=SpringLimits(index_range=ANY_INDEX), free_arm=arm)
    stated = row.rate if rate is None else rate
    try:
        material = catalogue.find_material(row.material)
        return check_spring(material, row.wire_diameter, row.mean_diameter, row.body_coils, task, stated_rate=stated)
    except UserError:
        return None  # the strength of this wire is unknown; the design's warnings say so, with ``unknown_yield``


def travel_to_yield(row: TorsionSpringRow, catalogue: Catalogue) -> float | None:
    """``free_travel`` of ``check_bought``, rad, in a fraction of its time; None if too few data are known."""
    if not (row.material and row.wire_diameter and row.mean_diameter and row.body_coils and row.rate):
        return None
    try:
        wire = catalogue.find_material(row.material).properties(row.wire_diameter)
    except UserError:
        return None  # as in ``check_bought``
    limit = wire.static_limit * wire.strength.value
    return free_travel(limit, row.rate, row.wire_diameter, row.mean_diameter)


def unknown_yield(row: TorsionSpringRow, catalogue: Catalogue) -> str:
    """Why ``check_bought`` knows no angle at which a spring yields, in words; empty if it does."""
    if not (row.material and row.wire_diameter and row.mean_diameter and row.body_coils):
        return "the catalogue has too few data of it"
    return catalogue.known_materials.unknown_strength(row.material, row.wire_diameter)


def passed_limits(
    row: TorsionSpringRow, catalogue: Catalogue, travel: float, *, yields: float | None = None
) -> Iterator[PassedLimit]:
    """Yield of the wire and the vendor's largest deflection and torque, as far as they are passed.

    ``travel`` : rad from the free angle. ``yields`` : rad at which the wire yields as the joint holds its arms; None:
    with a moment that is the same along the wire. Torque is that of the published rate, which is the body's: with its
    arms the spring is a little softer. An unknown limit is not passed.
    """
    turned = degrees(travel)
    held = travel_to_yield(row, catalogue) if yields is None else yields
    if held is not None and travel > held:
        far, limit = unlike(turned, degrees(held), ".0f")
        text = f"yields at {limit} deg from its free angle, but the joint turns it {far} deg"
        yield PassedLimit(f"yields within {turned:.0f} deg", text)
    yield from vendor_limits(row, travel)


def passed_as_held(check: SpringDesign | None, cycles: float | None, unchecked: str) -> Iterator[PassedLimit]:
    """Yield where the joint opens the coil, in its better seat, and the required full turns; as in ``breaks_early``."""
    opened = None if check is None or _held_turned_round(check) else opened_too_far(check)
    early = breaks_early(check, cycles, unchecked)
    yield from (each for each in (opened, early) if each is not None)


def _held_turned_round(check: SpringDesign) -> bool:
    """Whether the spring bears the joint's travel in the other seat, in which ``well_seated`` draws it."""
    return check.opening_travel <= check.free_travel and check.travel <= check.free_opening_travel


def breaks_early(check: SpringDesign | None, cycles: float | None, unchecked: str = "") -> PassedLimit | None:
    """The number of full turns that is required, if the spring does not last it, or if its life cannot be told.

    The judgement is that of a given spring, ``check_spring`` with ``cycles``: what is required must be known to hold.

    Parameters
    ----------
    check
        of ``check_bought``; None: too few data are known, ``unchecked`` says why.
    cycles
        full turns; None: none are required, and the answer is None.
    """
    if cycles is None:
        return None
    turns = f"{cycles:.0f} full turns"
    if check is None:
        return PassedLimit(f"life unknown, {turns} required", f"may not last {turns}: {unchecked}")
    limits = SpringLimits(index_range=ANY_INDEX, cycles=cycles)
    broken = next((each.text for each in broken_limits(check, limits) if each.limit == "fatigue"), None)
    if broken is None:
        return None
    if check.life is None:
        return PassedLimit(f"life unknown, {turns} required", f"may not last {turns}: {broken}")
    return PassedLimit(f"may break before {turns}", f"may break before {turns}: {broken} (Gerber)")


def opened_too_far(check: SpringDesign) -> PassedLimit | None:
    """Yield of the wire where the joint opens the coil; None if it holds. ``check`` of ``check_bought``."""
    if check.opening_travel <= check.free_opening_travel:
        return None
    turned = degrees(check.opening_travel)
    opened, held = unlike(turned, degrees(check.free_opening_travel), ".0f")
    text = f"yields where it is opened by {held} deg, but the joint opens it by {opened} deg"
    return PassedLimit(f"yields within {turned:.0f} deg of opening", text)


def vendor_limits(row: TorsionSpringRow, travel: float) -> Iterator[PassedLimit]:
    """The vendor's largest deflection and torque, as far as ``travel`` rad from the free angle passes them."""
    turned = degrees(travel)
    most = row.max_deflection
    if most is not None and travel > most * ROUNDING:
        far, limit = unlike(turned, degrees(most), ".0f")
        text = f"may be turned {limit} deg by its vendor's limit, but the joint turns it {far} deg"
        yield PassedLimit(f"turned {turned:.0f} deg, beyond its vendor's max_deflection", text)
    most, torque = row.max_torque, (row.rate or 0.0) * travel
    if most is not None and torque > most * ROUNDING:
        load, limit = unlike(torque, most, ".3g")
        text = f"may be loaded with {limit} N*m by its vendor's limit, but the joint loads it with {load} N*m"
        yield PassedLimit(f"loaded beyond its vendor's max_torque at {turned:.0f} deg", text)
