"""Write results: a folder whole or not at all, numbers the same on every run."""

from __future__ import annotations

import csv
import errno
import hashlib
import json
import math
import os
import shutil
import signal
import tempfile
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np

from synth.errors import Problem, UserError

DIGITS = 10  # significant; below what any two machines' arithmetic agrees on, above what anyone needs
MANIFEST = ".synth-output"  # lists what a run wrote, so that the next may replace it and nothing else
_IGNORED = frozenset({MANIFEST, ".DS_Store", "Thumbs.db", "desktop.ini"})
_written: list[Path] = []  # the temporary folders of the runs under way, innermost last
_USER_ERRORS = frozenset({errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EFBIG})


@contextmanager
def output_folder(path: str | Path, overwrite: bool = True) -> Iterator[Path]:
    """A folder to write into, which becomes ``path`` when the block ends well and vanishes when it does not.

    Parameters
    ----------
    path
        the folder that the user wants. Where it exists it must be empty, or hold only files of an earlier run, which
        are then replaced; missing parents are made.
    overwrite
        False: refuse to replace an earlier run.

    Yields
    ------
    The temporary folder, beside the target, so that the final rename is one step.

    Raises
    ------
    UserError
        If the target holds anything else, is a file or the current folder, or its parent cannot be written.
    """
    target = Path(path).resolve()
    name = str(path)
    _check_target(target, name, overwrite)
    made: list[Path] = []
    try:
        made = _make_parents(target.parent)
        temporary = Path(tempfile.mkdtemp(prefix=f".{target.name}.partial-", dir=target.parent))
    except OSError as error:
        _remove_empty(made)
        raise UserError(Problem(f"cannot be written in {target.parent}: {error.strerror}", name)) from None
    finished = False
    _written.append(temporary)
    try:
        with _terminated_as_exception():
            yield temporary
            _complete(temporary)
            _check_target(target, name, overwrite)  # the run was long: something may have come there meanwhile
            _move(temporary, target)
            finished = True
    except OSError as error:
        if error.errno not in _USER_ERRORS:
            raise
        raise UserError(Problem(f"cannot be written: {error.strerror}", name)) from None
    finally:
        _written.remove(temporary)
        if not finished:
            shutil.rmtree(temporary, ignore_errors=True)
            _remove_empty(made)


def place(folder: Path, name: str) -> Path:
    """The new file called ``name`` in ``folder``, whatever the name.

    Raises
    ------
    UserError : it leads out of the folder, or another file is called so there.
    """
    path = folder / name
    _require_inside(path, folder)
    if os.path.lexists(path):
        raise UserError(Problem("would be written twice: two of the project's names give one file's name", name))
    return path


def write_text(path: Path, text: str) -> None:
    """Write a text of the result in UTF-8.

    Raises
    ------
    UserError : while a run writes its folder, the path leads out of it.
    """
    _require_within_run(path)
    path.write_text(text, encoding="utf-8", newline="\n")


def write_json(path: Path, value: Any) -> None:
    """Write JSON with 10 significant digits, keys in the order given, and a newline at the end.

    Raises
    ------
    ValueError
        For a number that is not finite, with the path of its key: JSON has no such number.
    TypeError
        For a value that is no mapping, sequence, array, number, text, bool or None.
    UserError
        As ``write_text``.
    """
    write_text(path, _json(_plain(value, ""), 0) + "\n")


def write_csv(path: Path, columns: Mapping[str, Sequence[Any] | np.ndarray[Any, Any]]) -> None:
    """Write columns of equal length under their headers; numbers to 10 digits, nan and None as empty cells.

    Raises
    ------
    ValueError
        If the columns differ in length or a number is infinite.
    UserError
        As ``write_text``.
    """
    _require_within_run(path)
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows(zip(*(_cells(column) for column in columns.values()), strict=True))


def sha256_file(path: str | Path) -> str:
    """The file's SHA-256 in hexadecimal."""
    with Path(path).open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def stems(names: Sequence[str]) -> list[str]:
    """A file name a trial, from its own: unique, and without folders."""
    found: list[str] = []
    for name in names:
        stem = Path(name).stem
        if stem in found:
            stem = name.replace("/", "__").removesuffix(".csv")
        while stem in found:
            stem += "_"
        found.append(stem)
    return found


def _require_inside(path: Path, folder: Path) -> None:
    """Refuse a path that, links followed, does not lie below the folder."""
    if folder.resolve() not in path.resolve().parents:
        raise UserError(Problem("leads out of the folder that is written; nothing is written there", str(path)))


def _require_within_run(path: Path) -> None:
    """Refuse to write elsewhere while a run writes its folder; without one, any place is the caller's to choose."""
    if _written:
        _require_inside(path, _written[-1])


