"""``synth catalog``: what can be bought and wound, where each value comes from, and what is wrong with a table.

synth catalog list                    every family and how many of its rows can be used
synth catalog list dampers            the rows of one family
synth catalog show 6597K19            one part in full, with its source and what follows from its values
synth catalog show knee.yaml          what fits a joint (kind: part-wish) and why the rest does not
synth catalog check my_parts/*.csv    every mistake in your own tables (exit status 2 if there is one)
synth catalog alike 6597K19           what could stand in its place, nearest first, with what differs
synth catalog import TABLE.csv --map "Their header=wire_diameter [in]" --vendor NAME --out my_parts
                                      a vendor's whole table into files of yours, one a vendor
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

LONG = ("as_published", "source", "note")  # columns that only ``show`` has


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
        help="import: what a column is; repeatable",
    )
    parser.add_argument("--vendor", metavar="NAME", help="import: who sells what the table does not say who sells")
    parser.add_argument("--out", metavar="DIR", help="import: folder for one file a vendor (default: my_parts)")
    parser.add_argument(
        "--catalog",
        metavar="FILE",
        action="append",
        default=[],
        help="your own table beside the built-in ones; repeatable",
    )


def run(arguments: argparse.Namespace, progress: Progress) -> int:
    """Do what is asked."""
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
    """One part, or what fits the wish in a file."""
    from synth.parts.catalogs import Catalogue

    if not name.casefold().endswith((".yaml", ".yml")):
        return _part_text(Catalogue.load(extra), name)
    from synth.commands.fitting_parts import fitting_text
    from synth.files.part_wish import read_part_wish

    wish = read_part_wish(name)
    return fitting_text(wish, Catalogue.load([*wish.catalogs, *extra]))


def _import(arguments: argparse.Namespace, progress: Progress) -> int:
    """A vendor's table into files of one vendor each; what every row can be used for is said."""
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
        progress.result(f"{title}: not used; --map says what it is")
    progress.result(f"{len(mine)} rows, {usable} of them can be chosen; the others say why in synth catalog list")
    progress.say(f"written: {', '.join(map(str, files))}")
    return 0


def _alike_text(catalogue: Catalogue, part: str) -> str:
    """Substitutes for a spring or damper, one a line."""
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
    """Raise every mistake of the user's files; of the built-in ones, whose flagged rows are meant, list them."""
    from synth.parts.catalogs import check_catalogue

    problems = check_catalogue(paths)
    if paths and problems:
        raise UserError(problems)
    for problem in problems:
        progress.result(f"flagged, never chosen: {problem}")
    progress.say(f"{len(paths)} checked, nothing wrong" if paths else "the built-in catalogues hold no other fault")
    return 0


def _overview(catalogue: Catalogue) -> str:
    """Families with how many rows can be used."""
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
            "Complete rows can be chosen, usable ones too as their status says; others are for comparison only.",
        ]
    )


def _family_text(catalogue: Catalogue, family: str) -> str:
    """The rows of one family, without the columns of words that ``show`` has."""
    from synth.commands.table_text import table_text
    from synth.parts.catalogs import catalogue_rows_as_table

    table = catalogue_rows_as_table(family, catalogue)
    kept = [index for index, title in enumerate(table.header) if title not in LONG]
    rows = [[row[index] for index in kept] for row in (table.header, *table.rows)]
    return table_text(rows, numbers_right=False)


def _part_text(catalogue: Catalogue, part: str) -> str:
    """Every row with this part number, or of this wire material, in full."""
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
    """All records of a wire material, by its name or an alias."""
    from synth.parts.wire import ALIASES

    aliases = {alias.casefold(): name for alias, name in ALIASES.items()}
    name = aliases.get(wanted, wanted).casefold()
    return [row for row in catalogue.materials if row.material.casefold() == name]
