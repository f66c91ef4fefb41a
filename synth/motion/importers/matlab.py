"""MATLAB: variables of a ``.mat`` file up to version 7, read by scipy.

A column is named as one would in MATLAB: ``angles(:,2)``, ``trial.hip``, ``data.angles(3,:)``. Version 7.3 is another
format (HDF5), which is refused with the command that writes the older one.
"""

from __future__ import annotations

import re
from collections.abc import Mapping as Dictionary
from pathlib import Path
from typing import Any

import numpy as np

from synth.errors import Problem, UserError
from synth.files.import_project import Mapping
from synth.files.paths import read_bytes
from synth.files.validate import near
from synth.model.leg import Array
from synth.motion.importers.source import Channels, listed

SIZE_LIMIT = 500_000_000
_EXPRESSION = re.compile(r"\s*([A-Za-z]\w*(?:\.[A-Za-z]\w*)*)\s*(?:\(\s*(:|\d{1,6})\s*,\s*(:|\d{1,6})\s*\))?\s*")
WAY_OUT = "in MATLAB: s = load('{name}'); save('{stem}_v7.mat', '-struct', 's', '-v7')"


def read_matlab(path: Path, mapping: Mapping, name: str) -> Channels:
    """The columns that ``mapping`` names, one after another.

    Raises
    ------
    UserError : version 7.3, no MAT-file, a name that is not there or is no row or column of numbers.
    """
    start = read_bytes(path, SIZE_LIMIT, "save the angles alone")[:128]
    if start.startswith(b"MATLAB 7.3") or start.startswith(b"\x89HDF"):
        way = WAY_OUT.format(name=path.name.replace("'", "''"), stem=path.stem.replace("'", "''"))
        raise UserError(Problem(f"is a MAT-file of version 7.3 (HDF5); save it as version 7, {way}", name))
    import scipy.io

    try:
        content: dict[str, Any] = scipy.io.loadmat(path, simplify_cells=True)
    except Exception as error:  # scipy's reader raises many kinds on a damaged file
        raise UserError(Problem(f"cannot be read as a MAT-file: {error}", name)) from None
    variables = {key: value for key, value in content.items() if not key.startswith("__")}
    wanted = [column.column for column in mapping.joints.values()]
    wanted += [mapping.time] if mapping.time else []
    notes: list[str] = []
    columns = [_column(variables, expression, notes, name) for expression in dict.fromkeys(wanted)]
    lengths = {len(column) for column in columns}
    if len(lengths) > 1:
        sizes = ", ".join(f"{what}: {len(c)}" for what, c in zip(dict.fromkeys(wanted), columns, strict=True))
        raise UserError(Problem(f"its columns differ in length ({sizes})", name))
    if not columns:
        raise UserError(Problem(f"say which of its variables are the joints' angles: {_summary(variables)}", name))
    names = tuple(dict.fromkeys(wanted))
    return Channels(name, names, ("",) * len(names), np.column_stack(columns), notes=tuple(notes))


def _column(variables: dict[str, Any], expression: str, notes: list[str], name: str) -> Array:
    """One row or column (n,) by its MATLAB expression."""
    match = _EXPRESSION.fullmatch(expression)
    if match is None:
        text = f'"{expression}" is no column; write it like angles(:,2), or trial.hip for a field that is a vector'
        raise UserError(Problem(text, name))
    value: Any = variables
    walked: list[str] = []
    for part in match[1].split("."):
        if not isinstance(value, Dictionary) or part not in value:
            there = list(value) if isinstance(value, Dictionary) else []
            inside = f" in {'.'.join(walked)}" if walked else ""
            hint = near(part, there) if there else ""
            raise UserError(Problem(f'there is no "{part}"{inside}{hint or "; it is no struct"}', name))
        value = value[part]
        walked.append(part)
    if not isinstance(value, np.ndarray) or value.dtype.kind not in "fiuc":
        what = "a struct" if isinstance(value, Dictionary) else f"of type {type(value).__name__}"
        text = f'"{match[1]}" is {what}, where a matrix of numbers is needed (of a table T, save T{{:,:}})'
        raise UserError(Problem(text, name))
    picked = _picked(value, match[2], match[3], expression, name)
    if np.iscomplexobj(picked):
        # acos of a ratio beyond 1 gives such angles: the pose was impossible, its real part means nothing.
        complex_ones = np.abs(picked.imag) > 0
        if complex_ones.any():
            notes.append(f"{int(complex_ones.sum())} values of {expression} are complex: taken as missing")
        picked = np.where(complex_ones, np.nan, picked.real)
    result = np.asarray(picked, dtype=np.float64)
    return np.where(np.isfinite(result), result, np.nan)


def _picked(value: Any, row: str | None, column: str | None, expression: str, name: str) -> Any:
    """A row or column of an array; vectors need no index."""
    if row is None or column is None:
        if value.ndim != 1:
            shape = " x ".join(map(str, value.shape))
            raise UserError(Problem(f'"{expression}" is {shape}; say which column, like {expression}(:,1)', name))
        return value
    if (row == ":") == (column == ":"):
        raise UserError(Problem(f'"{expression}": one index is a colon and the other a number, like (:,2)', name))
    matrix = value if value.ndim == 2 else value[:, None]
    index, axis = (int(column), 1) if row == ":" else (int(row), 0)
    if matrix.ndim != 2 or not 1 <= index <= matrix.shape[axis]:
        shape = " x ".join(map(str, value.shape))
        raise UserError(Problem(f'"{expression}" reaches outside: it is {shape}, and counting begins at 1', name))
    return matrix[:, index - 1] if axis else matrix[index - 1]


def _summary(variables: dict[str, Any], prefix: str = "") -> str:
    """What there is, with sizes, two levels deep."""
    found = []
    for key, value in variables.items():
        if isinstance(value, np.ndarray):
            found.append(f"{prefix}{key} ({' x '.join(map(str, value.shape))})")
        elif isinstance(value, dict) and not prefix:
            found.append(_summary(value, f"{key}."))
    return listed(found) if found else "nothing"
