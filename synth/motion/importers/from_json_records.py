"""JSON logs with one record per sample, or one list per column.

Four forms are read: a list of records; an object with one list of records and the settings of the run (the logs of BAM,
Duclusaud et al., arXiv 2410.08650: ``{"mass": 0.5, "kp": 100, "entries": [{"timestamp": 0.0, "position": 0.1, ...},
...]}``); an object of lists of equal length; and one record per line. A field of a nested record is named
``outer.inner``.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping as Dictionary
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np

from synth.errors import Problem, UserError
from synth.files.import_mapping import Mapping
from synth.files.log_clock import exact_number
from synth.files.paths import read_bytes
from synth.motion.importers.foreign_data import Channels, name_list
from synth.motion.importers.plain_csv import SIZE_LIMIT, title_and_unit
from synth.motion.importers.registry import loader, text_start, utf8

DEEPEST = 8  # levels of nested records; logs nest two or three
LONGEST = 4_000  # digits of a whole number; Python reads 4300
_SURROGATE = re.compile(r"\\u[dD][89a-fA-F]")
VALUES_SHOWN = 12  # values in the note on the settings of the run


def is_json(start: bytes, path: Path) -> bool:
    """Whether a text begins like an object or a list of objects."""
    text = "".join(text_start(start)[:1000].split())
    return text.startswith(('{"', "[{"))


@loader("json", "JSON with a record per sample", is_json, "channels")
def read_json(path: Path, mapping: Mapping, name: str) -> Channels:
    """All numbers of the records with their names and, if a name states it, their unit.

    Raises
    ------
    UserError : the file is not JSON, or has neither records nor columns.
    """
    content = _content(path, name)
    notes: list[str] = []
    records = _records_within(content, notes, name) if isinstance(content, dict) else content
    flat = [_flat(record) for record in records]
    titles = list(dict.fromkeys(title for record in flat for title in record))
    columns, refused = {}, {}
    for title in titles:
        cells = [record.get(title) for record in flat]
        if all(cell is None or isinstance(cell, (int, float)) for cell in cells):
            columns[title] = np.array([np.nan if cell is None else _number(cell) for cell in cells])
        else:
            refused[title_and_unit(title)[0]] = _no_number(cells)
    left_out = f"left out because they are not numbers: {name_list(refused)}" if refused else ""
    notes += [left_out] if refused else []
    if len(flat) < 2 or not columns:
        raise UserError(Problem(f"has no records with numbers{'; ' if refused else ''}{left_out}", name))
    names, units = zip(*map(title_and_unit, columns), strict=True)
    repeated = next((each for k, each in enumerate(names) if each in names[:k]), None)
    if repeated is not None:
        raise UserError(Problem(f'column "{repeated}" is given twice; rename one', name))

    def numbers(column: int) -> list[Decimal | None]:
        title = list(columns)[column]
        return [
            exact_number(str(record.get(title))) for record in flat
        ]  # a double's text is the file's up to 15 digits

    values = np.column_stack(list(columns.values()))
    contents = f"{name_list(names)}; {left_out}" if refused else ""
    return Channels(name, tuple(names), tuple(units), values, notes=tuple(notes), numbers=numbers,
                    contents=contents, refused=refused)  # fmt: skip


def _no_number(cells: list[Any]) -> str:
    """What is wrong with the first cell of a column that is not a number, and the correct form."""
    wrong = [k for k, cell in enumerate(cells) if cell is not None and not isinstance(cell, (int, float))]
    where, cell = f"in record {wrong[0] + 1} of {len(cells)} it is", cells[wrong[0]]
    if isinstance(cell, list):
        return f"{where} a list; write each of its numbers as a field of its own"
    number = exact_number(str(cell))
    if number is not None and number.is_finite():
        return f'{where} the text "{str(cell)[:40]}"; write the number without quotes'
    return f'{where} the text "{str(cell)[:40]}"; leave the field out, or write null, where a sample is missing'


def _content(path: Path, name: str) -> Any:
    """The content of the file; for one record per line, the list of records."""
    try:
        text = utf8(read_bytes(path, SIZE_LIMIT, "thin it")).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise UserError(Problem("is not text", name)) from None
    hook = _printable if _SURROGATE.search(text) else None
    try:
        return json.loads(text, parse_int=_whole, object_pairs_hook=hook)
    except RecursionError:
        raise UserError(Problem("is nested too deeply", name)) from None
    except json.JSONDecodeError as error:
        first = error
    lines = [line for line in text.splitlines() if line.strip()]
    try:
        return [json.loads(line, parse_int=_whole, object_pairs_hook=hook) for line in lines]
    except (json.JSONDecodeError, RecursionError):
        raise UserError(Problem(f"is damaged JSON: {first.msg}", name, first.lineno)) from None


def _whole(digits: str) -> float:
    """A whole number; one that Python does not turn into a number is beyond all others, as 1e999 is."""
    return int(digits) if len(digits) <= LONGEST else float(digits)


def _printable(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """An object without halves of surrogate pairs, which no text that is written may hold."""
    return {
        _escape_surrogates(key): _escape_surrogates(value) if isinstance(value, str) else value for key, value in pairs
    }


def _escape_surrogates(text: str) -> str:
    return text.encode("utf-8", "backslashreplace").decode()


def _records_within(content: dict[str, Any], notes: list[str], name: str) -> list[Any]:
    """The records of an object: its only list of records, or its lists of equal length."""
    lists = {key: value for key, value in content.items() if isinstance(value, list) and value}
    of_records = [key for key, value in lists.items() if all(isinstance(each, dict) for each in value)]
    if len(of_records) > 1:
        text = f"has several lists of records: {name_list(of_records)}; keep one in a file"
        raise UserError(Problem(text, name))
    attributes = {key: value for key, value in content.items() if isinstance(value, (str, int, float))}
    if attributes:
        shown = ", ".join(f"{key} {str(value)[:40]}" for key, value in list(attributes.items())[:VALUES_SHOWN])
        notes.append(f"the file states {shown}; add values that concern the leg to the leg file")
    if of_records:
        return lists[of_records[0]]
    lengths = {len(value) for value in lists.values()}
    if len(lengths) != 1:
        what = "lists of different lengths" if lengths else "no list"
        raise UserError(Problem(f"has {what}: a log is a list of records, or one list per column", name))
    return [dict(zip(lists, row, strict=True)) for row in zip(*lists.values(), strict=True)]


def _flat(record: Any, before: str = "", depth: int = 0) -> dict[str, Any]:
    if not isinstance(record, Dictionary) or depth > DEEPEST:
        return {}
    found: dict[str, Any] = {}
    for key, value in record.items():
        inner = (
            _flat(value, f"{before}{key}.", depth + 1) if isinstance(value, Dictionary) else {f"{before}{key}": value}
        )
        found |= inner
    return found


def _number(cell: float) -> float:
    try:
        number = float(cell)
    except OverflowError:
        return np.nan
    return number if np.isfinite(number) else np.nan
