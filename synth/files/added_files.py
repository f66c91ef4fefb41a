"""Files that a command adds to a folder of the user's: it replaces only what it wrote itself and nobody changed.

The folder keeps a record of every content that was written, in the form of ``sha256sum``. A file with one of these
contents holds nothing of the user's; any other is his, whoever made it first.
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping
from dataclasses import dataclass
from glob import escape
from pathlib import Path

from synth.errors import Problem, UserError
from synth.files.leftovers import one_at_a_time
from synth.files.output import disk_errors_as, umask, write_bytes_whole
from synth.files.paths import read_bytes
from synth.files.run_manifest import MANIFEST
from synth.files.signals import terminated_as_exception

RECORD = ".synth-added"  # a line for every content ever written to the folder: SHA-256, two spaces, the file's name
MOST_BYTES = 50_000_000  # of a file that may be replaced, as of a catalogue; a larger one is not ours


@dataclass(frozen=True)
class StandingFile:
    """A file where another is to be written. ``changed`` : its content was never written; ``ours`` : its name was."""

    name: str
    changed: bool
    ours: bool


def standing_files(folder: Path, files: Mapping[str, bytes]) -> tuple[StandingFile, ...]:
    """Those of ``files`` (name: content) that stand in the folder with another content.

    Raises
    ------
    UserError : the folder or its record cannot be read, or the folder is the result of a run.
    """
    if not os.path.lexists(folder):
        return ()
    if not folder.is_dir():
        raise UserError(Problem("is a file; name a folder", str(folder)))
    if os.path.lexists(folder / MANIFEST):
        text = (
            "says that this folder is the result of one run, and the next may replace it with all it holds; remove "
            "this file if the folder is yours, or name another folder with --out"
        )
        raise UserError(Problem(text, str(folder / MANIFEST)))
    known = _record(folder)
    found = []
    for name, content in files.items():
        path = folder / name
        if not os.path.lexists(path):
            continue
        if path.is_symlink():
            raise UserError(Problem("is a link; name another folder with --out", str(path)))
        held = read_bytes(path, MOST_BYTES, "no file of this name was written by this command")
        if held != content:
            found.append(StandingFile(name, _digest(held) not in known.get(name, ()), name in known))
    return tuple(found)


def add_files(folder: Path, files: Mapping[str, bytes]) -> None:
    """Write each file whole; make the folder where it is missing. All others in it stay as they are.

    The record is written first: after a kill between two files both their old and new contents are known.

    Raises
    ------
    UserError : a file was changed since it was written (``standing_files``), or the disk does not take it.
    """
    with disk_errors_as(str(folder)), terminated_as_exception():
        folder.mkdir(parents=True, exist_ok=True)
        with one_at_a_time(folder):
            if changed := [each.name for each in standing_files(folder, files) if each.changed]:
                raise UserError(Problem("was changed meanwhile; nothing is written", str(folder / changed[0])))
            known = _record(folder)
            for name, content in files.items():
                known[name] = tuple(dict.fromkeys((*known.get(name, ()), _digest(content))))
            lines = [f"{digest}  {name}\n" for name in sorted(known) for digest in known[name]]
            write_bytes_whole(folder / RECORD, "".join(lines).encode(), 0o666 & ~umask())
            for name, content in files.items():
                path = folder / name
                for left in folder.glob(f".{escape(name)}.*.partial"):  # of a killed run; no other writes here now
                    left.unlink()
                mode = path.stat().st_mode & 0o777 if path.exists() else 0o666 & ~umask()
                write_bytes_whole(path, content, mode)


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _record(folder: Path) -> dict[str, tuple[str, ...]]:
    """The digests that were written under each name; UserError for a record that is none."""
    path = folder / RECORD
    if not os.path.lexists(path):
        return {}
    known: dict[str, tuple[str, ...]] = {}
    text = read_bytes(path, MOST_BYTES, "remove it").decode("utf-8", "replace")
    for number, line in enumerate(text.splitlines(), 1):
        digest, blanks, name = line.partition("  ")
        if not blanks or not name:
            remedy = "every file in this folder then counts as yours"
            raise UserError(
                Problem(f"is not a line SHA-256, two spaces, name; remove this file: {remedy}", str(path), number)
            )
        known[name] = (*known.get(name, ()), digest)
    return known
