"""Standard parts of the joints, from the tables in ``catalogs/``.

The tables have standards, sizes and sources; this module selects a size.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from synth.cad.limits import DimensionError, DimensionProblem

ROUNDING = 1e-9  # mm, rounding error of sums of dimensions
PIN_SHARE = 0.34  # of a shaft's diameter: largest cross pin; a quarter to a third is the usual rule


def _shortest_length(lengths: Sequence[float], wanted: float) -> float | None:
    return next((length for length in lengths if length >= wanted - ROUNDING), None)


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
        found = _shortest_length(self.lengths, wanted)
        if found is None:
            text = f"at most {self.lengths[-1]:g} mm with M{self.size:g}"
            raise DimensionError(DimensionProblem("screw length", wanted, text, f"{self.standard} ends there"))
        return found


@dataclass(frozen=True)
class Insert:
    """A heat-set insert; mm."""

    standard: str
    maker: str
    size: float
    hole: float  # diameter of the printed hole
    length: float


@dataclass(frozen=True)
class Nut:
    """A hexagon nut; mm."""

    standard: str
    size: float
    across_flats: float
    height: float


@dataclass(frozen=True)
class Bearing:
    """A deep groove ball bearing; mm, N and g."""

    standard: str
    designation: str
    sold_as: str
    bore: float
    outer_diameter: float
    width: float
    static_load: float
    mass: float


@dataclass(frozen=True)
class Collar:
    """A shaft collar with a set screw; mm."""

    standard: str
    bore: float
    outer_diameter: float
    width: float
    set_screw: float


@dataclass(frozen=True)
class Shim:
    """A shim ring, here a thrust washer; mm."""

    standard: str
    bore: float
    outer_diameter: float
    thickness: float


@dataclass(frozen=True)
class Pin:
    """A dowel pin in a length; mm."""

    standard: str
    size: float
    length: float


@dataclass(frozen=True)
class ShaftParts:
    """The parts on a stock rod that make it a hinge's shaft, equal on both sides."""

    bearing: Bearing
    collar: Collar
    washer: Shim
    pin: float  # diameter of cross pins, mm

    @property
    def stack(self) -> float:
        """Stack of thrust washer and collar along the shaft, mm."""
        return self.washer.thickness + self.collar.width

    @property
    def radius(self) -> float:
        """The larger of both, mm."""
        return max(self.collar.outer_diameter, self.washer.outer_diameter) / 2


def table(family: str) -> list[dict[str, str]]:
    """The rows of ``catalogs/<family>.csv``, with units removed from the headers."""
    path = Path(__file__).parents[1] / "_catalogs" / f"{family}.csv"
    with path.open(encoding="utf-8", newline="") as file:
        return [{key.split(" [")[0]: value for key, value in row.items()} for row in csv.DictReader(file)]


def _screws(family: str) -> tuple[Screw, ...]:
    washers = {float(row["size"]): row for row in table("plain_washers")}
    found = []
    for row in table(family):
        washer = washers.get(float(row["size"]), {"outer_diameter": row["head_diameter"], "thickness": "0"})
        found.append(
            Screw(
                standard=row["standard"],
                size=float(row["size"]),
                head_diameter=float(row["head_diameter"]),
                head_height=float(row["head_height"]),
                hole=float(row["hole"]),
                lengths=tuple(float(length) for length in row["lengths"].split()),
                washer=float(washer["outer_diameter"]),
                washer_thickness=float(washer["thickness"]),
            )
        )
    return tuple(found)


@cache
def screws() -> tuple[Screw, ...]:
    """Machine screws with low heads, smallest first."""
    return _screws("machine_screws")


@cache
def socket_screws() -> tuple[Screw, ...]:
    """Socket head screws, smallest first; the long ones."""
    return _screws("socket_screws")


@cache
def inserts() -> dict[float, Insert]:
    """Heat-set inserts by their nominal size."""
    return {
        float(row["size"]): Insert(
            row["standard"], row["maker"], float(row["size"]), float(row["hole"]), float(row["length"])
        )
        for row in table("heat_set_inserts")
    }


