"""Spring wire: stock sizes, strength from the maker's table, modulus, yield in bending."""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

from synth.errors import UserError
from synth.parts.rows import MaterialRow, WireRow

WIRE_TOLERANCE = 0.005  # of the diameter, if no list states one: music wire has 0.3 to 1.2 %
SAME_SIZE = 1e-3  # two diameters this near (relative) are equal: 0.1 % is a tenth of the tolerance


@dataclass(frozen=True)
class Strength:
    """Tensile strength of one wire size, Pa, with its source.

    ``basis``: ``table`` (the maker's minimum for this size), ``interpolated`` between two sizes of that table, or
    ``law`` (a fitted law, if no table covers this size: less certain).
    """

    value: float
    basis: Literal["table", "interpolated", "law"]
    source: str


@dataclass(frozen=True)
class Fatigue:
    """Fatigue limit in bending from zero for a number of cycles, as a fraction of the strength, stress relieved."""

    at_1e5: float
    at_1e6: float
    source: str


# The wire of EN 10270 for the same use. The catalogue has no stainless wire of EN 10270-3.
EN_GRADE = {
    "music wire": "EN 10270-1 SH",
    "hard drawn": "EN 10270-1 SM",
    "oil tempered": "EN 10270-2 FDC",
    "chrome vanadium": "EN 10270-2 FDCrV",
    "chrome silicon": "EN 10270-2 FDSiCr",
}


@dataclass(frozen=True)
class Allowable:
    """Greatest static bending stress by one ``code``, Pa, with its source; ``synth.spring.codes`` has the stress."""

    code: str
    stress: float
    source: str


@dataclass(frozen=True)
class WireProperties:
    """Wire of one size: modulus Pa, strength, yield in bending as a fraction of it, density kg/m^3."""

    elastic_modulus: float
    strength: Strength
    static_limit: float
    static_source: str
    density: float
    diameter_tolerance: float
    fatigue: Fatigue | None = None
    allowables: tuple[Allowable, ...] = ()


