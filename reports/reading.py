"""Reading of a result folder: the JSON, its CSV tables and its pictures; nothing outside the folder."""

from __future__ import annotations

import base64
import csv
import json
import math
import os
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

Json = dict[str, Any]

_HEADER = re.compile(r"\s*(.*?)\s*\[([^\[\]]*)\]\s*")
_PNG = b"\x89PNG\r\n\x1a\n"


class ReportError(Exception):
    """A result folder without a valid result; the message has the file and the fault."""


@dataclass(frozen=True)
class ResultTable:
    """A CSV file's columns by name, with units; nan for an empty cell."""

    columns: Mapping[str, list[float]]
    units: Mapping[str, str]


@dataclass(frozen=True)
class Result:
    """A result folder: ``content`` is the parsed JSON file called ``name``."""

    folder: Path
    name: str
    content: Json
    _tables: dict[str, ResultTable | None] = field(default_factory=dict, compare=False)

    def path(self, relative: str) -> Path | None:
        """The file with that relative path; None if it does not exist or is outside the folder."""
        found = Path(os.path.realpath(self.folder / relative))
        return found if found.is_relative_to(Path(os.path.realpath(self.folder))) and found.is_file() else None

    def table(self, relative: str) -> ResultTable | None:
        """The CSV file with that relative path, read once; None if it does not exist."""
        if relative not in self._tables:
            path = self.path(relative)
            self._tables[relative] = None if path is None else read_table(path)
        return self._tables[relative]

    def files(self, folder: str) -> list[str]:
        """Relative paths of the CSV files directly in a folder of the result, by name."""
        return sorted(f"{folder}/{path.name}" for path in (self.folder / folder).glob("*.csv") if path.is_file())


def read_result(folder: Path, name: str, kind: str) -> Result:
    """Read ``folder/name``, a result of format ``synth/KIND/N``.

    Raises
    ------
    ReportError
        If it is missing, not JSON, or of another format.
    """
    path = folder / name
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise ReportError(f"{path}: is missing") from None
    except (UnicodeDecodeError, json.JSONDecodeError, RecursionError) as error:
        raise ReportError(f"{path}: is not valid JSON: {error}") from None
    if not isinstance(content, dict) or not re.fullmatch(rf"synth/{kind}/\d+", str(content.get("format"))):
        found = content.get("format") if isinstance(content, dict) else None
        raise ReportError(f"{path}: its format is {found!r}; synth/{kind}/1 is required")
    return Result(folder, name, content)


def read_lines(path: Path) -> Iterator[dict[str, str]]:
    """Rows of a CSV by header, as text; cells that a row lacks are missing."""
    with path.open(encoding="utf-8-sig", newline="") as stream:
        rows = csv.reader(stream)
        headers = next(rows, [])
        for row in rows:
            if row:
                yield dict(zip(headers, row, strict=False))


def read_table(path: Path) -> ResultTable:
    """Read a CSV file whose headers are ``name [unit]``.

    Raises
    ------
    ReportError
        If a header has no unit, a row has another length, or a cell is not a number.
    """
    with path.open(encoding="utf-8-sig", newline="") as stream:
        rows = csv.reader(stream)
        headers = [_HEADER.fullmatch(text) for text in next(rows, [])]
        if not headers or None in headers:
            raise ReportError(f"{path}: its headers are not all of the form name [unit]")
        try:
            records = [[float(cell) if cell.strip() else math.nan for cell in row] for row in rows if row]
        except ValueError as error:
            raise ReportError(f"{path}:{rows.line_num}: {error}") from None
    if any(len(record) != len(headers) for record in records):
        raise ReportError(f"{path}: its rows are not all {len(headers)} cells long")
    names = [(match.group(1), match.group(2)) for match in headers if match]
    columns = list(map(list, zip(*records, strict=True))) if records else [[] for _ in names]
    return ResultTable({name: column for (name, _), column in zip(names, columns, strict=True)}, dict(names))


def png_uri(path: Path) -> str:
    """A PNG picture as a data URI.

    Raises
    ------
    ReportError
        If the file is not a PNG.
    """
    data = path.read_bytes()
    if not data.startswith(_PNG):
        raise ReportError(f"{path}: is not a PNG picture")
    return "data:image/png;base64," + base64.b64encode(data).decode("ascii")


def value_of(quantity: object) -> float | None:
    """The number of a ``{"value", "unit"}``, None without one."""
    value = quantity.get("value") if isinstance(quantity, Mapping) else None
    return float(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else None


def unit_of(quantity: object) -> str:
    """The unit of a ``{"value", "unit"}``, empty without one."""
    return str(quantity.get("unit", "")) if isinstance(quantity, Mapping) else ""
