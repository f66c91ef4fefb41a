"""Argument types that commands share: names with suggestions, quantities with units."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Iterable
from math import isfinite, nan

from synth.errors import Problem, UserError, did_you_mean


def near_miss(name: str, known: Iterable[str], most: int = 1) -> str:
    """``; did you mean ...?`` with up to ``most`` similar names; empty where no name is similar."""
    return did_you_mean(name, known, most)


def one_of(known: Iterable[str]) -> Callable[[str], str]:
    """An argument type: one of the given names; a misspelt one gets a suggestion."""
    names = list(known)

    def check(text: str) -> str:
        if text in names:
            return text
        raise argparse.ArgumentTypeError(f'"{text}" is not one of {", ".join(names)}{near_miss(text, names)}')

    check.words = tuple(names)  # type: ignore[attr-defined]  # for `synth completion`
    return check


def cluster_argument(parser: argparse.ArgumentParser) -> None:
    """Declare ``--scheduler``."""
    words = "run on a Dask cluster, its scheduler at tcp://HOST:PORT; needs the extra limb-synth[cluster]"
    parser.add_argument("--scheduler", metavar="ADDRESS", help=words)


def workers_argument(parser: argparse.ArgumentParser) -> None:
    """Declare ``--workers``."""
    parser.add_argument(
        "--workers", type=count, metavar="N", help="number of projects to fit in parallel (default: all cores)"
    )


def count(text: str) -> int:
    """An argument type: a positive whole number."""
    if text.isdecimal() and int(text) > 0:
        return int(text)
    raise argparse.ArgumentTypeError(f'"{text}" is not a whole number of at least 1')


def empty_arguments(parser: argparse.ArgumentParser, arguments: argparse.Namespace) -> list[Problem]:
    """A problem for each argument whose value is an empty text, as of a shell's variable that is not set.

    As a path it would be the current folder, or pass for an option that was not given.
    """
    found = []
    for action in parser._actions:
        given = getattr(arguments, action.dest, None)
        values = given if isinstance(given, list) else [given]
        if any(isinstance(value, str) and not value.strip() for value in values):
            metavar = str(action.metavar or action.dest)
            key = action.option_strings[-1] if action.option_strings else metavar
            how = f"write {key} {metavar}" if action.option_strings else "name one"
            found.append(Problem(f"is empty; {'name a folder to make' if metavar == 'DIR' else how}", key=key))
    return found


_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,3})?", re.ASCII)


class Quantities:
    """Reads quantities of a command line; collects all mistakes until ``require`` raises them together."""

    def __init__(self, arguments: argparse.Namespace) -> None:
        self._arguments = arguments
        self.problems: list[Problem] = []

    def given(self, option: str) -> bool:
        """Whether the option was given."""
        return getattr(self._arguments, option[2:].replace("-", "_")) is not None

    def read(self, option: str, unit: str, *, positive: bool = True) -> float | None:
        """The option's value in ``unit``; None where it is absent or wrong.

        ``positive``: refuse values of 0 or below.
        """
        from synth.units import parse

        text = getattr(self._arguments, option[2:].replace("-", "_"))
        if text is None:
            return None
        try:
            value = parse(text, unit)
        except UserError as error:
            self.problems += [Problem(problem.text, key=option) for problem in error.problems]
            return None
        if value <= 0.0 and positive:
            self.problems.append(Problem(f'"{text}" must be above 0', key=option))
            return None
        return value

    def number(self, option: str, example: str) -> float | None:
        """The option's value as a plain number; None where it is absent or wrong."""
        text = getattr(self._arguments, option[2:].replace("-", "_"))
        if text is None:
            return None
        try:
            value = float(text) if _NUMBER.fullmatch(text.strip()) else nan
        except ValueError:
            value = nan
        if not (isfinite(value) and value > 0.0):
            self.problems.append(Problem(f'"{text}" is not a number above 0; write it like {example}', key=option))
            return None
        return value

    def require(self) -> None:
        """Raise UserError with all collected mistakes."""
        if self.problems:
            raise UserError(self.problems)