@cache
def nuts() -> dict[float, Nut]:
    """Hexagon nuts by their nominal size."""
    return {
        float(row["size"]): Nut(row["standard"], float(row["size"]), float(row["across_flats"]), float(row["height"]))
        for row in table("hexagon_nuts")
    }


@cache
def bearings() -> tuple[Bearing, ...]:
    """Ball bearings, by bore and then by outside diameter."""
    found = [
        Bearing(
            row["standard"], row["designation"], row["sold_as"], float(row["bore"]), float(row["outer_diameter"]),
            float(row["width"]), float(row["static_load"]), float(row["mass"]),
        )
        for row in table("ball_bearings")
    ]  # fmt: skip
    return tuple(sorted(found, key=lambda bearing: (bearing.bore, bearing.outer_diameter)))


@cache
def _collars() -> dict[float, Collar]:
    return {
        float(row["bore"]): Collar(
            row["standard"], float(row["bore"]), float(row["outer_diameter"]), float(row["width"]),
            float(row["set_screw"]),
        )
        for row in table("shaft_collars")
    }  # fmt: skip


@cache
def _shims() -> dict[float, Shim]:
    return {
        float(row["bore"]): Shim(
            row["standard"], float(row["bore"]), float(row["outer_diameter"]), float(row["thickness"])
        )
        for row in table("shim_rings")
    }


@cache
def _pins() -> dict[float, tuple[str, tuple[float, ...]]]:
    return {
        float(row["size"]): (row["standard"], tuple(float(length) for length in row["lengths"].split()))
        for row in table("dowel_pins")
    }


@cache
def shaft_sizes() -> tuple[float, ...]:
    """Diameters (mm) of rods for which bearings, collars and thrust washers are in the tables, smallest first."""
    bores = {bearing.bore for bearing in bearings()}
    return tuple(sorted(bores & _collars().keys() & _shims().keys()))


@cache
def shaft_parts(diameter: float) -> ShaftParts:
    """Bearing (the smallest of its bore), collar, thrust washer and pin for a rod of ``diameter`` mm.

    Raises
    ------
    KeyError
        where the tables have none; see :func:`shaft_sizes`.
    """
    bearing = next((bearing for bearing in bearings() if bearing.bore == diameter), None)
    if bearing is None:
        raise KeyError(diameter)
    return ShaftParts(bearing, _collars()[diameter], _shims()[diameter], pin_size(diameter))


def pin_size(shaft: float) -> float:
    """Diameter (mm) of the pin through a shaft: the largest sold up to a third of the shaft's."""
    return max(size for size in _pins() if size <= PIN_SHARE * shaft + ROUNDING or size == min(_pins()))


def pin_at_least(size: float, length: float) -> Pin | None:
    """The shortest dowel pin of a ``size`` that is at least ``length`` mm long; None if none is sold."""
    standard, lengths = _pins()[size]
    found = _shortest_length(lengths, length)
    return None if found is None else Pin(standard, size, found)


def screw_of(size: float) -> Screw:
    """The smallest screw of at least ``size`` mm; the largest if there is none."""
    return next((screw for screw in screws() if screw.size >= size - ROUNDING), screws()[-1])


def screw_through(hole: float) -> Screw | None:
    """The largest screw for a hole of ``hole`` mm with a clearance of 0.2 mm; None if there is none."""
    found = [screw for screw in screws() if screw.size + 0.2 <= hole + ROUNDING]
    return found[-1] if found else None


def long_screw(least: float, grip: float) -> tuple[Screw, float] | None:
    """The smallest socket screw of at least ``least`` mm that is sold long enough for ``grip`` mm and its nut.

    Returned with its length; two threads protrude from the nut. None if no such screw is sold.
    """
    for screw in socket_screws():
        if screw.size < least - ROUNDING:
            continue
        nut = nuts()[screw.size]
        length = _shortest_length(screw.lengths, grip + nut.height + 0.3 * screw.size)
        if length is not None:
            return screw, length
    return None


def insert_of(size: float) -> Insert:
    """The insert for a screw of a nominal ``size`` that the tables have."""
    return inserts()[size]
