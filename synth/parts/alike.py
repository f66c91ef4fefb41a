"""Substitutes for a part: other rows of its family, by distance, with the differing dimensions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from synth.parts.catalogs import Catalogue
from synth.parts.material_names import KnownMaterials
from synth.parts.rows import DamperRow, TorsionSpringRow
from synth.swing.damper_curves import torque_at

SAME_SIZE = 0.02  # relative: makers round sizes to two or three digits
# Weights of differences: a spring's rate and a damper's torque determine the motion, sizes the fit in the joint.
WEIGHTS = {"rate": 3.0, "torque": 3.0, "outer diameter": 1.0, "inside diameter": 1.0, "body length": 0.5, "wire": 0.5}
UNKNOWN = 0.5  # of a dimension that one of the two rows does not state
ANOTHER = 0.5  # of another winding hand, direction, material or travel


@dataclass(frozen=True)
class Substitute:
    """One substitute: ``distance`` weighs relative differences; ``differs`` has each dimension in words."""

    row: TorsionSpringRow | DamperRow
    distance: float
    differs: tuple[str, ...]


def find_substitutes(catalogue: Catalogue, row: TorsionSpringRow | DamperRow, most: int = 12) -> tuple[Substitute, ...]:
    """Rows that may replace a part, nearest first."""
    rows: Sequence[TorsionSpringRow | DamperRow]
    rows = catalogue.springs if isinstance(row, TorsionSpringRow) else catalogue.dampers
    known = catalogue.known_materials
    found = [_compare_rows(row, other, known) for other in rows if other.choosable and other is not row]
    return tuple(sorted(found, key=lambda item: item.distance)[:most])


def _compare_rows(
    row: TorsionSpringRow | DamperRow, other: TorsionSpringRow | DamperRow, known: KnownMaterials
) -> Substitute:
    distance, differs = 0.0, []
    theirs = _numbers(other)
    for name, value in _numbers(row).items():
        against = theirs.get(name)
        if value is None and against is None:
            continue
        if value is None or against is None:
            distance += UNKNOWN * WEIGHTS[name]
            differs.append(f"{name} not stated" if against is None else f"{name} not comparable")
            continue
        off = math.log(against / value)
        distance += WEIGHTS[name] * abs(off)
        if abs(off) > SAME_SIZE:
            differs.append(f"{name} {against / value - 1.0:+.0%}")
    for name, mine, its in _words(row, other, known):
        if mine != its:
            distance += ANOTHER
            differs.append(f"{name} {its or 'not stated'}")
    return Substitute(other, distance, tuple(differs))


def _numbers(row: TorsionSpringRow | DamperRow) -> dict[str, float | None]:
    if isinstance(row, TorsionSpringRow):
        return {
            "rate": row.rate, "outer diameter": row.outer_diameter, "inside diameter": row.inside,
            "body length": row.body_length or row.close_wound_length, "wire": row.wire_diameter,
        }  # fmt: skip
    return {"torque": _torque(row), "outer diameter": row.outer_diameter}


def _torque(row: DamperRow) -> float | None:
    """Torque at 1 rad/s, N m, by the row's law, because vendors state it at different speeds."""
    if row.max_torque is None or row.speed is None:
        return row.max_torque
    return float(torque_at(row.torque_speed(), np.array([1.0]))[0])


def _words(
    row: TorsionSpringRow | DamperRow, other: TorsionSpringRow | DamperRow, known: KnownMaterials
) -> list[tuple[str, str, str]]:
    if isinstance(row, TorsionSpringRow) and isinstance(other, TorsionSpringRow):
        angles = [
            "" if each.included_angle is None else f"{math.degrees(each.included_angle):.0f} deg"
            for each in (row, other)
        ]
        materials = [known.name(each) or each for each in (row.material, other.material)]
        return [
            ("included angle", angles[0], angles[1]),
            ("hand", row.hand, other.hand),
            ("material", materials[0], materials[1]),
        ]
    assert isinstance(row, DamperRow)
    assert isinstance(other, DamperRow)
    travels = [_travel(each) for each in (row, other)]
    return [("direction", row.direction, other.direction), ("travel", travels[0], travels[1])]


def _travel(row: DamperRow) -> str:
    if row.continuous == "yes":
        return "without end"
    return "" if row.travel is None else f"{math.degrees(row.travel):.0f} deg"
