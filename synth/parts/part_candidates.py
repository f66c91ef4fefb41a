"""Catalogue rows that meet a joint's constraints, and the reasons against the others."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import ceil, degrees
from typing import Generic, TypeVar

from synth.errors import CannotBeHad, UserError
from synth.files.project_options import DamperBounds, DamperChoice, PartsOptions, SpringBounds, SpringChoice
from synth.files.spring_words import OTHER_HAND
from synth.parts.catalogs import Catalogue
from synth.parts.catalogue_row import CatalogueRow
from synth.parts.material_names import same_material
from synth.parts.rows import DamperRow, TorsionSpringRow

RowType = TypeVar("RowType", bound=CatalogueRow)

MEASURE_IT = (
    ". If you have the part, measure what is missing, write its row into a table of your own, and name that under "
    "select.catalogs: it replaces this row"
)


@dataclass(frozen=True)
class Candidates(Generic[RowType]):
    """Rows that meet the constraints, and the number of others by reason."""

    rows: tuple[RowType, ...]
    left_out: Mapping[str, int]
    nearest: str = ""


ANY = PartsOptions()
Acting = Callable[[TorsionSpringRow], float]  # rate (N m/rad) of one spring of a row as a joint holds it


def spring_candidates(
    catalogue: Catalogue,
    choice: SpringChoice,
    rate: float,
    parts: PartsOptions = ANY,
    count: int = 1,
    acting: Acting | None = None,
) -> Candidates[TorsionSpringRow]:
    """Springs of which ``count`` in parallel have the wanted rate (N m/rad) within tolerance and meet the constraints.

    ``acting``: of a spring in the joint that wants the rate, with clamped arms; None: their rates are those as sold.
    Of two that differ in the hand alone the first one is taken: they move a leg alike, and the seat is drawn for the
    chosen one. A spring named by part is the only candidate, regardless of its values.
    """
    if choice.part is not None:
        return Candidates((named_spring(catalogue, choice.part),), {})
    kept, reasons = list[TorsionSpringRow](), Counter[str]()
    parts = of_family(parts, catalogue.springs)
    rate /= count
    for row in catalogue.springs:
        reason = spring_reason(row, choice, rate, parts, count, acting)
        if reason is None:
            if not any(_is_mirror(row, each) for each in kept):
                kept.append(row)
        else:
            reasons[reason] += 1
    nearest = _nearest_spring(catalogue, choice, rate * count, parts, acting)
    return Candidates(tuple(kept), dict(sorted(reasons.items())), nearest)


def _as_sold(row: TorsionSpringRow) -> float:
    return row.rate or 0.0


def _nearest_spring(
    catalogue: Catalogue, choice: SpringChoice, rate: float, parts: PartsOptions, acting: Acting | None
) -> str:
    """What comes nearest to a rate (N m/rad), up to ``parallel`` springs of it, and the tolerance that would take it.

    The nearest of those that meet all other constraints, if any does: no tolerance helps the others.
    """
    counts = range(1, choice.parallel + 1)
    usable = [(row, count) for row in catalogue.springs if row.choosable and row.rate for count in counts]
    meeting = [each for each in usable if spring_reason(each[0], choice, None, parts, each[1]) is None]
    if not usable:
        return ""
    rate_of = acting or _as_sold
    row, count = min(meeting or usable, key=lambda each: (abs(rate_of(each[0]) * each[1] / rate - 1.0), each[1]))
    total = rate_of(row) * count
    name = f"{count} x {row.part}" if count > 1 else row.part
    off_by = f"{total / rate - 1:+.0%} from {rate:.4g}"
    held = "as sold, without its arms" if acting is None else "in the joint, which clamps its arms"
    text = f"{name} comes nearest with {total:.4g} N*m/rad {held}, {off_by}"
    off = ceil(abs(total / rate - 1.0) * 20.0) * 5  # with some room: the wanted rate goes with the links' masses
    return f"{text}; rate_tolerance: {off} % takes it" if meeting and off > 100 * choice.rate_tolerance else text


def _cannot_be_used(kind: str, row: TorsionSpringRow | DamperRow) -> UserError:
    return UserError(f"{kind} {row.part} ({row.place}) cannot be used: {row.status}{MEASURE_IT}")


def named_spring(catalogue: Catalogue, part: str) -> TorsionSpringRow:
    """The spring that a design names.

    Raises
    ------
    UserError
        If there is none, or values are missing without which it cannot be simulated.
    """
    row = catalogue.find_spring(part)
    if row.rate is None or row.included_angle is None:
        raise _cannot_be_used("spring", row)
    return row


def named_damper(catalogue: Catalogue, part: str) -> DamperRow:
    """The damper that a design names.

    Raises
    ------
    UserError
        If there is none, or values are missing without which it cannot be simulated.
    """
    row = catalogue.find_damper(part)
    if row.max_torque is None or row.speed is None:
        raise _cannot_be_used("damper", row)
    return row


def of_family(parts: PartsOptions, rows: Sequence[TorsionSpringRow] | Sequence[DamperRow]) -> PartsOptions:
    """The options for one family: vendors that sell none of it do not exclude others."""
    wanted = {name.casefold() for name in parts.vendors}
    if not wanted or any(row.vendor.casefold() in wanted for row in rows):
        return parts
    return replace(parts, vendors=())


def _not_to_be_had(row: TorsionSpringRow | DamperRow, parts: PartsOptions) -> Iterator[str]:
    """Why a part is excluded regardless of its values."""
    if parts.vendors and row.vendor.casefold() not in {name.casefold() for name in parts.vendors}:
        yield f"not of {' or '.join(parts.vendors)}"
    if row.part.casefold() in {name.casefold() for name in parts.without}:
        yield "excluded by select.without"


SAME = 0.01  # relative: rounding of published figures and of their conversion from inches, under all tolerances
SAME_ANGLE = 1.5  # deg: far below the free angle's tolerance of 10 deg


def mirror_of(
    row: TorsionSpringRow, rows: Sequence[TorsionSpringRow], parts: PartsOptions = ANY
) -> TorsionSpringRow | None:
    """The spring of the other hand and otherwise the same sizes and rate, the same vendor's first; None if unknown."""
    wanted, parts = OTHER_HAND.get(row.hand), of_family(parts, rows)
    found = [
        each
        for each in rows
        if each.hand == wanted and each.choosable and not any(_not_to_be_had(each, parts)) and _same_coil(row, each)
    ]
    return min(found, key=lambda each: (each.vendor != row.vendor, each.vendor, each.part), default=None)


