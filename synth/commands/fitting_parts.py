"""``synth catalog show knee.yaml``: parts that fit a joint, nearest first, and the reasons against the others."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import degrees, log, pi
from typing import Any

import numpy as np

from synth.commands.table_text import table_text
from synth.files.part_request import PartRequest, RequestedDamper, RequestedSpring
from synth.files.project_options import PartsOptions
from synth.parts.arrangement import Arrangement, arrangements
from synth.parts.catalogs import Catalogue
from synth.parts.catalogue_row import CatalogueRow
from synth.parts.part_candidates import damper_reasons, of_family, spring_reasons
from synth.parts.rows import DamperRow, TorsionSpringRow
from synth.parts.usable import offers
from synth.spring.bought_spring import passed_limits, travel_to_yield
from synth.swing.damper_curves import torque_at
from synth.swing.leg_model import Damper

OTHER_HEADS = ("part", "vendor", "off", "status", "why")  # of those that do not fit
MOST_ROWS = 30  # listed rows, of those that fit and of those that do not


@dataclass(frozen=True)
class _Line:
    """A part, its distance from the request (0: exact), its cells, and the reasons against it."""

    part: str
    distance: float
    cells: tuple[str, ...]
    reasons: tuple[str, ...] = ()


@dataclass(frozen=True)
class FittingParts:
    """Parts of one kind: those that fit, those that do not with their reasons, and rows that cannot be chosen.

    A row may be chosen as in ``synth leg``: it is complete, or usable as its status says.
    """

    title: str
    heads: tuple[str, ...]
    fitting: tuple[_Line, ...]  # nearest first, as are the others
    others: tuple[_Line, ...]
    unusable: Counter[str]  # by what they lack

    def text(self) -> str:
        """As tables; the nearest of each are named one by one."""
        return "\n".join(_lines(self))

    def as_json(self) -> dict[str, Any]:
        """All of them, none left out; cells as the table shows them."""
        return {
            "wish": self.title,
            "fit": [dict(zip(self.heads, (line.part, *line.cells), strict=True)) for line in self.fitting],
            "do_not": [dict(zip(OTHER_HEADS, (line.part, *line.cells), strict=True)) for line in self.others],
            "cannot_be_used": dict(self.unusable.most_common()),
        }


def fitting_blocks(wish: PartRequest, catalogue: Catalogue) -> tuple[FittingParts, ...]:
    """Springs and dampers that fit, and the reasons against the others."""
    blocks = []
    if wish.spring is not None:
        blocks.append(_springs(wish.spring, wish, catalogue))
    if wish.damper is not None:
        blocks.append(_dampers(wish.damper, wish, catalogue))
    return tuple(blocks)


def _springs(asked: RequestedSpring, wish: PartRequest, catalogue: Catalogue) -> FittingParts:
    parts = of_family(wish.parts, catalogue.springs)
    fitting, others, unusable = [], [], Counter[str]()
    for row in catalogue.springs:
        if not row.choosable:
            unusable[row.status] += 1
            continue
        passed = [] if asked.travel is None else [each.reason for each in passed_limits(row, catalogue, asked.travel)]
        for count in range(1, asked.parallel + 1):
            rate = None if asked.rate is None else asked.rate / count
            reasons = [*spring_reasons(row, asked, rate, parts, count), *passed]
            off = 0.0 if asked.rate is None or row.rate is None else log(row.rate * count / asked.rate)
            label = f"{count} x {row.part}" if count > 1 else row.part
            if reasons:
                others.append(_not_fitting(label, row.vendor, off, asked.rate, row, reasons))
            else:
                cells = (*_spring_cells(row, count, off, asked.rate), _yield_angle(row, catalogue), row.status)
                fitting.append(_Line(label, abs(off), (row.vendor, *cells)))
    heads = ("spring", "vendor", "rate [N*m/rad]", "[lbf*in/deg]", "off", "wire [mm]", "wire [in]", "outside [mm]",
             "outside [in]", "coils", "angle [deg]", "yields at [deg]", "status")  # fmt: skip
    title = "springs" if asked.rate is None else f"springs of {asked.rate:.4g} N*m/rad"
    return _sorted_lines(title, heads, fitting, others, unusable)


def _yield_angle(row: TorsionSpringRow, catalogue: Catalogue) -> str:
    """The angle from the free position at which the wire yields, deg."""
    angle = travel_to_yield(row, catalogue)
    return "not known" if angle is None else f"{degrees(angle):.0f}"


def _not_fitting(
    label: str, vendor: str, off: float, wanted: float | None, row: CatalogueRow, reasons: list[str]
) -> _Line:
    cells = (vendor, _deviation_text(off, wanted), row.state, "; ".join(reasons))
    return _Line(label, abs(off), cells, tuple(reasons))


def _deviation_text(off: float, wanted: float | None) -> str:
    return "" if wanted is None else f"{np.expm1(off):+.0%}"


def _spring_cells(row: TorsionSpringRow, count: int, off: float, wanted: float | None) -> tuple[str, ...]:
    rate, wire, outer = (row.rate or 0.0) * count, row.wire_diameter, row.outer_diameter
    per_degree = rate / 0.112984829 * pi / 180
    sizes = [f"{size * scale:.4g}" if size else "" for size in (wire, outer) for scale in (1e3, 1 / 0.0254)]
    angle = "" if row.included_angle is None else f"{degrees(row.included_angle):.4g}"
    coils = "" if row.body_coils is None else f"{row.body_coils:.4g}"
    return f"{rate:.4g}", f"{per_degree:.4g}", _deviation_text(off, wanted), *sizes, coils, angle


def _dampers(asked: RequestedDamper, wish: PartRequest, catalogue: Catalogue) -> FittingParts:
    parts = of_family(wish.parts, catalogue.dampers)
    fitting, others, unusable = [], [], Counter[str]()
    for row in catalogue.dampers:
        if not row.choosable:
            unusable[row.status] += 1
            continue
        found = list(_arrangements(row, asked, parts))
        if not found:
            reasons = list(damper_reasons(row, asked, 0.0, parts)) or ["it would have to turn beyond its range"]
            torque, offer = _torques(row, Arrangement(), asked)[0]
            off, label = (0.0, row.part) if asked.torque is None else (log(torque / asked.torque), offer.order)
            others.append(_not_fitting(label, row.vendor, off, asked.torque, row, reasons))
        for label, torque, pieces, reasons in found:
            off = 0.0 if asked.torque is None else log(torque / asked.torque)
            if reasons:
                others.append(_not_fitting(label, row.vendor, off, asked.torque, row, reasons))
            else:
                cells = (row.vendor, f"{torque:.4g}", f"{torque / 0.00706155:.4g}", _deviation_text(off, asked.torque))
                fitting.append(_Line(label, abs(off), (*cells, str(pieces), row.direction, row.status)))
    speed = _speed(asked)
    at = f"at {speed * 30 / pi:.4g} rpm of the joint"
    heads = ("damper", "vendor", f"torque {at} [N*m]", "torque [ozf*in]", "off", "pieces", "direction", "status")
    title = "dampers" if asked.torque is None else f"dampers of {asked.torque:.4g} N*m {at}"
    return _sorted_lines(title, heads, fitting, others, unusable)


def _speed(asked: RequestedDamper) -> float:
    return 1.0 if asked.speed is None else asked.speed


def _arrangements(
    row: DamperRow, asked: RequestedDamper, parts: PartsOptions
) -> Iterator[tuple[str, float, int, list[str]]]:
    """Label, torque (N m) at the joint's speed, number of pieces and reasons against it, for every arrangement."""
    for each in arrangements(row, asked.parallel, asked.ratios, asked.direction):
        turned = replace(asked, travel=(asked.travel or 0.0) * each.ratio or None, ratios=(1.0,))
        against = list(damper_reasons(row, turned, 0.0, parts))
        for torque, offer in _torques(row, each, asked):
            reasons = [*against]
            if asked.torque is not None and abs(torque / asked.torque - 1.0) > asked.torque_tolerance:
                reasons.append(f"torque not within {asked.torque_tolerance:.0%} of {asked.torque:.4g} N*m")
            yield each.words(offer.order), torque, each.pieces, reasons


