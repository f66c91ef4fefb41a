"""What the tests of side processes call there: a module that another process can import."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Any

from synth.cad import DimensionError, DimensionProblem


def nothing() -> None:
    """To prepare."""


def square(value: int) -> tuple[int, int]:
    os.write(1, b"kernels print to standard output")
    return value * value, os.getpid()


def first_of(values: tuple[Any, ...], number: int) -> tuple[Any, int]:
    return values[0], number


def wait_for(path: str) -> tuple[str, bool]:
    """Until a file is there, 5 s at most; whether it is."""
    end = time.monotonic() + 5.0
    while time.monotonic() < end and not Path(path).exists():
        time.sleep(0.01)
    return path, Path(path).exists()


def leave(path: str, *_: Any) -> str:
    """Make a file."""
    Path(path).touch()
    return path


def refuse(value: int) -> None:
    raise DimensionError(DimensionProblem("knee.wall", value, "2 to 12 mm", "too thin"))


def fail_to_read() -> None:
    raise FileNotFoundError(2, "none", "missing")


class OddError(Exception):
    """Takes two arguments and keeps one, so that pickle cannot make it again."""

    def __init__(self, joint: str, number: int) -> None:
        super().__init__(f"{number} of {joint}")


def fail_oddly(joint: str, number: int) -> None:
    raise OddError(joint, number)