def _is_mirror(one: TorsionSpringRow, other: TorsionSpringRow) -> bool:
    """Whether a vendor sells them as one spring of either hand."""
    hands = bool(one.hand) and OTHER_HAND.get(one.hand) == other.hand
    return hands and one.vendor == other.vendor and _same_coil(one, other)


def _same_coil(one: TorsionSpringRow, other: TorsionSpringRow) -> bool:
    """Whether two springs have the same wire, coil, included angle and rate; legs are cut to length."""
    if not same_material(one.material, other.material) or (one.leg_convention or "tangent") != (
        other.leg_convention or "tangent"
    ):
        return False
    lengths = [(one.body_length, other.body_length)]
    sizes = [(getattr(one, name), getattr(other, name)) for name in ("wire_diameter", "outer_diameter", "body_coils")]
    sizes += [(one.rate, other.rate), *(pair for pair in lengths if None not in pair)]
    angles = one.included_angle, other.included_angle
    if None in angles or any(None in pair for pair in sizes):
        return False
    apart = abs(degrees((angles[0] or 0.0) - (angles[1] or 0.0)))
    return apart <= SAME_ANGLE and all(abs(b / a - 1.0) <= SAME for a, b in sizes)


def spring_reason(
    row: TorsionSpringRow,
    choice: SpringBounds,
    rate: float | None,
    parts: PartsOptions = ANY,
    count: int = 1,
    acting: Acting | None = None,
) -> str | None:
    """The first reason against a spring, or None. ``rate`` N m/rad of each, None: any; ``acting`` as in candidates."""
    return next(spring_reasons(row, choice, rate, parts, count, acting), None)


def spring_reasons(
    row: TorsionSpringRow,
    choice: SpringBounds,
    rate: float | None,
    parts: PartsOptions = ANY,
    count: int = 1,
    acting: Acting | None = None,
) -> Iterator[str]:
    """All reasons against a spring; for an unusable row, its status. ``acting`` as in ``spring_candidates``."""
    if not row.choosable:
        yield row.status
        return
    yield from _not_to_be_had(row, parts)
    if parts.system is not None and row.system not in (None, parts.system):
        yield f"its wire is no {parts.system} size"
    assert row.included_angle is not None
    if rate is not None and abs((acting or _as_sold)(row) / rate - 1.0) > choice.rate_tolerance:
        held = "" if acting is None else " in the joint"
        yield f"rate{held} not within {choice.rate_tolerance:.0%} of {rate:.4g} N*m/rad"
    if choice.included_angle is not None and abs(degrees(row.included_angle - choice.included_angle)) > SAME_ANGLE:
        yield f"included angle is not {degrees(choice.included_angle):g} deg"
    body = row.body_length if row.body_length is not None else row.close_wound_length
    body = None if body is None else body * count
    for what, value, least, most in (
        ("outer diameter", row.outer_diameter, choice.min_outer_diameter, choice.max_outer_diameter),
        ("inner diameter", row.inside, choice.min_inner_diameter, None),
        ("body length", body, choice.min_body_length, choice.max_body_length),
        ("wire diameter", row.wire_diameter, choice.min_wire_diameter, choice.max_wire_diameter),
    ):
        if value is not None and most is not None and value > most * (1 + 1e-6):  # 1e-6: rounding of converted units
            yield f"{what} over {most * 1e3:.4g} mm"
        if value is not None and least is not None and value < least * (1 - 1e-6):  # as above
            yield f"{what} under {least * 1e3:.4g} mm"


