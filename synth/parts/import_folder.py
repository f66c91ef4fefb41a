"""The files of a converted table: checked as a catalogue in a temporary folder, then added to the user's folder."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from shlex import quote

from synth.errors import Problem, UserError
from synth.files.added_files import StandingFile, add_files, standing_files
from synth.files.output import write_csv
from synth.parts.catalog_import import ImportedParts
from synth.parts.catalog_table import read_table
from synth.parts.catalogs import Catalogue
from synth.parts.catalogue_row import CatalogueRow


@dataclass(frozen=True)
class PlacedParts:
    """Written files, number of rows in them and of those that can be chosen.

    ``left`` : part and status of each row that cannot; ``gone`` : by file, the parts of its earlier import that are not
    in this table.
    """

    files: tuple[Path, ...]
    rows: int
    choosable: int
    left: tuple[tuple[str, str], ...]
    gone: Mapping[str, tuple[str, ...]]


def place_parts(table: ImportedParts, source: Path, folder: Path) -> PlacedParts:
    """Write one file per vendor into ``folder``; files of other vendors and the user's own stay.

    ``source`` : the vendor's table, for messages.

    Raises
    ------
    UserError
        The table makes no catalogue, or a file that it would replace was changed since its import, was not imported,
        or holds parts of another kind or vendor. The folder is then as before.
    """
    contents, read = _check_table(table, source)
    problems, gone = [], {}
    for each in standing_files(folder, contents):
        path = folder / each.name
        found = [_why_kept(each, path)] if each.changed else list(_why_foreign(path, table))
        problems += [Problem(text, str(path)) for text in found]
        gone[str(path)] = () if found else _gone(path, table)
    if problems:
        raise UserError(problems)
    add_files(folder, contents)
    files = tuple(folder / name for name in contents)
    left = tuple((str(getattr(row, "part", "")), row.status) for row in read if not row.choosable)
    gone = {name: parts for name, parts in gone.items() if parts}
    return PlacedParts(files, len(read), len(read) - len(left), left, gone)


def _check_table(table: ImportedParts, source: Path) -> tuple[dict[str, bytes], list[CatalogueRow]]:
    """Content of each file, and its rows with their states; UserError if they cannot be loaded."""
    with tempfile.TemporaryDirectory(prefix="synth-import-") as made:
        paths = [Path(made) / name for name in table.rows]
        for path in paths:
            write_csv(path, table.columns(path.name))
        try:
            read = Catalogue.load(paths).rows(table.family)
        except UserError as error:
            raise UserError([_in_source(each, table, source) for each in error.problems]) from None
        names = {str(path) for path in paths}
        return {path.name: path.read_bytes() for path in paths}, [row for row in read if row.file in names]


def _in_source(problem: Problem, table: ImportedParts, source: Path) -> Problem:
    """A mistake of a converted file at its place in the vendor's table."""
    lines = table.lines.get(Path(problem.file or "").name, ())
    row = (problem.line or 1) - 2  # line 1 is the header
    line = lines[row] if 0 <= row < len(lines) else 1
    titles = {ours: theirs for theirs, ours in table.used}
    return Problem(problem.text, str(source), line, titles.get(problem.key or "", problem.key))


def _why_kept(standing: StandingFile, path: Path) -> str:
    """Why a file with the user's values is not replaced, and how to go on."""
    what = "was changed since its import" if standing.ours else "was not written by synth catalog import"
    own = path.with_name(f"{path.stem}_own.csv")
    return (
        f"{what}, and would be replaced. Keep the rows that you changed in a file of your own, such as {own}, where "
        "they take the place of imported ones of the same vendor and part, and remove this file; or name another "
        "folder with --out"
    )


def _why_foreign(path: Path, table: ImportedParts) -> Iterator[str]:
    """Why an earlier import is no earlier state of this table: it has another kind of part, or another vendor's."""
    old = read_table(path)
    if old.family not in (None, table.family):
        other, this = ((family or "").replace("_", " ") for family in (old.family, table.family))
        folder = quote(f"{path.parent}_{table.family}")
        yield f"has the {other} of an earlier import, which these {this} would replace; write them to --out {folder}"
        return
    new = {vendor for vendor, _ in _parts(table, path.name)}
    others = sorted({vendor for row in old.rows if (vendor := getattr(row, "vendor", "")).casefold() not in new})
    if others:
        yield (
            f"has parts of {' and '.join(others)} from an earlier import, which this table would replace; name another "
            "folder with --out"
        )


def _gone(path: Path, table: ImportedParts) -> tuple[str, ...]:
    """Parts of an earlier import that are not in this table."""
    new = _parts(table, path.name)
    old = [(getattr(row, "vendor", ""), getattr(row, "part", "")) for row in read_table(path).rows]
    return tuple(part for vendor, part in old if (vendor.casefold(), part.casefold()) not in new)


def _parts(table: ImportedParts, file: str) -> set[tuple[str, str]]:
    """Vendor and part of each row of a file, in lower case."""
    vendor, part = table.header.index("vendor"), table.header.index("part")
    return {(row[vendor].casefold(), row[part].casefold()) for row in table.rows[file]}
