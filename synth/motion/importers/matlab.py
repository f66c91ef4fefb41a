"""MATLAB: variables of a ``.mat`` file up to version 7, read by scipy.

A column is named as one would in MATLAB: ``angles(:,2)``, ``trial.hip``, ``data.angles(3,:)``. Version 7.3 is another
format (HDF5), which is refused with the command that writes the older one. scipy's reader can crash over a damaged
file, so it runs in a separate process.
"""

from __future__ import annotations

import re
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.import_mapping import Mapping
from synth.files.paths import read_bytes
from synth.files.validate import near
from synth.motion.importers.child import read_in_child
from synth.motion.importers.foreign_data import Channels, name_list
from synth.motion.importers.registry import loader

SIZE_LIMIT = 500_000_000  # bytes; the whole file is read into memory
_EXPRESSION = re.compile(r"\s*([A-Za-z]\w*(?:\.[A-Za-z]\w*)*)\s*(?:\(\s*(:|\d{1,6})\s*,\s*(:|\d{1,6})\s*\))?\s*")
STRUCT = "a struct"
_NAMES, _KINDS = "/names", "/kinds"  # no variable has a slash in its name
# Numbers as they are, named as in MATLAB; for everything else only its type.
_READ = f"""
import scipy.io
arrays, kinds = {{}}, {{}}
def walk(prefix, values):
    for key, value in values.items():
        name = prefix + key
        if isinstance(value, dict):
            kinds[name] = {STRUCT!r}
            walk(name + ".", value)
        elif isinstance(value, (int, float, complex)):
            arrays[name] = numpy.array([value])
        elif isinstance(value, numpy.ndarray) and value.dtype.kind in "fiuc":
            arrays[name] = value
        else:
            kinds[name] = "of type " + type(value).__name__
content = scipy.io.loadmat(path, simplify_cells=True)
walk("", {{key: value for key, value in content.items() if not key.startswith("__")}})
arrays[{_NAMES!r}] = numpy.array(list(kinds), dtype=str)
arrays[{_KINDS!r}] = numpy.array(list(kinds.values()), dtype=str)
"""
WAY_OUT = "in MATLAB: s = load('{name}'); save('{stem}_v7.mat', '-struct', 's', '-v7')"


def is_matlab(start: bytes, path: Path) -> bool:
    """Whether a file begins like MATLAB's of version 5 to 7.3; older ones have no mark and are known by extension."""
    marked = start.startswith((b"MATLAB 5.0", b"MATLAB 7.3")) or start[512:].startswith(b"\x89HDF")
    # Version 4 begins with five binary integers of four bytes, whose upper bytes are zero.
    return marked or (path.suffix.casefold() == ".mat" and b"\0" in start[:20])


@loader("matlab", "MATLAB .mat", is_matlab, "channels")
def read_matlab(path: Path, mapping: Mapping, name: str) -> Channels:
    """The columns named by ``mapping``, one after another, and all rows and columns of their length.

    Raises
    ------
    UserError : version 7.3, not a MAT-file, or a name that is missing or not a row or column of numbers.
    """
    start = read_bytes(path, SIZE_LIMIT, "save the angles alone", first=128)
    if start.startswith(b"MATLAB 7.3") or start.startswith(b"\x89HDF"):
        way = WAY_OUT.format(name=path.name.replace("'", "''"), stem=path.stem.replace("'", "''"))
        raise UserError(Problem(f"is a MAT-file of version 7.3 (HDF5); save it as version 7, {way}", name))
    flat = read_in_child(_READ, path, name, "MAT")
    others = dict(zip(flat.pop(_NAMES).tolist(), flat.pop(_KINDS).tolist(), strict=True))
    variables: dict[str, Any] = {**flat, **others}
    wanted = _wanted_expressions(mapping)
    notes: list[str] = []
    picked = [_column(variables, expression, name) for expression in wanted]
    columns = [_real(column, expression, notes) for column, expression in zip(picked, wanted, strict=True)]
    lengths = {len(column) for column in columns}
    if len(lengths) > 1:
        sizes = ", ".join(f"{what}: {len(c)}" for what, c in zip(wanted, columns, strict=True))
        raise UserError(Problem(f"its columns differ in length ({sizes})", name))
    further = _further(flat, wanted, lengths)
    if not wanted and not further:
        raise UserError(Problem(f"choose the variables of the joints' angles: {_summary(variables)}", name))
    picked += [flat[key] for key in further]
    columns += [_real(flat[key], key, notes) for key in further]
    names = (*wanted, *further)

    def numbers(column: int) -> list[Any]:
        values = picked[column] if picked[column].dtype.kind in "iu" else columns[column]
        return list(values.tolist())

    values = np.column_stack(columns)
    contents = _summary(variables)
    return Channels(name, names, ("",) * len(names), values, notes=tuple(notes), numbers=numbers, contents=contents)