def damper_candidates(
    catalogue: Catalogue,
    choice: DamperChoice,
    travel: float,
    joint: str,
    parts: PartsOptions = ANY,
    against: Callable[[DamperRow], str | None] | None = None,
) -> Candidates[DamperRow]:
    """Dampers of the required direction and travel (rad). ``against``: why one cannot be drawn, None: it can.

    Raises
    ------
    CannotBeHad : none remains, and the message counts the reasons; or the named part damps one way only, and
        ``parallel`` of it are no pairs.
    """
    if choice.part is not None:
        row = named_damper(catalogue, choice.part)
        if row.direction not in ("both", "") and choice.parallel % 2:
            raise CannotBeHad(
                f"{joint}: damper {row.part} ({row.place}) damps one way only, and the leg swings both ways. Write "
                f"parallel: 2 under select.joints.{joint}.damper for a pair, one per direction (4 for two pairs), or "
                "name another damper"
            )
        return Candidates((row,), {})
    kept, reasons = [], Counter[str]()
    parts = of_family(parts, catalogue.dampers)
    for row in catalogue.dampers:
        reason = damper_reason(row, choice, travel, parts)
        if reason is None and against is not None:
            reason = against(row)
        if reason is None:
            kept.append(row)
        else:
            reasons[reason] += 1
    if not kept:
        raise CannotBeHad(
            f"{joint}: no damper in the catalogue meets the constraints: {count_reasons(reasons)}. Loosen "
            f"select.joints.{joint}.damper, or add a catalogue under select.catalogs"
        )
    return Candidates(tuple(kept), dict(sorted(reasons.items())))


def damper_reason(row: DamperRow, choice: DamperBounds, travel: float, parts: PartsOptions = ANY) -> str | None:
    """The first reason against a damper, or None."""
    return next(damper_reasons(row, choice, travel, parts), None)


def damper_reasons(row: DamperRow, choice: DamperBounds, travel: float, parts: PartsOptions = ANY) -> Iterator[str]:
    """All reasons against a damper; for an unusable row, its status."""
    if not row.choosable:
        yield row.status
        return
    yield from _not_to_be_had(row, parts)
    if choice.direction == "both" and row.direction != "both" and choice.parallel < 2:
        yield "damps one way only (parallel: 2 allows a pair)"
    wanted = (choice.travel if choice.travel is not None else travel) * min(choice.ratios)
    if row.allows_travel(wanted) is False:
        yield f"turns less than {degrees(wanted):.0f} deg"
    for what, size, most in damper_limits(row, choice):
        if size is not None and size > most * (1 + 1e-6):  # 1e-6: rounding of converted units
            yield f"{what} over {most * 1e3:.4g} mm"


def damper_limits(row: DamperRow, choice: DamperBounds) -> list[tuple[str, float | None, float]]:
    """Name, value and largest allowed value (m) of each of a damper's sizes that has a limit; None: unknown."""
    sizes = (
        ("outer diameter", row.outer_diameter, choice.max_outer_diameter),
        ("body length", row.body_length, choice.max_body_length),
    )
    return [(what, size, most) for what, size, most in sizes if most is not None]


def no_spring(joint: str, found: Candidates[TorsionSpringRow], rows: Sequence[TorsionSpringRow]) -> CannotBeHad:
    """The message if a bought spring is required and none fits."""
    return CannotBeHad(
        f"{joint}: none of the {len(rows)} springs in the catalogue meets the constraints: "
        f"{count_reasons(found.left_out)}. {found.nearest}. Loosen select.joints.{joint}.spring, add a "
        "catalogue under select.catalogs, or write make: true for a spring to wind"
    )


def count_reasons(reasons: Mapping[str, int]) -> str:
    """Reasons with the number of parts, most frequent first, in one line of text."""
    return "; ".join(f"{count} {reason}" for reason, count in sorted(reasons.items(), key=lambda item: -item[1]))
