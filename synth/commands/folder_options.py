"""Options that only a folder of projects takes, and those that it does not take."""

from __future__ import annotations

import argparse

from synth.errors import Problem, UserError


def refuse_options(arguments: argparse.Namespace, names: tuple[str, ...], why: str) -> None:
    """Refuse options that do not apply.

    Raises
    ------
    UserError : one of them was given; ``why`` says what to do instead.
    """
    given = [name for name in names if getattr(arguments, name.replace("-", "_")) not in (None, False, [])]
    if given:
        raise UserError([Problem(f"{arguments.file} {why}", key=f"--{name}") for name in given])


def only_for_folders(arguments: argparse.Namespace) -> None:
    """Refuse ``--scheduler`` and ``--workers`` for a single project.

    Raises
    ------
    UserError : one of them was given.
    """
    refuse_options(arguments, ("scheduler", "workers"), "is a single project; this applies to a folder of projects")
