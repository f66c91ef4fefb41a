"""How a task ended, in a form that travels between processes and machines."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import traceback
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import synth
from synth.errors import Problem, UserError
from synth.threads import VARIABLE

PACKAGES = ("numpy", "numba", "scipy")  # whose version can change a number


@dataclass(frozen=True, eq=False)
class Ended:
    """``value``, or the ``problems`` that the user is told, or the traceback of a ``crash`` of ours.

    ``other`` : versions at the worker, where they are not the caller's and nothing was done.
    """

    value: Any = None
    problems: tuple[Problem, ...] = ()
    crash: str = ""
    other: str = ""


def versions() -> dict[str, str]:
    """What a worker must have the same as whoever sends it tasks, for the same bytes."""
    found = {"python": ".".join(platform.python_version_tuple()[:2]), "synth": synth.__version__}
    return found | {name: importlib.metadata.version(name) for name in PACKAGES}


def differences(wanted: Mapping[str, str], found: Mapping[str, str | None]) -> str:
    """``numpy 2.1 instead of 2.4``, for each that differs; empty where none does."""
    return ", ".join(
        f"{name} {found.get(name) or 'missing'} instead of {version}"
        for name, version in wanted.items()
        if found.get(name) != version
    )


def performed(function: Callable[[Any], Any], argument: Any, wanted: Mapping[str, str] | None = None) -> Ended:
    """Call the function in a process that does nothing but such tasks."""
    os.environ.setdefault(VARIABLE, "1")  # the cores are taken by other tasks
    if wanted is not None and (other := differences(wanted, versions())):
        return Ended(other=other)
    try:
        return Ended(value=function(argument))
    except UserError as error:
        return Ended(problems=tuple(error.problems))
    except Exception:
        return Ended(crash=traceback.format_exc())
