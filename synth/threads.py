"""How many threads one process uses: all cores, or ``SYNTH_THREADS``; one in each of many processes at once."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager

VARIABLE = "SYNTH_THREADS"
# What numpy's linear algebra looks at when it is loaded; Dask gives its workers the same.
LIBRARIES = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


def thread_count() -> int:
    """Threads for compiled code that runs without the interpreter's lock."""
    text = os.environ.get(VARIABLE, "")
    return int(text) if text.isdigit() and int(text) > 0 else os.cpu_count() or 1


@contextmanager
def children_of_one_thread() -> Iterator[None]:
    """Processes that are started in this block have one thread each; variables that the user has set stay."""
    added = [name for name in (VARIABLE, *LIBRARIES) if name not in os.environ]
    os.environ.update(dict.fromkeys(added, "1"))
    try:
        yield
    finally:
        for name in added:
            os.environ.pop(name, None)
