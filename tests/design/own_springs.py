"""A bought spring of a test's own, as a user's catalogue has it."""

from __future__ import annotations

from pathlib import Path

from synth.parts.catalogs import Catalogue
from synth.parts.rows import TorsionSpringRow

HEADER = (
    "part,vendor,material,included_angle [deg],rate [N*m/rad],wire_diameter [mm],outer_diameter [mm],body_coils [1]\n"
)


def own_spring(
    folder: Path, rate: float, wire: float, outer: float, coils: float
) -> tuple[Catalogue, TorsionSpringRow]:
    """All springs with one more, of music wire with arms at 120 deg, and its row; N m/rad, mm."""
    path = folder / "mine.csv"
    path.write_text(f"{HEADER}OWN,Mine,music wire,120,{rate},{wire},{outer},{coils:.4f}\n", encoding="utf-8")
    whole = Catalogue.load([path])
    (row,) = (row for row in whole.springs if row.part == "OWN")
    return whole, row
