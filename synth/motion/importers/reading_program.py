"""What the process of ``child`` runs: code that reads a file, its arrays sent to standard output.

It is run by its path and imports nothing of synth, which would take longer than most files.
"""

import os
import sys
from contextlib import suppress
from math import prod
from typing import Any

import numpy

TOO_LARGE = 3  # exit status, none that Python has; the last line of standard error says what is
NUMBER_LIMIT = 100_000_000  # of all arrays together, a choice: 0.8 GB, fifty columns of the most rows of a table
NUMBER_BYTES = 8  # of a double


class TooLargeToRead(Exception):
    """A file holds more than is read."""


class ReadingLimits:
    """Refuses what a file declares to hold before it is read: some bytes of HDF5 may declare any size."""

    def __init__(self, rows: int) -> None:
        self._rows, self._declared = rows, 0

    def held(self, item: Any) -> Any:
        """A dataset of HDF5, all of which is about to be read.

        Raises
        ------
        TooLargeToRead
        """
        shape = tuple(item.shape)
        if max(shape, default=0) > self._rows:
            size = " x ".join(map(str, shape))
            raise TooLargeToRead(f'"{item.name}" is {size}, and at most {self._rows} rows are read')
        self._declared += prod(shape) * max(item.dtype.itemsize, NUMBER_BYTES)  # numbers are read as doubles
        _refuse_bytes(self._declared)
        return item


def _refuse_bytes(count: int) -> None:
    if count > NUMBER_LIMIT * NUMBER_BYTES:
        raise TooLargeToRead(f"it holds more than {NUMBER_LIMIT} numbers")


def limit_memory(most: int) -> None:
    """Limit this process to ``most`` bytes of memory and to what the machine has, where the system can (Linux)."""
    try:
        import resource
    except ImportError:  # Windows
        return
    most = min(most, os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    with suppress(ValueError, OSError):  # refused by macOS
        resource.setrlimit(resource.RLIMIT_AS, (most, most))


def main(path: str, rows: int, memory: int) -> int:
    """Run the code that stands in standard input; it leaves the dictionary ``arrays``."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # C libraries print there
    limit_memory(memory)
    names: dict[str, Any] = {"path": path, "numpy": numpy, "held": ReadingLimits(rows).held}
    try:
        exec(sys.stdin.read(), names)
        arrays: dict[str, Any] = {name: numpy.asarray(value) for name, value in names["arrays"].items()}
        _refuse_bytes(sum(value.nbytes for value in arrays.values()))
        numpy.savez(answers, **arrays)
        answers.close()
    except TooLargeToRead as large:
        sys.stderr.write(f"\n{large}\n")
        return TOO_LARGE
    except MemoryError:
        sys.stderr.write(f"\nto read it takes more than {memory / 1e9:.0f} GB, or than this machine has\n")
        return TOO_LARGE
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], int(sys.argv[2]), int(sys.argv[3])))
