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
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from synth.commands.answers import tell_document
from synth.commands.arguments import near_miss, one_of
from synth.commands.catalog_json import (
    FORMAT,
    STATES,
    alike_json,
    families_json,
    family_counts,
    imported_json,
    rows_json,
)
from synth.errors import UserError

if TYPE_CHECKING:
    from synth.commands.progress import Progress
    from synth.parts.catalogs import Catalogue
    from synth.parts.catalogue_row import CatalogueRow
    from synth.parts.rows import DamperRow, MaterialRow, TorsionSpringRow

MOST_GONE = 5  # parts that are named: about a line
MOST_LEFT = 20  # rows that cannot be chosen and are listed with the reason: about a screen
LONG = ("as_published", "source", "note")  # columns that only ``show`` prints


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    actions = ["list", "show", "check", "alike", "import"]
    parser.add_argument("action", type=one_of(actions), metavar="|".join(actions))
    parser.add_argument(
        "names",
        nargs="*",
        metavar="NAME",
        help="list: a family; show: a part or a request; check: files; alike: a part; import: a table",
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
        _substitute_lines(Catalogue.load(extra), arguments.names[0], progress)
        return 0
    if arguments.action == "show":
        if len(arguments.names) != 1:
            raise UserError("synth catalog show takes one part, such as synth catalog show 6597K19")
        _show(arguments.names[0], extra, progress)
        return 0
    if len(arguments.names) > 1:
        raise UserError("synth catalog list takes one family, or none for all of them")
    catalogue = Catalogue.load(extra)
    if arguments.names:
        rows = catalogue.rows(arguments.names[0])
        tell_document(progress, rows_json(rows), _family_text(catalogue, arguments.names[0]))
    else:
        tell_document(progress, families_json(catalogue), _overview(catalogue))
    return 0


def _show(name: str, extra: list[Path], progress: Progress) -> None:
    """One part, or the parts that fit the request in a file."""
    from synth.parts.catalogs import Catalogue

    if not name.casefold().endswith((".yaml", ".yml")):
        rows, text = _part(Catalogue.load(extra), name)
        tell_document(progress, rows_json(rows), text)
        return
    from synth.commands.fitting_parts import fitting_blocks
    from synth.files.part_request import read_part_request
    from synth.parts.part_names import require_known_wishes

    wish = read_part_request(name)
    catalogue = Catalogue.load([*wish.catalogs, *extra])
    require_known_wishes(wish, catalogue)
    blocks = fitting_blocks(wish, catalogue)
    content = {"format": FORMAT, "wishes": [block.as_json() for block in blocks]}
    tell_document(progress, content, "\n\n".join(block.text() for block in blocks))


def _import(arguments: argparse.Namespace, progress: Progress) -> int:
    """Convert a vendor's table into one file per vendor; print how many rows are usable."""
    from synth.parts.catalog_import import import_table
    from synth.parts.import_folder import place_parts

    if len(arguments.names) != 1:
        raise UserError("synth catalog import takes one table")
    mapping = {}
    for text in arguments.map:
        theirs, equals, ours = text.partition("=")
        if not equals or not theirs.strip() or not ours.strip():
            raise UserError(f'--map "{text}" is not of the form "THEIRS=OURS [unit]"')
        mapping[theirs.strip()] = ours.strip()
    source = Path(arguments.names[0])
    table = import_table(source, mapping, arguments.vendor)
    placed = place_parts(table, source, Path(arguments.out or "my_parts"))
    lines = [f"{theirs} -> {ours}" for theirs, ours in table.used]
    lines += [f"{title}: ignored; use --map to give its meaning" for title in table.unused]
    for file, parts in placed.gone.items():
        shown = ", ".join(parts[:MOST_GONE]) + (", ..." if len(parts) > MOST_GONE else "")
        lines.append(f"{file}: replaced; parts of it that this table lacks ({len(parts)}): {shown}")
    lines += [f"{part}: not usable, {status}" for part, status in placed.left[:MOST_LEFT]]
    others = "" if len(placed.left) <= MOST_LEFT else "; synth catalog list gives the reason for the others"
    lines.append(f"{placed.rows} rows, {placed.choosable} usable{others}")
    tell_document(progress, imported_json(table, placed), "\n".join(lines))
    progress.say(f"written: {', '.join(map(str, placed.files))}")
    return 0


def _substitute_lines(catalogue: Catalogue, part: str, progress: Progress) -> None:
    """Substitutes for a spring or damper, one per line."""
    from synth.commands.table_text import table_text
    from synth.parts.alike import find_substitutes

    wanted = part.strip().casefold()
    sold: list[TorsionSpringRow | DamperRow] = [*catalogue.springs, *catalogue.dampers]
    rows = [row for row in sold if row.part.casefold() == wanted]
    if not rows:
        known = [row.part for row in sold]
        raise UserError(f'no spring or damper "{part}" in the catalogues{near_miss(part, known, 3)}')
    found = find_substitutes(catalogue, rows[0])
    lines = [["part", "vendor", "distance", "differs"]]
    for item in found:
        lines.append([item.row.part, item.row.vendor, f"{item.distance:.2f}", ", ".join(item.differs) or "in nothing"])
    tell_document(progress, alike_json(rows[0].part, found), table_text(lines, numbers_right=False))


def _check(paths: list[Path], progress: Progress) -> int:
    """Raise all mistakes of the user's files. Rows of built-in files are flagged on purpose and only listed."""
    from synth.parts.catalogs import check_catalogue

    problems = check_catalogue(paths)
    if paths and problems:
        raise UserError(problems)
    lines = [f"flagged, not used: {problem}" for problem in problems]
    content = {"format": FORMAT, "files": [str(path) for path in paths], "flagged": [str(each) for each in problems]}
    tell_document(progress, content, "\n".join(lines))
    progress.say(f"{len(paths)} checked, no mistakes" if paths else "the built-in catalogues have no other mistakes")
    return 0


def _overview(catalogue: Catalogue) -> str:
    """Families with their number of usable rows."""
    from synth.commands.table_text import table_text
    from synth.parts.rows import FAMILIES

    lines = [["family", "rows", *STATES, "other"]]
    for family in FAMILIES:
        lines.append([str(value) for value in family_counts(family, catalogue).values()])
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


def _part(catalogue: Catalogue, part: str) -> tuple[Sequence[CatalogueRow], str]:
    """All values of every row with this part number or wire material, as rows and as text."""
    from synth.commands.part_text import row_text, stock_text

    wanted = part.strip().casefold()
    sold: list[CatalogueRow] = [*catalogue.springs, *catalogue.dampers, *catalogue.motors]
    found = [row for row in sold if getattr(row, "part", "").casefold() == wanted]
    if found:
        return found, "\n\n".join(row_text(row, catalogue) for row in found)
    records = _material(catalogue, wanted)
    if not records:
        known = [*(getattr(row, "part", "") for row in sold), *(row.material for row in catalogue.materials)]
        raise UserError(f'no part or wire material "{part}" in the catalogues{near_miss(part, known, 3)}')
    texts = [stock_text(records[0].material, catalogue), *(row_text(row, catalogue) for row in records)]
    return records, "\n\n".join(texts)


def _material(catalogue: Catalogue, wanted: str) -> list[MaterialRow]:
    """All rows of a wire material, by any of its spellings."""
    name = catalogue.known_materials.name(wanted)
    return [row for row in catalogue.materials if row.material == name]