@dataclass(frozen=True)
class WireMaterial:
    """The catalogues' data of one wire material.

    ``records``: its rows of the materials; ``table``: its sizes with a strength, by diameter, weakest grade first;
    ``sizes``: stock sizes of it, by diameter; ``grade``: rows of the wire of EN 10270
    for the same use.
    """

    name: str
    records: tuple[MaterialRow, ...]
    table: tuple[WireRow, ...]
    sizes: tuple[WireRow, ...]
    grade: tuple[MaterialRow, ...] = ()

    def elastic_modulus(self, diameter: float) -> float | None:
        """Young's modulus, Pa, for wire of ``diameter`` m.

        Textbook rows have priority. Their inch ranges leave gaps of a thousandth, so the row nearest in
        diameter is used.
        """
        sound = [row for row in self.records if row.elastic_modulus is not None and row.sound]
        rows = [row for row in sound if row.record == "modulus"] or sound
        return min(rows, key=lambda row: _outside(row, diameter)).elastic_modulus if rows else None

    @property
    def density(self) -> float | None:
        """kg/m^3."""
        return next((row.density for row in self.records if row.density is not None), None)

    @property
    def static_limit(self) -> tuple[float, str] | None:
        """Yield in bending as a fraction of the tensile strength, and its source."""
        rows = [row for row in self.records if row.static_bending_limit is not None and row.complete]
        rows.sort(key=lambda row: row.record != "static bending limit")  # its own row before a maker's list
        for row in rows:
            assert row.static_bending_limit is not None
            return row.static_bending_limit, row.source
        return None

    @property
    def fatigue(self) -> Fatigue | None:
        """Fatigue limits; None if no source has them."""
        for row in sorted(self.records, key=lambda row: row.record != "repeated bending limit"):
            low, high = row.repeated_bending_limit_1e5, row.repeated_bending_limit_1e6
            if low is not None and high is not None and row.complete:
                return Fatigue(low, high, row.source)
        return None

    def diameter_tolerance(self, diameter: float) -> float:
        """Tolerance, m: that of the listed size nearest in diameter, else half a per cent."""
        rows = [row for row in self.sizes if row.diameter_tolerance is not None and row.diameter is not None]
        near = min(rows, key=lambda row: abs((row.diameter or 0.0) - diameter), default=None)
        if near is None or near.diameter_tolerance is None or near.diameter is None:
            return WIRE_TOLERANCE * diameter
        return near.diameter_tolerance

    def properties(self, diameter: float) -> WireProperties:
        """All data for a design with wire of ``diameter`` m.

        Raises
        ------
        UserError
            Naming the unknown values of this size, and the sizes with known ones.
        """
        known = self._properties.get(diameter)
        if known is None:
            known = self._properties[diameter] = self._gathered(diameter)
        return known

    @cached_property
    def _properties(self) -> dict[float, WireProperties]:
        """Earlier results by diameter: a search needs each stock size a thousand times."""
        return {}

    def _gathered(self, diameter: float) -> WireProperties:
        modulus, strength = self.elastic_modulus(diameter), self.tensile_strength(diameter)
        limit, density = self.static_limit, self.density
        if modulus is None or strength is None or limit is None or density is None:
            known = {"modulus": modulus, "strength": strength, "yield in bending": limit, "density": density}
            lacking = " and no ".join(name for name, value in known.items() if value is None)
            sizes = [row.diameter * 1e3 for row in self.stock() if row.diameter]
            stock = f"; sizes with a strength are {sizes[0]:.4g} to {sizes[-1]:.4g} mm" if sizes else ""
            raise UserError(f"no {lacking} known for {self.name} wire of {diameter * 1e3:.4g} mm{stock}")
        return WireProperties(
            modulus,
            strength,
            *limit,
            density,
            self.diameter_tolerance(diameter),
            self.fatigue,
            self.allowables(diameter, strength, limit),
        )

    def allowables(self, diameter: float, strength: Strength, limit: tuple[float, str]) -> tuple[Allowable, ...]:
        """The allowed stress by each code known for this wire, the design code first."""
        found = [Allowable("Shigley", limit[0] * strength.value, limit[1])]
        for code, rows in (("spring makers' handbook", self.records), ("EN 13906-3", self.grade)):
            for row in rows:
                share, value = row.static_bending_limit, row.strength(diameter)
                if row.complete and share is not None and value is not None:
                    text = f"{share:.0%} of {value / 1e6:.0f} MPa, {row.material}; {row.source}"
                    found.append(Allowable(code, share * value, text))
                    break
        return tuple(found)

    def tensile_strength(self, diameter: float) -> Strength | None:
        """Minimum tensile strength of wire of ``diameter`` m; None if neither table nor law covers it."""
        return self._from_table(diameter) or self._from_law(diameter)

    def _from_table(self, diameter: float) -> Strength | None:
        sizes = [row.diameter or 0.0 for row in self.table]
        above = bisect_left(sizes, diameter * (1.0 - SAME_SIZE))
        if above == len(sizes):
            return None
        thick = self.table[above]
        assert thick.min_tensile_strength is not None
        if abs(sizes[above] / diameter - 1.0) <= SAME_SIZE:
            source = f"{thick.series}, {thick.as_published}; {thick.source}"
            return Strength(thick.min_tensile_strength, "table", source)
        if above == 0:
            return None
        thin = self.table[above - 1]
        assert thin.min_tensile_strength is not None
        share = (diameter - sizes[above - 1]) / (sizes[above] - sizes[above - 1])
        value = thin.min_tensile_strength + share * (thick.min_tensile_strength - thin.min_tensile_strength)
        between = f"between {sizes[above - 1] * 1e3:.4g} and {sizes[above] * 1e3:.4g} mm"
        return Strength(value, "interpolated", f"{thick.series}, {between}; {thick.source}")

    def _from_law(self, diameter: float) -> Strength | None:
        """The lowest of the laws that cover this size: they differ by up to 10 %, and only a table is certain."""
        found = [
            (value, row)
            for row in self.records
            if row.complete and row.covers(diameter) and (value := row.strength(diameter)) is not None
        ]
        if not found:
            return None
        value, row = min(found, key=lambda item: item[0])
        return Strength(value, "law", f"{row.record} of {row.name_as_published}; {row.source}")

    def stock(self, system: str | None = None) -> tuple[WireRow, ...]:
        """Stock sizes of known strength, one row per size, by diameter. ``system``: ``inch``, ``metric`` or both.

        For a material with a strength table only sizes inside the table are stock.
        """
        if system not in self._stocks:
            self._stocks[system] = self._stock_of(system)
        return self._stocks[system]

    @cached_property
    def _stocks(self) -> dict[str | None, tuple[WireRow, ...]]:
        """Earlier results by system."""
        return {}

    def _stock_of(self, system: str | None) -> tuple[WireRow, ...]:
        chosen: list[WireRow] = []
        for row in self.sizes:
            if row.diameter is None or (system is not None and row.system != system):
                continue
            if chosen and row.diameter <= (chosen[-1].diameter or 0.0) * (1.0 + SAME_SIZE):
                continue
            known = self._from_table(row.diameter) if self.table else self._from_law(row.diameter)
            if known is not None:
                chosen.append(row)
        return tuple(chosen)


def wire_material(name: str, materials: tuple[MaterialRow, ...], wires: tuple[WireRow, ...]) -> WireMaterial:
    """Collect the data of a material by its catalogue name."""
    records = tuple(row for row in materials if row.material == name)
    strong = [row for row in wires if row.material == name and row.min_tensile_strength is not None and row.diameter]
    weakest: dict[float, WireRow] = {}
    for row in strong:
        assert row.diameter is not None
        assert row.min_tensile_strength is not None
        other = weakest.get(row.diameter)
        if other is None or row.min_tensile_strength < (other.min_tensile_strength or 0.0):
            weakest[row.diameter] = row
    own = [row for row in wires if row.diameter and row.material == name]
    # Lists for any material apply if the material has no inch list of its own; metric sizes always apply.
    general = [row for row in wires if row.diameter and not row.material and (row.system == "metric" or not own)]
    sizes = sorted([*own, *general], key=lambda row: (row.diameter or 0.0, row.min_tensile_strength is None))
    grade = tuple(row for row in materials if row.material == EN_GRADE.get(name))
    return WireMaterial(name, records, tuple(weakest[key] for key in sorted(weakest)), tuple(sizes), grade)


def _outside(row: MaterialRow, diameter: float) -> float:
    """Distance of a diameter from a record's range, m; 0 inside."""
    below = (row.min_diameter or 0.0) - diameter
    above = diameter - row.max_diameter if row.max_diameter is not None else 0.0
    return max(below, above, 0.0)
