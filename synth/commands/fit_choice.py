"""Fit options on the command line; they override the project file's ``fit:``."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from synth.commands.arguments import one_of

if TYPE_CHECKING:
    from synth.files.project_options import FitOptions

# Options of ``fit:`` that may be given here; ``fit_words`` lists the values of each.
_CHOICES = {
    "method": "estimation method",
    "cost": "cost function to minimise",
    "weight": "weight of the residuals",
    "intervals": "method for the intervals; bootstrap: 200 refits",
}


def add_fit_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare ``--method``, ``--cost``, ``--weight`` and ``--intervals``."""
    from synth.files.fit_words import allowed_values

    for name, text in _CHOICES.items():
        allowed = allowed_values(name)
        messages = f"{text}: {', '.join(allowed)} (default: the project's fit:)"
        parser.add_argument(f"--{name}", type=one_of(allowed), metavar="NAME", help=messages)


def fit_choice(written: FitOptions, arguments: argparse.Namespace) -> FitOptions:
    """The project's options, overridden by those of the command line."""
    from dataclasses import replace

    given: dict[str, Any] = {name: getattr(arguments, name) for name in _CHOICES}
    return replace(written, **{name: value for name, value in given.items() if value is not None})


def not_for_folders(arguments: argparse.Namespace) -> None:
    """Refuse these options for a folder: each project states its own.

    Raises
    ------
    UserError : one of them was given.
    """
    from synth.errors import Problem, UserError

    given = [name for name in _CHOICES if getattr(arguments, name) is not None]
    if given:
        text = f"applies to one project; {arguments.file} is a folder: write it under fit: in each project"
        raise UserError([Problem(text, key=f"--{name}") for name in given])
