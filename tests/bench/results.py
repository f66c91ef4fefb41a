"""Results of a benchmark as data: tables, curves and texts that ``report`` draws and ``bench.json`` stores."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

Cell = str | float | None
GOALS: dict[str, Callable[[float, float], bool]] = {
    "at least": lambda value, bound: value >= bound,
    "at most": lambda value, bound: value <= bound,
}


@dataclass(frozen=True)
class Goal:
    """A number to reach: ``value`` and ``bound`` in ``unit``."""

    what: str
    value: float
    sense: Literal["at least", "at most"]
    bound: float
    unit: str

    @property
    def reached(self) -> bool:
        """Whether it is."""
        return GOALS[self.sense](self.value, self.bound)


@dataclass(frozen=True)
class Table:
    """Rows under a head; the first column is words."""

    title: str
    head: Sequence[str]
    rows: Sequence[Sequence[Cell]]
    note: str = ""


@dataclass(frozen=True)
class Curve:
    """Points (x, y) under a name."""

    name: str
    points: Sequence[tuple[float, float]]


@dataclass(frozen=True)
class Figure:
    """Curves on common axes."""

    title: str
    x: str
    y: str
    curves: Sequence[Curve]
    logarithmic: bool = False
    note: str = ""


@dataclass(frozen=True)
class Section:
    """One benchmark's part of the page."""

    title: str
    words: Sequence[str] = ()
    goals: Sequence[Goal] = ()
    tables: Sequence[Table] = ()
    figures: Sequence[Figure] = ()
    text: str = ""  # as a program printed it

    def as_json(self) -> dict[str, Any]:
        """Plain types; a goal says whether it is reached."""
        document = asdict(self)
        document["goals"] = [{**asdict(goal), "reached": goal.reached} for goal in self.goals]
        return document

    @classmethod
    def from_json(cls, document: Mapping[str, Any]) -> Section:
        """The inverse of ``as_json``."""
        goals = [Goal(**{k: v for k, v in goal.items() if k != "reached"}) for goal in document["goals"]]
        figures = [Figure(**{**f, "curves": [Curve(**c) for c in f["curves"]]}) for f in document["figures"]]
        tables = [Table(**table) for table in document["tables"]]
        return cls(**{**document, "goals": goals, "tables": tables, "figures": figures})


def seconds(function: Callable[[], object], repeats: int) -> float:
    """Median processor seconds of a call, all its threads together, after one that does not count.

    That is what a call costs on a core of its own, however much else the machine does; caches and the other half of a
    core are still shared.
    """
    clock = time.process_time
    function()
    spent = []
    for _ in range(repeats):
        start = clock()
        function()
        spent.append(clock() - start)
    return sorted(spent)[len(spent) // 2]


def say(text: str) -> None:
    """A line on the screen, at once."""
    sys.stderr.write(text + "\n")
    sys.stderr.flush()


def load() -> float:
    """Load average of the last minute."""
    return os.getloadavg()[0]


def run_alone(section: Callable[[], Section]) -> None:
    """What a benchmark does as a program: measure, and write its section as JSON to the file named, or show it."""
    found = section().as_json()
    text = json.dumps(found, indent=1, allow_nan=False) + "\n"
    if len(sys.argv) > 1:
        Path(sys.argv[1]).write_text(text, encoding="utf-8")
    else:
        sys.stdout.write(text)
