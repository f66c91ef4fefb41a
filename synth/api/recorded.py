"""Legs and recordings from files or from code."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from glob import escape
from pathlib import Path
from typing import Any

from synth.api.beside_project import require_path
from synth.api.report import IN_CODE
from synth.errors import UserError
from synth.files.leg_file import read_leg as _read_leg
from synth.files.leg_file import write_leg as _write_leg
from synth.files.leg_in_code import check_leg
from synth.files.made_in_code import in_code
from synth.files.trial_list import Trial
from synth.files.trial_list import read_trials as _read_trials
from synth.parts.catalogs import Catalogue
from synth.parts.resolver import resolver
from synth.swing.leg_model import Leg


def read_leg(path: str | Path, *, catalogs: Sequence[str | Path] = ()) -> Leg:
    """Read a leg file (``*.leg.yaml``).

    Parameters
    ----------
    path
        the file; curve files that it names must lie below its folder.
    catalogs
        your own catalogue tables, searched for the file's parts in addition to the built-in ones.

    Returns
    -------
    Leg
        in SI units and radians. It equals a leg of the same numbers built from ``Leg``, ``Joint``, ``Link``,
        ``Spring`` and ``Damper``.

    Raises
    ------
    UserError
        With every mistake of the file.
    """
    require_path(path, 'read_leg("robot.leg.yaml")')
    catalogue = Catalogue.load([Path(name) for name in catalogs]) if catalogs else None
    files = [Path(path)]
    leg = _read_leg(path, resolve_part=resolver(catalogue), opened=files.append)
    return replace(leg, read_from=tuple(os.path.realpath(file) for file in files))


def write_leg(leg: Leg, path: str | Path) -> None:
    """Write a leg file that ``read_leg`` restores within 1e-14; a damper's curve goes to a separate CSV.

    Raises
    ------
    UserError
        With every mistake of a leg that ``read_leg`` would refuse; nothing is written then.
    """
    check_leg(leg, in_code(IN_CODE))
    require_path(path, 'write_leg(leg, "robot.leg.yaml")')
    _write_leg(leg, path)


def read_trials(
    files: str | Path | Sequence[str | Path | Mapping[str, Any]], leg: Leg, *, folder: str | Path | None = None
) -> tuple[Trial, ...]:
    """Read recordings of a leg.

    Parameters
    ----------
    files
        one file, a list of paths such as ``sorted(folder.glob("*.csv"))``, or what a project lists under ``trials:``:
        files, globs, or mappings such as ``{"file": "heavy.csv", "tip_mass": "50 g"}``. Whole paths may be text too.
    leg
        the leg whose joints the columns belong to.
    folder
        the folder that the names are relative to; default: the current one. A trial is named from it; where whole
        paths lie elsewhere, or paths alone are given, from the folder that holds all.

    Raises
    ------
    UserError
        With every mistake of the list and of all files, or of a leg made in code.
    """
    check_leg(leg, in_code(IN_CODE))
    if isinstance(files, Path) or (isinstance(files, str) and (folder is None or Path(files).is_absolute())):
        whole = Path(folder or ".") / files
        where = _fixed_folder(whole)
        return tuple(_read_trials([whole.relative_to(where).as_posix()], where, leg))
    if not isinstance(files, Iterable):
        raise UserError(f'{files!r:.80} is no list of recordings: synth.read_trials(["trials/*.csv"], leg)')
    entries = [files] if isinstance(files, str) else list(files)
    if not entries:
        raise UserError('name a recording: read_trials(["trials/*.csv"], leg)')
    base = Path(folder or ".")
    paths = [_path_of(entry) for entry in entries]
    where = _folder_of_all(base, paths, whole=folder is None)
    names = [_entry_in(where, base, entry, path) for entry, path in zip(entries, paths, strict=True)]
    return tuple(_read_trials(names, where, leg))


Entry = str | Path | Mapping[str, Any]


def _path_of(entry: Entry) -> Path | None:
    """The path of an entry that is one, or whose text is a whole one; None for text of a project's list."""
    text = entry.get("file") if isinstance(entry, Mapping) else entry
    if isinstance(text, Path):
        return text
    return Path(text) if isinstance(text, str) and Path(text).is_absolute() else None


def _folder_of_all(base: Path, paths: Sequence[Path | None], *, whole: bool) -> Path:
    """The folder that holds every recording: ``base``, or what holds it and the whole paths that lie elsewhere.

    ``whole`` : of paths alone it is the one that holds them, wherever ``base`` is.
    """
    given = [_fixed_folder(path.absolute()) for path in paths if path is not None and (whole or path.is_absolute())]
    if whole and None not in paths:
        return Path(os.path.commonpath(given))
    top = base.absolute()
    outside = [place for place in given if not place.is_relative_to(top)]
    return Path(os.path.commonpath([top, *outside])) if outside else base


def _fixed_folder(path: Path) -> Path:
    """The deepest folder of a path, or of a glob, whose name is no pattern."""
    named = (place for place in path.parents if place.is_dir() or not any(sign in str(place) for sign in "*?["))
    return next(named, path)


def _entry_in(where: Path, base: Path, entry: Entry, path: Path | None) -> str | Mapping[str, Any]:
    """An entry as a project in the folder ``where`` lists it; text is relative to ``base``."""
    if path is not None:
        name = _name_in(where, base, path)
        return {**entry, "file": name} if isinstance(entry, Mapping) else name
    assert not isinstance(entry, Path)
    text = entry.get("file") if isinstance(entry, Mapping) else entry
    if where == base or not isinstance(text, str):
        return entry
    above = base.absolute().relative_to(where).as_posix()
    pattern = any(sign in text for sign in "*?[")
    name = f"{escape(above) if pattern else above}/{text}"
    return {**entry, "file": name} if isinstance(entry, Mapping) else name


def _name_in(folder: Path, base: Path, path: Path) -> str:
    """A path as a list in ``folder`` names it: relative to ``base``, as given or where the whole path lies below it."""
    given = base.absolute() / path  # the path itself, if it is absolute
    whole = given if given.exists() else path.absolute()
    top = folder.absolute()
    return whole.relative_to(top).as_posix() if whole.is_relative_to(top) else str(path)
