"""Legs and recordings from files or from code."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

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
    catalogue = Catalogue.load([Path(name) for name in catalogs]) if catalogs else None
    return _read_leg(path, resolve_part=resolver(catalogue))


def write_leg(leg: Leg, path: str | Path) -> None:
    """Write a leg file that ``read_leg`` restores within 1e-14; a damper's curve goes to a separate CSV.

    Raises
    ------
    UserError
        With every mistake of a leg that ``read_leg`` would refuse; nothing is written then.
    """
    check_leg(leg, in_code(IN_CODE))
    _write_leg(leg, path)


def read_trials(
    files: str | Path | Sequence[str | Path | Mapping[str, Any]], leg: Leg, *, folder: str | Path | None = None
) -> tuple[Trial, ...]:
    """Read recordings of a leg.

    Parameters
    ----------
    files
        one file, a list of paths such as ``sorted(folder.glob("*.csv"))``, or what a project lists under ``trials:``:
        files, globs, or mappings such as ``{"file": "heavy.csv", "tip_mass": "50 g"}``.
    leg
        the leg whose joints the columns belong to.
    folder
        the folder that the names are relative to; default: the current one, of paths alone the one that holds all.

    Raises
    ------
    UserError
        With every mistake of the list and of all files, or of a leg made in code.
    """
    check_leg(leg, in_code(IN_CODE))
    if isinstance(files, Path) or (isinstance(files, str) and folder is None):
        whole = Path(files)
        return tuple(_read_trials([whole.name], whole.parent if folder is None else Path(folder) / whole.parent, leg))
    entries = [files] if isinstance(files, str) else list(files)
    if not entries:
        raise UserError('name a recording: read_trials(["trials/*.csv"], leg)')
    paths = [entry for entry in entries if isinstance(entry, Path)]
    where = Path(folder or ".")
    if folder is None and len(paths) == len(entries):
        where = Path(os.path.commonpath([path.absolute().parent for path in paths]))
    names = [_name_in(where, entry) if isinstance(entry, Path) else entry for entry in entries]
    return tuple(_read_trials(names, where, leg))


def _name_in(folder: Path, path: Path) -> str:
    """A path as a project's list names it: relative to the folder, as given or where the whole path lies below it."""
    given = folder.absolute() / path  # the path itself, if it is absolute
    whole = given if given.exists() else path.absolute()
    top = folder.absolute()
    return whole.relative_to(top).as_posix() if whole.is_relative_to(top) else str(path)
