"""``synth catalog``: list, show, check and import catalogue rows of parts and wire.

synth catalog list                    every family with its number of usable rows
synth catalog list dampers            the rows of one family
synth catalog show 6597K19            all values of one part, derived values and sources
synth catalog show knee.yaml          parts that fit a joint (kind: part-wish); reasons against the others
synth catalog check my_parts/*.csv    all mistakes in your own tables (exit status 2 if any)
synth catalog alike 6597K19           substitutes, nearest first, with their differences
synth catalog import TABLE.csv --map "Their header=wire_diameter [in]" --vendor NAME --out my_parts
                                      convert a vendor's table, one file per vendor
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from synth.commands.arguments import near_miss, one_of
from synth.errors import UserError

if TYPE_CHECKING:
    from synth.commands.progress import Progress
    from synth.parts.catalogs import Catalogue
    from synth.parts.rows import CatalogueRow, DamperRow, MaterialRow, TorsionSpringRow

LONG = ("as_published", "source", "note")  # columns that only ``show`` prints


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    actions = ["list", "show", "check", "alike", "import"]
    parser.add_argument("action", type=one_of(actions), metavar="|".join(actions))
    parser.add_argument(
        "names",
        nargs="*",
        metavar="NAME",
        help="list: a family; show: a part or a wish; check: files; alike: a part; import: a table",
    )
    parser.add_argument(
        "--map",
        metavar='"THEIRS=OURS [unit]"',
        action="append",
        default=[],
        help="import: meaning of a column; repeatable",
    )
    parser.add_argument("--vendor", metavar="NAME", help="import: vendor of the rows that name none")
    parser.add_argument("--out", metavar="DIR", help="import: output folder, one file per vendor (default: my_parts)")
    parser.add_argument(
        "--catalog",
        metavar="FILE",
        action="append",
        default=[],
        help="your own table in addition to the built-in ones; repeatable",
    )


def run(arguments: argparse.Namespace, progress: Progress) -> int:
    """Run the requested action."""
    from synth.parts.catalogs import Catalogue

    extra = [Path(name) for name in arguments.catalog]
    if arguments.action == "check":
        return _check([*map(Path, arguments.names), *extra], progress)
    if arguments.action == "import":
        return _import(arguments, progress)
    if arguments.action == "alike":
        if len(arguments.names) != 1:
            raise UserError("synth catalog alike takes one part, such as synth catalog alike 6597K19")
        progress.result(_alike_text(Catalogue.load(extra), arguments.names[0]))
        return 0
    if arguments.action == "show":
        if len(arguments.names) != 1:
            raise UserError("synth catalog show takes one part, such as synth catalog show 6597K19")
        progress.result(_shown(arguments.names[0], extra))
        return 0
    if len(arguments.names) > 1:
        raise UserError("synth catalog list takes one family, or none for all of them")
    catalogue = Catalogue.load(extra)
    progress.result(_family_text(catalogue, arguments.names[0]) if arguments.names else _overview(catalogue))
    return 0


def _shown(name: str, extra: list[Path]) -> str:
    """One part, or the parts that fit the wish in a file."""
    from synth.parts.catalogs import Catalogue

    if not name.casefold().endswith((".yaml", ".yml")):
        return _part_text(Catalogue.load(extra), name)
    from synth.commands.fitting_parts import fitting_text
    from synth.files.part_wish import read_part_wish

    wish = read_part_wish(name)
    return fitting_text(wish, Catalogue.load([*wish.catalogs, *extra]))


def _import(arguments: argparse.Namespace, progress: Progress) -> int:
    """Convert a vendor's table into one file per vendor; print how many rows are usable."""
    from synth.files.output import output_folder, write_csv
    from synth.parts.catalog_import import file_name, import_table
    from synth.parts.catalogs import Catalogue

    if len(arguments.names) != 1:
        raise UserError("synth catalog import takes one table")
    mapping = {}
    for text in arguments.map:
        theirs, equals, ours = text.partition("=")
        if not equals or not theirs.strip() or not ours.strip():
            raise UserError(f'--map "{text}" is not of the form "THEIRS=OURS [unit]"')
        mapping[theirs.strip()] = ours.strip()
    table = import_table(Path(arguments.names[0]), mapping, arguments.vendor)
    folder = Path(arguments.out or "my_parts")
    with output_folder(folder) as made:
        for vendor, rows in table.rows.items():
            columns = {title: [row[k] for row in rows] for k, title in enumerate(table.header)}
            write_csv(made / file_name(vendor), columns)
    files = [folder / file_name(vendor) for vendor in table.rows]
    read = Catalogue.load(files).rows(table.family)
    mine = [row for row in read if Path(row.file) in files]
    usable = sum(getattr(row, "choosable", False) for row in mine)
    for theirs, ours in table.used:
        progress.result(f"{theirs} -> {ours}")
    for title in table.unused:
        progress.result(f"{title}: ignored; use --map to give its meaning")
    progress.result(f"{len(mine)} rows, {usable} usable; synth catalog list gives the reason for the others")
    progress.say(f"written: {', '.join(map(str, files))}")
    return 0