def _wanted_expressions(mapping: Mapping) -> list[str]:
    """The expressions that a project names, each once: of angles, of the drives' inputs, of supply and clock."""
    joints = mapping.joints.values()
    found = [joint.column for joint in joints]
    found += [each.column for joint in joints for each in joint.inputs.values()]
    found += [mapping.supply.column] if mapping.supply else []
    found += [mapping.time] if mapping.time else []
    return list(dict.fromkeys(found))


def _further(variables: dict[str, Any], wanted: list[str], lengths: set[int]) -> list[str]:
    """Rows and columns of numbers beside the wanted ones, of their length; without these of the most usual length.

    They are found by the joints' names, as the columns of any other file.
    """
    vectors = {key: len(value) for key, value in variables.items()
               if key not in wanted and value.ndim == 1 and value.dtype.kind in "fiu" and len(value) > 1}  # fmt: skip
    usual = Counter(vectors.values()).most_common(1)
    length = next(iter(lengths), usual[0][0] if usual else 0)
    return [key for key, own in vectors.items() if own == length]


def _column(variables: dict[str, Any], expression: str, name: str) -> Any:
    """One row or column (n,) by its MATLAB expression, in the type of the file."""
    match = _EXPRESSION.fullmatch(expression)
    if match is None:
        text = f'"{expression}" is not a column; write it like angles(:,2), or trial.hip for a field that is a vector'
        raise UserError(Problem(text, name))
    value = variables.get(match[1])
    if value is None:
        raise UserError(Problem(_missing_part(variables, match[1]), name))
    if isinstance(value, str):
        text = f'"{match[1]}" is {value}, where a matrix of numbers is needed (of a table T, save T{{:,:}})'
        raise UserError(Problem(text, name))
    return _pick_vector(value, match[2], match[3], expression, name)


def _real(picked: Any, expression: str, notes: list[str]) -> Array:
    """The real numbers (n,) of a column, nan where it has none."""
    if np.iscomplexobj(picked):
        # acos of a ratio beyond 1 gives such angles: the pose is impossible and the real part meaningless.
        complex_ones = np.abs(picked.imag) > 0
        if complex_ones.any():
            notes.append(f"{int(complex_ones.sum())} values of {expression} are complex: taken as missing")
        picked = np.where(complex_ones, np.nan, picked.real)
    result = np.asarray(picked, dtype=np.float64)
    return np.where(np.isfinite(result), result, np.nan)


def _pick_vector(value: Any, row: str | None, column: str | None, expression: str, name: str) -> Any:
    """A row or column of an array; vectors need no index."""
    if row is None or column is None:
        if value.ndim != 1:
            shape = " x ".join(map(str, value.shape))
            raise UserError(Problem(f'"{expression}" is {shape}; choose a column, like {expression}(:,1)', name))
        return value
    if (row == ":") == (column == ":"):
        raise UserError(Problem(f'"{expression}": one index is a colon and the other a number, like (:,2)', name))
    index, axis = (int(column), 1) if row == ":" else (int(row), 0)
    if value.ndim == 1 and index == 1:
        return value  # scipy gives one row and one column alike
    if value.ndim != 2 or not 1 <= index <= value.shape[axis]:
        shape = " x ".join(map(str, value.shape)) if value.ndim > 1 else f"one row or column of {len(value)}"
        raise UserError(Problem(f'"{expression}" reaches outside: it is {shape}, and counting begins at 1', name))
    return value[:, index - 1] if axis else value[index - 1]


def _missing_part(variables: dict[str, Any], wanted: str) -> str:
    """The fault of a dotted name: the first missing part, and the existing ones."""
    parts = wanted.split(".")
    depth = next(k for k in range(1, len(parts) + 1) if ".".join(parts[:k]) not in variables)
    above = ".".join(parts[: depth - 1])
    if above and variables[above] != STRUCT:
        return f'there is no "{wanted}": "{above}" is not a struct'
    start = f"{above}." if above else ""
    there = {key.removeprefix(start).partition(".")[0] for key in variables if key.startswith(start)}
    inside = f" in {above}" if above else ""
    return f'there is no "{parts[depth - 1]}"{inside}{near(parts[depth - 1], sorted(there))}'


def _summary(variables: dict[str, Any]) -> str:
    """The variables with their sizes."""
    found = [f"{key} ({' x '.join(map(str, v.shape))})" for key, v in variables.items() if not isinstance(v, str)]
    return name_list(found) if found else "nothing"
