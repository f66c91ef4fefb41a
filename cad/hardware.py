"""Screws, inserts and washers that the joints are put together with, from the tables in ``catalogs/``.

Standards and sizes stand in the tables; here is only how a size is picked.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from cad.limits import DimensionError, DimensionProblem


@dataclass(frozen=True)
class Screw:
    """A machine screw with its washer; mm."""

    standard: str
    size: float  # nominal
    head_diameter: float
    head_height: float
    hole: float  # clearance
    lengths: tuple[float, ...]
    washer: float  # outer diameter
    washer_thickness: float

    def length_at_least(self, wanted: float) -> float:
        """The shortest length sold that is not below ``wanted`` mm.

        Raises
        ------
        DimensionError
            where none is sold that long.
        """
        found = [length for length in self.lengths if length >= wanted - 1e-9]
        if not found:
            text = f"at most {self.lengths[-1]:g} mm with M{self.size:g}"
            raise DimensionError(DimensionProblem("screw length", wanted, text, f"{self.standard} ends there"))
        return found[0]


@dataclass(frozen=True)
class Insert:
    """A heat-set insert; mm."""

    standard: str
    size: float
    hole: float  # diameter of the printed hole
    length: float


def table(family: str) -> list[dict[str, str]]:
    """The rows of ``catalogs/<family>.csv``, the units of the headers left out."""
    here = Path(__file__).resolve().parent.parent
    for folder in (here / "catalogs", here / "synth" / "_catalogs"):
        path = folder / f"{family}.csv"
        if path.is_file():
            with path.open(encoding="utf-8", newline="") as file:
                return [{key.split(" [")[0]: value for key, value in row.items()} for row in csv.DictReader(file)]
    raise FileNotFoundError(f"{family}.csv is neither in {here / 'catalogs'} nor in {here / 'synth' / '_catalogs'}")


@cache
def screws() -> tuple[Screw, ...]:
    """Machine screws, smallest first."""
    washers = {float(row["size"]): row for row in table("plain_washers")}
    return tuple(
        Screw(
            standard=row["standard"],
            size=float(row["size"]),
            head_diameter=float(row["head_diameter"]),
            head_height=float(row["head_height"]),
            hole=float(row["hole"]),
            lengths=tuple(float(length) for length in row["lengths"].split()),
            washer=float(washers[float(row["size"])]["outer_diameter"]),
            washer_thickness=float(washers[float(row["size"])]["thickness"]),
        )
        for row in table("machine_screws")
    )


@cache
def inserts() -> dict[float, Insert]:
    """Heat-set inserts by their nominal size."""
    return {
        float(row["size"]): Insert(row["standard"], float(row["size"]), float(row["hole"]), float(row["length"]))
        for row in table("heat_set_inserts")
    }


def screw_of(size: float) -> Screw:
    """The smallest screw of at least ``size`` mm; the largest where there is none."""
    return next((screw for screw in screws() if screw.size >= size - 1e-9), screws()[-1])


def insert_of(size: float) -> Insert:
    """The insert for a screw of a nominal ``size`` that the tables have."""
    return inserts()[size]
