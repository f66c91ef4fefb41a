"""Tasks that end in every way; importable, so that spawned processes find them."""

from __future__ import annotations

import os
import signal
import sys
import tempfile
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


DIAGNOSIS = """
import json, os, sys, tempfile, time
from pathlib import Path
from synth.commands.watched import ENDS_WITH_INPUT, end_with_input
if ENDS_WITH_INPUT in sys.argv:
    end_with_input()
place = Path({note!r})
part = place.with_suffix(".part")
part.write_text(json.dumps(dict(process=os.getpid(), folder=tempfile.mkdtemp())))
part.rename(place)
time.sleep(60)
"""


def diagnose_for_long(note: str) -> None:
    """A rehearsal's diagnosis that notes its number and a temporary folder in a file, and lasts a minute."""
    from synth.rehearsal import one_case

    with tempfile.TemporaryDirectory(prefix="synth-one-") as name:
        folder = Path(name)
        (folder / "commands").mkdir()
        (folder / "commands" / "watched.py").write_text(DIAGNOSIS.format(note=note))
        one_case.PACKAGE = folder
        os.environ["PYTHONPATH"] = os.pathsep.join(sys.path)
        one_case.diagnose_apart(folder / "gap.yaml", folder / "out", [])


def large(megabytes: int) -> bytes:
    """A result that takes many reads of a pipe."""
    return b"x" * (megabytes * 1_000_000)
