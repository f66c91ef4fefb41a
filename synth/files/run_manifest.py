"""The list of a run's files in its folder, by which the next run knows what it may replace: what the run wrote itself,
nobody changed since, and this run does not read.
"""

from __future__ import annotations

import hashlib
import os
import re
from collections.abc import Collection, Iterable, Sequence
from pathlib import Path

from synth.errors import Problem, UserError

MANIFEST = ".synth-output"  # a line for every file: SHA-256, two spaces, its name, as of sha256sum
_LINE = re.compile(r"(?:([0-9a-f]{64})  )?(.+)")  # earlier versions wrote the name alone
_IGNORED = frozenset({MANIFEST, ".DS_Store", "Thumbs.db", "desktop.ini"})
_SHOWN = 3  # names in a message


def sha256_file(path: str | Path) -> str:
    """The file's SHA-256 in hexadecimal."""
    with Path(path).open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def write_manifest(folder: Path, files: Sequence[str]) -> None:
    """Write the list of a run's ``files``, by their names in the folder."""
    lines = (f"{sha256_file(folder / file)}  {file}\n" for file in files)
    (folder / MANIFEST).write_text("".join(lines), encoding="utf-8")


def refuse_unless_replaceable(
    target: Path, name: str, inputs: Iterable[Path], contents: Collection[str], *, overwrite: bool
) -> None:
    """Refuse to replace a folder that holds anything but an unchanged earlier run.

    Parameters
    ----------
    target, name : the folder, and its name as the user wrote it.
    inputs : files that this run reads.
    contents : SHA-256 of files that it read, wherever they lay.

    Raises
    ------
    UserError : it holds files that no run wrote, that were changed since, or that are inputs of this run, or it holds
        an earlier run and ``overwrite`` is False. OSError as the file system raises it.
    """
    held = sorted(entry.relative_to(target).as_posix() for entry in target.rglob("*") if not entry.is_dir())
    folders = any(entry.is_dir() for entry in target.iterdir())
    manifest = target / MANIFEST
    lines = manifest.read_text(encoding="utf-8").splitlines() if manifest.is_file() else []
    ours = {match[2]: match[1] for line in lines if (match := _LINE.fullmatch(line))}
    foreign = [file for file in held if file not in ours and file.rpartition("/")[2] not in _IGNORED]
    if foreign or (folders and not ours):
        shown = _listed(foreign) if foreign else "folders"
        raise UserError(
            Problem(f"holds what no earlier run wrote ({shown}); name a new folder or move that away", name)
        )
    if ours and not overwrite:
        raise UserError(Problem("holds an earlier run; name a new folder or remove it", name))
    read = {os.path.realpath(path) for path in inputs}
    hashed = {file: sha256_file(target / file) for file in held if ours.get(file)}
    if needed := [f for f in held if os.path.realpath(target / f) in read or hashed.get(f) in contents]:
        text = f"holds what this run reads ({_listed(needed)}) and would be replaced with it; name another folder"
        raise UserError(Problem(text, name))
    if changed := [file for file, found in hashed.items() if found != ours[file]]:
        text = f"holds files that were changed after the run that wrote them ({_listed(changed)}); "
        raise UserError(Problem(f"{text}name a new folder, or move them away", name))


def _listed(files: Sequence[str]) -> str:
    return ", ".join(files[:_SHOWN]) + (" ..." if len(files) > _SHOWN else "")
