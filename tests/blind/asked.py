"""Options of a complete check, and the paths of its parts."""

from __future__ import annotations

import argparse
import os
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Asked:
    """``count`` cases of a ``seed`` on ``workers`` processes; all output is below ``to``."""

    seed: int
    count: int
    to: Path
    workers: int

    @classmethod
    def of(cls, words: Sequence[str] | None, program: str, text: str | None) -> Asked:
        """From the command line, or these ``words`` of it; ``text`` describes the ``program``."""
        parser = argparse.ArgumentParser(prog=program, description=text)
        parser.add_argument("--seed", type=int, required=True)
        parser.add_argument("--count", type=int, required=True)
        parser.add_argument("--to", type=Path, required=True, help="folder for everything")
        parser.add_argument("--workers", type=int, default=_core_count())
        return cls(**vars(parser.parse_args(words)))

    @property
    def folder(self) -> Path:
        """The folder of these cases and their results."""
        return self.to / f"seed-{self.seed}-{self.count}"

    @property
    def cases(self) -> Path:
        """One folder per case."""
        return self.folder / "cases"

    @property
    def answers(self) -> Path:
        """The file of the answers, in a folder that no diagnosis may open."""
        return self.folder / "answers" / "answers.json"

    def show(self) -> None:
        """Copy the page and its figures to ``to``, and print the path."""
        for name in ("blind.html", "blind.json"):
            shutil.copy(self.folder / name, self.to / name)
        print(f"{self.to / 'blind.html'}")  # noqa: T201


def _core_count() -> int:
    """Cores that this process may use; not the program's own count, of which a generator imports nothing."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
