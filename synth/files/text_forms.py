"""Numbers and words in JSON and CSV: the same on every machine, and no formulas for spreadsheets."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

DIGITS = 10  # significant; fewer than the agreement of two machines' arithmetic, more than needed
MOST = 15  # digits of a decimal number that a double holds for certain
_FORMULA = tuple("=+-@\t\r\n|%")  # a spreadsheet would read a cell that begins so as a formula


def flow_mapping(content: Mapping[str, Any]) -> str:
    """A mapping as YAML on one line, quoted where it must be."""
    import yaml

    text: str = yaml.safe_dump(
        dict(content), sort_keys=False, default_flow_style=True, allow_unicode=True, width=math.inf
    )
    return text.strip()


def plain(value: Any, key: str) -> Any:
    """Mappings, lists and rounded numbers only."""
    if isinstance(value, Mapping):
        for name in value:
            if not isinstance(name, str):
                raise TypeError(f"{key or 'the result'} has the key {name!r}, which is no text")
        return {name: plain(item, f"{key}.{name}" if key else name) for name, item in value.items()}
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [plain(item, f"{key}[{index}]") for index, item in enumerate(value)]
    if value is None or isinstance(value, (str, bool)):
        return value
    if isinstance(value, np.bool_):
        return bool(value)
    if isinstance(value, (int, np.integer)):
        return int(value)
    if isinstance(value, (float, np.floating)):
        if not math.isfinite(value):
            raise ValueError(f"{key or 'the result'} is {value}: such a number must not reach a result file")
        return _rounded(float(value))
    raise TypeError(f"{key or 'the result'} is a {type(value).__name__}, which has no JSON form")


def _rounded(value: float) -> float:
    return float(f"{value:.{DIGITS}g}") + 0.0  # + 0.0: no minus zero


def json_text(value: Any, depth: int) -> str:
    """Indented JSON with lists and mappings of plain numbers and words kept on one line."""
    if not isinstance(value, (dict, list)) or not value:
        return json.dumps(value, ensure_ascii=False, allow_nan=False)
    items = list(value.values()) if isinstance(value, dict) else value
    flat = all(not isinstance(item, (dict, list)) for item in items)
    quantity = isinstance(value, dict) and "value" in value and "unit" in value
    if (flat and isinstance(value, list)) or quantity:
        return json.dumps(value, ensure_ascii=False, allow_nan=False)
    pad = "  " * (depth + 1)
    if isinstance(value, dict):
        parts = [
            f"{json.dumps(name, ensure_ascii=False)}: {json_text(item, depth + 1)}" for name, item in value.items()
        ]
    else:
        parts = [json_text(item, depth + 1) for item in value]
    left, right = "{}" if isinstance(value, dict) else "[]"
    return f"{left}\n{pad}" + f",\n{pad}".join(parts) + f"\n{'  ' * depth}{right}"


def cells(column: Sequence[Any] | np.ndarray[Any, Any]) -> list[str]:
    """A column's cells. An array of numbers, the usual case, is formatted without a type check of each cell."""
    if not (isinstance(column, np.ndarray) and column.dtype == np.float64 and column.ndim == 1):
        return [_cell(value) for value in column]
    if np.any(np.isinf(column)):
        _cell(column[np.isinf(column)][0])
    # + 0.0: no minus zero; nan alone differs from itself
    return [f"{value:.{DIGITS}g}" if value == value else "" for value in (column + 0.0).tolist()]


def clock_cells(column: Sequence[Any] | np.ndarray[Any, Any]) -> list[str]:
    """The cells of a column of times: ten digits, and more where these are coarser than 1e-9."""
    known = [abs(value) for value in column if value is not None and not math.isnan(value)]
    largest = max(known, default=0.0)
    texts = cells(column)  # which refuses an infinite one
    if largest < 10.0:
        return texts
    digits = DIGITS + math.floor(math.log10(largest))

    def written(value: float) -> str:
        # Beyond a double's certain digits the shortest text that reads back as the same number.
        return f"{value:.{digits}g}" if digits <= MOST else repr(value).removesuffix(".0")

    return [text and written(float(value)) for text, value in zip(texts, column, strict=True)]


def _cell(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, (bool, np.bool_)):
        return "yes" if value else "no"
    if isinstance(value, (float, np.floating)):
        if math.isinf(value):
            raise ValueError(f"a cell is {value}: such a number must not reach a result file")
        return "" if math.isnan(value) else f"{_rounded(float(value)):.{DIGITS}g}"
    return defused(str(value))


def defused(text: str) -> str:
    """The text of a cell, with an apostrophe if a spreadsheet would read it as a formula."""
    return text if text.lstrip(" ")[:1] not in _FORMULA or not text else f"'{text}"


def csv_text(words: str) -> str:
    """A CSV cell of words, quoted if necessary, for writers of their own lines."""
    safe = defused(words)
    return f'"{safe.replace(chr(34), chr(34) * 2)}"' if any(c in safe for c in ',"\n\r') else safe
