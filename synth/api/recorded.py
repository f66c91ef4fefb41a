"""Legs and recordings: read from files, or made of numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from synth.errors import UserError
from synth.files.leg_file import read_leg as _read_leg
from synth.files.leg_file import write_leg as _write_leg
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
        the file; curves that it names lie in its folder's tree.
    catalogs
        your own catalogue tables, in which parts that the file names are looked up beside the built-in ones.

    Returns
    -------
    Leg
        in SI units and radians. One made in code of ``Leg``, ``Joint``, ``Link``, ``Spring`` and ``Damper`` with the
        same numbers is equal to it.

    Raises
    ------
    UserError
        With every mistake of the file.
    """
    catalogue = Catalogue.load([Path(name) for name in catalogs]) if catalogs else None
    return _read_leg(path, resolve_part=resolver(catalogue))


def write_leg(leg: Leg, path: str | Path) -> None:
    """Write a leg file that ``read_leg`` gives back within 1e-14; a damper's curve goes to a CSV beside it."""
    _write_leg(leg, path)


def read_trials(
    files: str | Path | Sequence[str | Mapping[str, Any]], leg: Leg, *, folder: str | Path | None = None
) -> tuple[Trial, ...]:
    """Read recordings of a leg.

    Parameters
    ----------
    files
        one file, or what a project lists under ``trials:``: files, globs, or mappings such as
        ``{"file": "heavy.csv", "tip_mass": "50 g"}``.
    leg
        whose joints the columns are.
    folder
        what the names are relative to; without it the current folder, and of a single file its own.

    Raises
    ------
    UserError
        With every mistake of the list and of all files.
    """
    if isinstance(files, Path) or (isinstance(files, str) and folder is None):
        whole = Path(files)
        return tuple(_read_trials([whole.name], whole.parent if folder is None else Path(folder) / whole.parent, leg))
    entries = [files] if isinstance(files, str) else list(files)
    if not entries:
        raise UserError('no recording is named: read_trials(["trials/*.csv"], leg)')
    return tuple(_read_trials(entries, Path(folder or "."), leg))