def _torques(row: DamperRow, arrangement: Arrangement, asked: RequestedDamper) -> list[tuple[float, DamperRow]]:
    """Torque (N m) at the joint's speed, and the damper; of torques to order only the nearest to the wanted one."""
    found = [(_torque(arrangement.at_joint(offer.damper()), _speed(asked)), offer) for offer in offers(row)]
    wanted = asked.torque
    return found if wanted is None else [min(found, key=lambda item: abs(log(item[0] / wanted)))]


def _torque(damper: Damper, speed: float) -> float:
    if damper.curve is None:
        return (damper.rate or 0.0) * speed
    return float(torque_at(damper.curve, np.array([speed]))[0])


def _sorted_lines(
    title: str, heads: tuple[str, ...], fitting: list[_Line], others: list[_Line], unusable: Counter[str]
) -> FittingParts:
    near = [tuple(sorted(lines, key=lambda line: line.distance)) for lines in (fitting, others)]
    return FittingParts(title, heads, near[0], near[1], unusable)


def _lines(found: FittingParts) -> Iterator[str]:
    title, heads, fitting, others, unusable = found.title, found.heads, found.fitting, found.others, found.unusable
    yield f"{title}: {len(fitting)} fit" + (
        f", the nearest {MOST_ROWS}:" if len(fitting) > MOST_ROWS else ":" * bool(fitting)
    )
    if fitting:
        yield table_text([heads, *((line.part, *line.cells) for line in fitting[:MOST_ROWS])], words_last=True)
    yield f"{len(others)} do not" + (f", the nearest {MOST_ROWS}:" if len(others) > MOST_ROWS else ":" * bool(others))
    if others:
        rows = [OTHER_HEADS, *((line.part, *line.cells) for line in others[:MOST_ROWS])]
        yield table_text(rows, numbers_right=False)
    if len(others) > MOST_ROWS:
        reasons = Counter(reason for line in others[MOST_ROWS:] for reason in line.reasons)
        yield from (f"  {count} more: {reason}" for reason, count in reasons.most_common())
    if unusable:
        yield f"{sum(unusable.values())} rows that cannot be chosen:"
        yield from (f"  {count}: {status}" for status, count in unusable.most_common())