def _alike_text(catalogue: Catalogue, part: str) -> str:
    """Substitutes for a spring or damper, one per line."""
    from synth.commands.table_text import table_text
    from synth.parts.alike import alike

    wanted = part.strip().casefold()
    sold: list[TorsionSpringRow | DamperRow] = [*catalogue.springs, *catalogue.dampers]
    rows = [row for row in sold if row.part.casefold() == wanted]
    if not rows:
        known = [row.part for row in sold]
        raise UserError(f'no spring or damper "{part}" in the catalogues{near_miss(part, known, 3)}')
    lines = [["part", "vendor", "distance", "differs"]]
    for item in alike(catalogue, rows[0]):
        lines.append([item.row.part, item.row.vendor, f"{item.distance:.2f}", ", ".join(item.differs) or "in nothing"])
    return table_text(lines, numbers_right=False)


def _check(paths: list[Path], progress: Progress) -> int:
    """Raise all mistakes of the user's files. Rows of built-in files are flagged on purpose and only listed."""
    from synth.parts.catalogs import check_catalogue

    problems = check_catalogue(paths)
    if paths and problems:
        raise UserError(problems)
    for problem in problems:
        progress.result(f"flagged, not used: {problem}")
    progress.say(f"{len(paths)} checked, no mistakes" if paths else "the built-in catalogues have no other mistakes")
    return 0


def _overview(catalogue: Catalogue) -> str:
    """Families with their number of usable rows."""
    from synth.commands.table_text import table_text
    from synth.parts.rows import FAMILIES

    lines = [["family", "rows", "complete", "usable", "incomplete", "contradiction", "other"]]
    for family in FAMILIES:
        statuses = [row.status.partition(":")[0] for row in catalogue.rows(family)]
        counts = [statuses.count(status) for status in ("complete", "usable", "incomplete", "contradiction")]
        lines.append([family, *map(str, (len(statuses), *counts, len(statuses) - sum(counts)))])
    return "\n".join(
        [
            table_text(lines),
            "Complete rows can be chosen, and usable rows as their status allows; others are for comparison only.",
        ]
    )


def _family_text(catalogue: Catalogue, family: str) -> str:
    """The rows of one family, without the text columns that only ``show`` prints."""
    from synth.commands.table_text import table_text
    from synth.parts.catalogs import catalogue_rows_as_table

    table = catalogue_rows_as_table(family, catalogue)
    kept = [index for index, title in enumerate(table.header) if title not in LONG]
    rows = [[row[index] for index in kept] for row in (table.header, *table.rows)]
    return table_text(rows, numbers_right=False)


def _part_text(catalogue: Catalogue, part: str) -> str:
    """All values of every row with this part number or wire material."""
    from synth.commands.part_text import row_text, stock_text

    wanted = part.strip().casefold()
    sold: list[CatalogueRow] = [*catalogue.springs, *catalogue.dampers, *catalogue.motors]
    found = [row for row in sold if getattr(row, "part", "").casefold() == wanted]
    if found:
        return "\n\n".join(row_text(row, catalogue) for row in found)
    records = _material(catalogue, wanted)
    if not records:
        known = [*(getattr(row, "part", "") for row in sold), *(row.material for row in catalogue.materials)]
        raise UserError(f'no part or wire material "{part}" in the catalogues{near_miss(part, known, 3)}')
    return "\n\n".join([stock_text(records[0].material, catalogue), *(row_text(row, catalogue) for row in records)])


def _material(catalogue: Catalogue, wanted: str) -> list[MaterialRow]:
    """All rows of a wire material, by name or alias."""
    from synth.parts.wire import ALIASES

    aliases = {alias.casefold(): name for alias, name in ALIASES.items()}
    name = aliases.get(wanted, wanted).casefold()
    return [row for row in catalogue.materials if row.material.casefold() == name]
