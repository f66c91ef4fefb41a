"""The outcome of a task, in a form that can be sent between processes and machines."""

from __future__ import annotations

import os
import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from synth.errors import Problem, UserError
from synth.files.program_versions import versions
from synth.swing.effects.users_own import OwnFile
from synth.swing.foreign_effects import know
from synth.threads import VARIABLE


@dataclass(frozen=True, eq=False)
class TaskOutcome:
    """``value``, or the ``problems`` for the user, or the traceback of an internal ``crash``.

    ``other`` : the worker's versions, if they differ and nothing was run.
    """

    value: Any = None
    problems: tuple[Problem, ...] = ()
    crash: str = ""
    other: str = ""


def differences(wanted: Mapping[str, str], found: Mapping[str, str | None]) -> str:
    """``numpy 2.1 instead of 2.4`` for each version that differs; empty if none does."""
    return ", ".join(
        f"{name} {found.get(name) or 'missing'} instead of {version}"
        for name, version in wanted.items()
        if found.get(name) != version
    )


def performed(
    function: Callable[[Any], Any],
    argument: Any,
    wanted: Mapping[str, str] | None = None,
    effects: Sequence[OwnFile] = (),
) -> TaskOutcome:
    """Call the function in a process that only runs such tasks; ``effects`` : those of the user that it must know."""
    os.environ.setdefault(VARIABLE, "1")  # the other cores run other tasks
    if wanted is not None and (other := differences(wanted, versions())):
        return TaskOutcome(other=other)
    try:
        for file in effects:
            know(file)
        return TaskOutcome(value=function(argument))
    except UserError as error:
        return TaskOutcome(problems=tuple(error.problems))
    except Exception:
        return TaskOutcome(crash=traceback.format_exc())
