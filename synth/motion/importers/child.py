"""Reads a binary file in a separate process: a C library may crash on a damaged one, a small one fill the memory."""

from __future__ import annotations

import io
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np

from synth.errors import Problem, UserError
from synth.files.csv_table import ROW_LIMIT
from synth.motion.importers import reading_program

TIME_LIMIT = 600.0  # s, a choice: far above the time for the largest permitted files
# Memory of the process. ezc3d takes 19 bytes for each of a file of points (measured: 19 MB, 40 points, 30 000 frames).
# Compressed files grow without relation to their size: three times the most numbers and the libraries.
MEMORY_PER_BYTE, LEAST_MEMORY = 25, 4_000_000_000  # bytes


def read_in_child(code: str, path: Path, name: str, kind: str) -> dict[str, Any]:
    """The arrays that ``code`` makes of a file.

    Parameters
    ----------
    code : Python that reads ``path`` and leaves a dictionary ``arrays`` of names and numpy arrays (no objects). It has
        ``numpy``, and ``held(dataset)``, which refuses a dataset of HDF5 that is too large.
    name, kind : the file and what it should be, in messages.

    Raises
    ------
    UserError : the code failed or crashed, or the file holds more than is read.
    """
    memory = LEAST_MEMORY + MEMORY_PER_BYTE * path.stat().st_size
    words = [os.path.realpath(path), str(ROW_LIMIT), str(memory)]
    command = [sys.executable, "-P", "-W", "ignore", reading_program.__file__, *words]
    try:
        done = subprocess.run(command, input=code.encode(), capture_output=True, timeout=TIME_LIMIT, check=False)
    except subprocess.TimeoutExpired:
        raise UserError(Problem(f"was not read within {TIME_LIMIT:.0f} s: it is damaged", name)) from None
    if done.returncode:
        messages = done.stderr.decode("utf-8", errors="replace").strip().splitlines()
        if done.returncode == reading_program.TOO_LARGE and messages:
            text = f"is too large: {messages[-1][:200]}; export the recording alone, or a part of it"
            raise UserError(Problem(text, name))
        why = messages[-1][:200] if done.returncode > 0 and messages else "its reader crashed"
        raise UserError(Problem(f"is damaged or not a {kind} file ({why}); export it again", name))
    with np.load(io.BytesIO(done.stdout), allow_pickle=False) as arrays:
        return dict(arrays)
