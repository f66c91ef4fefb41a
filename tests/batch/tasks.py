"""Tasks that end in every way; importable, so that spawned processes find them."""

from __future__ import annotations

import os
import signal
from pathlib import Path

from synth.errors import Problem, UserError


def task(words: str) -> str:
    """``mistake``, ``fault``, ``kill FILE`` (its own process, once or for ever), or the words in capitals."""
    if words == "mistake":
        raise UserError(Problem("is wrong", "a.yaml", 3))
    if words == "fault":
        raise ZeroDivisionError("ours")
    if words.startswith("kill once "):
        mark = Path(words.removeprefix("kill once "))
        if not mark.exists():
            mark.touch()
            os.kill(os.getpid(), signal.SIGKILL)
    if words == "kill":
        os.kill(os.getpid(), signal.SIGKILL)
    return words.upper()
