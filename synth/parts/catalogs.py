"""The catalogues: built-in rows and the user's, found by part, listed, checked."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import TypeVar

from synth.errors import Problem, UserError, did_you_mean
from synth.parts.catalog_table import MAX_PROBLEMS, read_table
from synth.parts.catalogue_row import CatalogueRow
from synth.parts.material_names import KnownMaterials
from synth.parts.row_check import complete_row, completed_damper, contradictions, curve_problems, judge_row
from synth.parts.rows import FAMILIES, CurvePointRow, DamperRow, GearMotorRow, MaterialRow, TorsionSpringRow, WireRow
from synth.parts.usable import usable_damper, usable_spring
from synth.parts.wire import WireMaterial
from synth.units import factor

R = TypeVar("R", bound=CatalogueRow)
P = TypeVar("P", TorsionSpringRow, DamperRow, GearMotorRow)


def catalog_folder() -> Path:
    """The folder of the built-in CSVs: inside the package; in the repository a link to ``catalogs``."""
    return Path(__file__).resolve().parents[1] / "_catalogs"


@dataclass(frozen=True, repr=False)
class Catalogue:
    """All rows with their status."""

    springs: tuple[TorsionSpringRow, ...]
    dampers: tuple[DamperRow, ...]
    wires: tuple[WireRow, ...]
    materials: tuple[MaterialRow, ...]
    curves: tuple[CurvePointRow, ...]
    motors: tuple[GearMotorRow, ...] = ()

    def __repr__(self) -> str:
        """The number of rows of each family."""
        return f"Catalogue({', '.join(f'{len(rows)} {family}' for family, rows in vars(self).items())})"

    @classmethod
    def load(cls, extra: Sequence[Path] = ()) -> Catalogue:
        """The built-in catalogues and the user's files, of any family.

        A user's row replaces an earlier one of the same vendor and part; a user's curve points replace all
        earlier points of that part.

        Raises
        ------
        UserError
            With every bad cell, header or duplicate of the user's files.
        """
        rows, problems = _read_all(extra)
        catalogue, joining = _join(rows)
        if problems or joining:
            raise UserError([*problems, *joining])
        return catalogue

    def find_spring(self, part: str) -> TorsionSpringRow:
        """The spring with this part number; UserError with similar names if there is none."""
        return _find(self.springs, part, "spring")

    def find_damper(self, part: str) -> DamperRow:
        """The damper with this part number; UserError with similar names if there is none."""
        return _find(self.dampers, part, "damper")

    def find_motor(self, part: str) -> GearMotorRow:
        """The gear motor with this part number; UserError with similar names if there is none."""
        return _find(self.motors, part, "gear motor")

    def find_material(self, name: str) -> WireMaterial:
        """A wire material by its name or a usual spelling (``music``, ``ASTM A228``); UserError with similar names."""
        known = self.known_materials
        material = known.material(name)
        if material is None:
            raise UserError(
                f'no wire material "{name}"{known.similar(name)}; known materials: {", ".join(known.names)}'
            )
        return material

    @cached_property
    def known_materials(self) -> KnownMaterials:
        """The wire materials, by any of their spellings."""
        return KnownMaterials(self.materials, self.wires)

    def rows(self, family: str) -> tuple[CatalogueRow, ...]:
        """All rows of a family; UserError with similar names for an unknown one."""
        families: dict[str, tuple[CatalogueRow, ...]] = {
            "torsion_springs": self.springs,
            "dampers": self.dampers,
            "damper_curves": self.curves,
            "wire_diameters": self.wires,
            "wire_materials": self.materials,
            "gearmotors": self.motors,
        }
        if family not in families:
            raise UserError(
                f'no catalogue "{family}"{_spellings(family, list(families))}; there are {", ".join(families)}'
            )
        return families[family]


@dataclass(frozen=True)
class CatalogueTable:
    """Rows of a family as text, headers with units; columns without any value are left out."""

    family: str
    header: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]


def catalogue_rows_as_table(family: str, catalogue: Catalogue | None = None) -> CatalogueTable:
    """A family as a table for the screen: identity first, then values in their usual units, then status."""
    rows = (catalogue or Catalogue.load()).rows(family)
    columns = list(FAMILIES[family].columns())
    last = ("status", "note", "as_published", "source")
    columns.sort(key=lambda item: last.index(item.name) if item.name in last else -1)
    header: list[str] = []
    cells: list[list[str]] = []
    for item in columns:
        unit, shown = item.metadata["unit"], item.metadata.get("shown", "")
        scale = 1.0 if unit is None or unit == shown else factor(shown, unit)
        values = [getattr(row, item.name) for row in rows]
        texts = ["" if v is None else v if isinstance(v, str) else f"{v / scale:.6g}" for v in values]
        if any(texts):
            header.append(item.name if unit is None else f"{item.name} [{shown}]")
            cells.append(texts)
    return CatalogueTable(family, tuple(header), tuple(zip(*cells, strict=True)))


def check_catalogue(paths: Sequence[Path] = ()) -> list[Problem]:
    """All mistakes of the given files, or of the built-in ones.

    Bad cells and headers, duplicates, contradicting values, unknown materials. An incomplete row
    is not a mistake: its status states what it lacks.
    """
    rows, problems = _read_all(paths)
    catalogue, joining = _join(rows)
    names = {str(path) for path in paths}
    known = catalogue.known_materials
    for family in FAMILIES:
        for row in catalogue.rows(family):
            if names and row.file not in names:
                continue
            for text in contradictions(row, known):
                problems.append(Problem(text, file=row.file, line=row.line, key=getattr(row, "part", None) or None))
            material = getattr(row, "material", "")
            if material and (text := known.fault(material)):
                problems.append(Problem(text, file=row.file, line=row.line, key="material"))
    return [*problems, *joining]


@lru_cache(maxsize=1)
def _built_in() -> tuple[CatalogueRow, ...]:
    folder = catalog_folder()
    rows: list[CatalogueRow] = []
    for family in FAMILIES:
        table = read_table(folder / f"{family}.csv", shown=f"catalogs/{family}.csv")
        if table.problems:
            raise ValueError("\n".join(str(problem) for problem in table.problems))  # our mistake, not the user's
        rows.extend(table.rows)
    return tuple(rows)


def _read_all(extra: Sequence[Path]) -> tuple[list[CatalogueRow], list[Problem]]:
    rows: list[CatalogueRow] = list(_built_in())
    problems: list[Problem] = []
    for path in extra:
        table = read_table(Path(path))
        rows.extend(table.rows)
        problems.extend(table.problems)
    return rows, problems


def _join(rows: Iterable[CatalogueRow]) -> tuple[Catalogue, list[Problem]]:
    """Combine the rows of all files: replaced parts, curves with their dampers, statuses."""
    rows = list(rows)
    problems: list[Problem] = []
    none = KnownMaterials(())  # rows of wire and materials are judged by themselves
    materials = tuple(judge_row(row, none) for row in _rows_of_type(rows, MaterialRow))
    wires = tuple(judge_row(row, none) for row in _rows_of_type(rows, WireRow))
    known = KnownMaterials(materials, wires)

    def finished(kept: Sequence[R]) -> tuple[R, ...]:
        return tuple(judge_row(row, known) for row in kept)

    springs = _latest([complete_row(row) for row in _rows_of_type(rows, TorsionSpringRow)], problems)
    dampers = _latest([completed_damper(row) for row in _rows_of_type(rows, DamperRow)], problems)
    curves = finished(_rows_of_type(rows, CurvePointRow))
    motors = finished(_latest(_rows_of_type(rows, GearMotorRow), problems))
    with_curves = _with_curves(dampers, curves, problems)
    catalogue = Catalogue(
        tuple(usable_spring(row, known) for row in finished(springs)),
        tuple(usable_damper(row, known) for row in finished(with_curves)),
        wires,
        materials,
        curves,
        motors,
    )
    return catalogue, problems


def _rows_of_type(rows: Iterable[CatalogueRow], row_type: type[R]) -> list[R]:
    return [row for row in rows if isinstance(row, row_type)]


def _latest(rows: Sequence[P], problems: list[Problem]) -> list[P]:
    """One row per vendor and part: a later file's replaces an earlier one's; twice in one file is a mistake."""
    kept: dict[tuple[str, str], P] = {}
    for row in rows:
        key = (row.vendor.casefold(), row.part.casefold())
        before = kept.get(key)
        if before is not None and before.file == row.file:
            text = f"{row.vendor} {row.part}".strip() + f" is given twice in this file, first in line {before.line}"
            problems.append(Problem(text, file=row.file, line=row.line, key="part"))
        kept[key] = row if before is None else replace(row, note=f"replaces {before.place}. {row.note}".strip())
    return list(kept.values())


def _with_curves(
    dampers: Sequence[DamperRow], curves: Sequence[CurvePointRow], problems: list[Problem]
) -> list[DamperRow]:
    """Assign each damper its curve: the points of the last file that has any for it."""
    sold = {(vendor, row.part.casefold()) for row in dampers for vendor in ("", row.vendor.casefold())}
    points: dict[tuple[str, str], list[tuple[int, CurvePointRow]]] = {}
    for order, point in enumerate(curves):
        key = (point.vendor.casefold(), point.part.casefold())
        if key not in sold and key not in points and len(problems) < MAX_PROBLEMS:
            spellings = _spellings(point.part, [row.part for row in dampers])
            text = f'"{point.part}" is not a damper of the catalogues{spellings}'
            problems.append(Problem(text, file=point.file, line=point.line, key="part"))
        points.setdefault(key, []).append((order, point))
    joined: list[DamperRow] = []
    for damper in dampers:
        part = damper.part.casefold()
        keys = dict.fromkeys((("", part), (damper.vendor.casefold(), part)))
        found = sorted((item for key in keys for item in points.get(key, [])), key=lambda item: item[0])
        own = [point for _, point in found]
        own = sorted((point for point in own if point.file == own[-1].file), key=lambda point: point.speed or 0.0)
        for text in curve_problems(own):
            problems.append(Problem(text, file=own[0].file, line=own[0].line, key=damper.part))
        speeds = tuple(point.speed for point in own if point.speed is not None)
        torques = tuple(point.torque for point in own if point.torque is not None)
        joined.append(replace(damper, curve_speed=speeds, curve_torque=torques))
    return joined


def _find(rows: Sequence[P], part: str, kind: str) -> P:
    wanted = part.strip().casefold()
    found = [row for row in rows if row.part.casefold() == wanted]
    if len(found) == 1:
        return found[0]
    if found:
        raise UserError(f'"{part}" is a {kind} of {" and of ".join(row.vendor or row.place for row in found)}')
    raise UserError(f'no {kind} "{part}" in the catalogues{_spellings(part, [row.part for row in rows])}')


def _spellings(name: str, known: Sequence[str]) -> str:
    return did_you_mean(name, known, most=3)