def _check_target(target: Path, name: str, overwrite: bool) -> None:
    """Refuse to replace anything but an empty folder or an earlier run."""
    if target == Path.cwd() or target in Path.cwd().parents:
        raise UserError(Problem("is the current folder or lies above it; name a folder to make", name))
    try:
        if not target.exists():
            return
        if not target.is_dir():
            raise UserError(Problem("is a file; name a folder", name))
        held = sorted(entry.relative_to(target).as_posix() for entry in target.rglob("*") if not entry.is_dir())
        folders = any(entry.is_dir() for entry in target.iterdir())
        manifest = target / MANIFEST
        ours = set(manifest.read_text(encoding="utf-8").splitlines()) if manifest.is_file() else set()
    except OSError as error:
        raise UserError(Problem(f"cannot be read: {error.strerror}", name)) from None
    foreign = [file for file in held if file not in ours and file.rpartition("/")[2] not in _IGNORED]
    if foreign or (folders and not ours):
        shown = ", ".join(foreign[:3]) + (" ..." if len(foreign) > 3 else "") if foreign else "folders"
        raise UserError(
            Problem(f"holds what no earlier run wrote ({shown}); name a new folder or move that away", name)
        )
    if ours and not overwrite:
        raise UserError(Problem("holds an earlier run; name a new folder or remove it", name))


def _complete(folder: Path) -> None:
    """Add the manifest, and the permissions that the user's other folders have (mkdtemp gives 0700)."""
    files = sorted(entry.relative_to(folder).as_posix() for entry in folder.rglob("*") if not entry.is_dir())
    (folder / MANIFEST).write_text("".join(f"{file}\n" for file in files), encoding="utf-8")
    mask = os.umask(0)
    os.umask(mask)
    folder.chmod(0o777 & ~mask)


def _move(temporary: Path, target: Path) -> None:
    """Put the finished folder in place of what is there; if that fails, what was there comes back."""
    if not target.exists():
        temporary.rename(target)
        return
    aside = Path(tempfile.mkdtemp(prefix=f".{target.name}.replaced-", dir=target.parent))
    old = aside / "old"
    try:
        target.rename(old)
        try:
            temporary.rename(target)
        except BaseException:
            old.rename(target)
            raise
    finally:
        shutil.rmtree(aside, ignore_errors=True)


def _make_parents(folder: Path) -> list[Path]:
    """Make missing folders; returns those made, innermost first."""
    missing = [parent for parent in (folder, *folder.parents) if not parent.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    return missing


def _remove_empty(folders: Sequence[Path]) -> None:
    for folder in folders:
        with suppress(OSError):
            folder.rmdir()


@contextmanager
def _terminated_as_exception() -> Iterator[None]:
    """Let SIGTERM unwind like an interrupt, so that the temporary folder goes; only the main thread may set it."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def stop(number: int, frame: FrameType | None) -> None:
        raise SystemExit(128 + number)

    previous = signal.signal(signal.SIGTERM, stop)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, previous)


def _plain(value: Any, key: str) -> Any:
    """Mappings, lists and rounded numbers only."""
    if isinstance(value, Mapping):
        for name in value:
            if not isinstance(name, str):
                raise TypeError(f"{key or 'the result'} has the key {name!r}, which is no text")
        return {name: _plain(item, f"{key}.{name}" if key else name) for name, item in value.items()}
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, (list, tuple)):
        return [_plain(item, f"{key}[{index}]") for index, item in enumerate(value)]
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


def _json(value: Any, depth: int) -> str:
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
        parts = [f"{json.dumps(name, ensure_ascii=False)}: {_json(item, depth + 1)}" for name, item in value.items()]
    else:
        parts = [_json(item, depth + 1) for item in value]
    left, right = "{}" if isinstance(value, dict) else "[]"
    return f"{left}\n{pad}" + f",\n{pad}".join(parts) + f"\n{'  ' * depth}{right}"


def _cells(column: Sequence[Any] | np.ndarray[Any, Any]) -> list[str]:
    """A column's cells; those of an array of numbers, most of what is written, without asking of each what it is."""
    if not (isinstance(column, np.ndarray) and column.dtype == np.float64 and column.ndim == 1):
        return [_cell(value) for value in column]
    if np.any(np.isinf(column)):
        _cell(column[np.isinf(column)][0])
    # + 0.0: no minus zero; nan alone differs from itself
    return [f"{value:.{DIGITS}g}" if value == value else "" for value in (column + 0.0).tolist()]


def _cell(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, (bool, np.bool_)):
        return "yes" if value else "no"
    if isinstance(value, (float, np.floating)):
        if math.isinf(value):
            raise ValueError(f"a cell is {value}: such a number must not reach a result file")
        return "" if math.isnan(value) else f"{_rounded(float(value)):.{DIGITS}g}"
    return str(value)
