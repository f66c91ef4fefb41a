"""Output of ``synth catalog --json``: rows with units, substitutes, parts that fit a request, imported tables."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from synth.units import factor

if TYPE_CHECKING:
    from synth.parts.alike import Substitute
    from synth.parts.catalog_import import ImportedParts
    from synth.parts.catalogs import Catalogue
    from synth.parts.catalogue_row import CatalogueRow
    from synth.parts.import_folder import PlacedParts

FORMAT = "synth/catalog/1"
STATES = ("complete", "usable", "incomplete", "contradiction")


def families_json(catalogue: Catalogue) -> dict[str, Any]:
    """Number of rows of each family, by status."""
    from synth.parts.rows import FAMILIES

    return {"format": FORMAT, "families": [family_counts(family, catalogue) for family in FAMILIES]}


def family_counts(family: str, catalogue: Catalogue) -> dict[str, Any]:
    """A family's rows by status."""
    found = Counter[str](row.state for row in catalogue.rows(family))
    counts = {state: found[state] for state in STATES}
    return {"family": family, "rows": found.total(), **counts, "other": found.total() - sum(counts.values())}


def rows_json(rows: Iterable[CatalogueRow]) -> dict[str, Any]:
    """Rows in full: each value with its unit, its source and its place in the file."""
    return {"format": FORMAT, "rows": [row_json(row) for row in rows]}


def row_json(row: CatalogueRow) -> dict[str, Any]:
    """One row without empty cells; ``assumed`` : its columns whose value is not the table's."""
    found: dict[str, Any] = {"family": row.family}
    for item in type(row).columns():
        value, unit = getattr(row, item.name), item.metadata["unit"]
        if value is None or value == "":
            continue
        if unit is None or isinstance(value, str):
            found[item.name] = value
            continue
        shown = item.metadata.get("shown", unit)
        found[item.name] = {"value": value / (1.0 if unit == shown else factor(shown, unit)), "unit": shown}
    if assumed := getattr(row, "assumed", ()):
        found["assumed"] = list(assumed)
    return {**found, "place": row.place}


def alike_json(part: str, found: Sequence[Substitute]) -> dict[str, Any]:
    """Substitutes, nearest first."""
    rows = [
        {"part": item.row.part, "vendor": item.row.vendor, "distance": item.distance, "differs": list(item.differs)}
        for item in found
    ]
    return {"format": FORMAT, "part": part, "alike": rows}


def imported_json(table: ImportedParts, placed: PlacedParts) -> dict[str, Any]:
    """Result of importing a vendor's table; ``gone``: by file, the parts of its earlier import that it lacks now."""
    return {
        "format": FORMAT,
        "files": [str(file) for file in placed.files],
        "columns": [{"theirs": theirs, "ours": ours} for theirs, ours in table.used],
        "not_used": list(table.unused),
        "rows": placed.rows,
        "choosable": placed.choosable,
        "gone": {file: list(parts) for file, parts in placed.gone.items()},
    }
