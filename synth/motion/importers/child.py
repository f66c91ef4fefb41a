"""Reads a binary file in a separate process, because a C library may crash on a damaged file."""

from __future__ import annotations

import io
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

from synth.errors import Problem, UserError

TIME_LIMIT = 600.0  # s, a choice: far above the time for the largest permitted files

# Text before and after the reading code, which creates the dictionary `arrays` from the file `path`.
_BEFORE = "import io, sys\nimport numpy\npath = sys.argv[1]\n"
_AFTER = "\nmade = io.BytesIO()\nnumpy.savez(made, **arrays)\nsys.stdout.buffer.write(made.getvalue())\n"


def read_in_child(code: str, path: Path, name: str, kind: str) -> dict[str, Any]:
    """The arrays that ``code`` makes of a file.

    Parameters
    ----------
    code : Python that reads ``path`` and leaves a dictionary ``arrays`` of names and numpy arrays (no objects).
    name, kind : the file and what it should be, in messages.

    Raises
    ------
    UserError : the code failed or crashed.
    """
    command = [sys.executable, "-P", "-W", "ignore", "-c", _BEFORE + code + _AFTER, os.path.realpath(path)]
    try:
        done = subprocess.run(command, capture_output=True, timeout=TIME_LIMIT, check=False)
    except subprocess.TimeoutExpired:
        raise UserError(Problem(f"was not read within {TIME_LIMIT:.0f} s: it is damaged", name)) from None
    if done.returncode:
        messages = done.stderr.decode("utf-8", errors="replace").strip().splitlines()
        why = messages[-1][:200] if done.returncode > 0 and messages else "its reader crashed"
        raise UserError(Problem(f"is damaged or not a {kind} file ({why}); export it again", name))
    with np.load(io.BytesIO(done.stdout), allow_pickle=False) as arrays:
        return dict(arrays)
