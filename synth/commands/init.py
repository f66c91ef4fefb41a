"""``synth init``: write an example project to start from."""

from __future__ import annotations

import argparse
import os
import shlex
import shutil
from pathlib import Path
from typing import TYPE_CHECKING

from synth.commands.arguments import one_of
from synth.errors import Problem, UserError
from synth.files.leftovers import PARTIAL, held_folder, remove_leftovers

if TYPE_CHECKING:
    from synth.commands.progress import Progress

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
PROJECTS = {
    "leg": "leg-design.yaml",
    "fit": "fit.yaml",
    "hopper": "hopper.yaml",
    "gap": "gap.yaml",
}  # example -> its project file


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    kinds = "|".join(PROJECTS)
    parser.add_argument("kind", type=one_of(PROJECTS), metavar=kinds, help="which command it is for")
    parser.add_argument("folder", metavar="DIR", help="folder to write; must not exist or be empty")


def run(arguments: argparse.Namespace, progress: Progress) -> int:
    """Copy the example and say what to run next."""
    target = Path(arguments.folder)
    copy_example(EXAMPLES / arguments.kind, target)
    project = target / PROJECTS[arguments.kind]
    command = shlex.join(["synth", arguments.kind, str(project), "--out", str(target / "result")])
    progress.say(f"{target} holds the example; {target / 'README.md'} says what it is. Next:")
    progress.say(f"  {command}")
    return 0


def copy_example(source: Path, target: Path) -> None:
    """Copy a folder, whole or not at all.

    Raises
    ------
    UserError
        If the target is a file, holds anything, or cannot be written.
    """
    name = str(target)
    try:
        whole = target.resolve()
        if whole.is_dir() and any(whole.iterdir()):
            raise UserError(Problem("is not empty; name a new folder", name))
        if whole.exists() and not whole.is_dir():
            raise UserError(Problem("is a file; name a new folder", name))
        above = next(parent for parent in whole.parents if parent.exists())
        if not above.is_dir():
            raise UserError(Problem(f"cannot be written: {above} is a file", name))
        whole.parent.mkdir(parents=True, exist_ok=True)
        remove_leftovers(whole.parent, PARTIAL.format(whole.name))
        temporary, lock = held_folder(whole.parent, PARTIAL.format(whole.name))
        try:
            made = temporary / "project"
            # Contents only: an installed package may be read-only, and a project is there to be edited.
            ignore = shutil.ignore_patterns("__pycache__", ".*")
            shutil.copytree(source, made, ignore=ignore, copy_function=shutil.copyfile)
            for folder in (made, *(path for path in made.rglob("*") if path.is_dir())):
                folder.chmod(folder.stat().st_mode | 0o700)
            if whole.exists():  # and is empty; it may be the current folder, so it stays what it is
                for entry in made.iterdir():
                    entry.rename(whole / entry.name)
            else:
                made.rename(whole)
        finally:
            shutil.rmtree(temporary, ignore_errors=True)
            if lock is not None:
                os.close(lock)
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        reason = getattr(error, "strerror", None) or str(error)
        raise UserError(Problem(f"cannot be written: {reason}", name)) from None
