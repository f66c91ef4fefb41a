"""``make scale``: time and memory of large projects, each at a quarter, a half and the whole of its size.

Every size is run as a command in a process of its own. What the smallest project takes (start-up, compiled equations)
is taken off, and an exponent is fitted to what is left: 1 is linear growth, 2 is quadratic. Time is that of the
processors, which other work on the machine changes little. Memory is the largest of
any one process; where it does not grow, its exponent says nothing and is left out.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from scale.cases import CASES, ScaleCase

LEAST_SIZE = 2  # of the project whose cost is the fixed one; a recording or a sweep of 2 is none: see ``smallest``
LINEAR = 1.25  # the greatest exponent that passes: what grows as n log n, or as n squared, does not
LEAST_SECONDS, LEAST_BYTES = 0.3, 20e6  # growth below this from a quarter to the whole is scatter and tells no exponent
# Runs a command and tells what it and all that it started used: processor seconds, and the largest resident size.
WATCHED = """
import resource, subprocess, sys
status = subprocess.call(sys.argv[2:], stdout=subprocess.DEVNULL)
used = resource.getrusage(resource.RUSAGE_CHILDREN)
peak = used.ru_maxrss * (1 if sys.platform == "darwin" else 1024)
open(sys.argv[1], "w").write(f"{status} {used.ru_utime + used.ru_stime} {peak}")
"""


@dataclass(frozen=True)
class Measured:
    """One run: its size, seconds on the clock, seconds of all processors, and bytes of the largest process."""

    size: int
    seconds: float
    processor: float
    memory: float


@dataclass(frozen=True)
class Growth:
    """A case's runs, and how they grow; None where there is too little growth to tell."""

    name: str
    fixed: Measured
    runs: tuple[Measured, ...]
    time_exponent: float | None
    memory_exponent: float | None

    @property
    def linear(self) -> bool:
        """Whether neither grows faster than linearly."""
        return all(found is None or found <= LINEAR for found in (self.time_exponent, self.memory_exponent))


def measured(case: ScaleCase, size: int, folder: Path) -> Measured:
    """Write the project of this size and run it once.

    Raises
    ------
    RuntimeError : the command failed.
    """
    place = folder / f"{case.name}-{size}"
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir(parents=True)
    case.write(place, size)
    note = place / "peak.txt"
    command = [sys.executable, "-c", WATCHED, str(note), sys.executable, "-m", "synth", "-q", *case.words]
    begun = time.perf_counter()
    done = subprocess.run(command, cwd=place, stderr=subprocess.PIPE, text=True, check=False)
    seconds = time.perf_counter() - begun
    status, processor, peak = note.read_text().split() if note.exists() else ("-1", "0", "0")
    if status != "0":
        raise RuntimeError(f"{case.name} of size {size}: exit status {status}: {done.stderr[-600:]}")
    shutil.rmtree(place)
    return Measured(size, seconds, float(processor), float(peak))


def exponent(sizes: Sequence[float], values: Sequence[float], fixed: float, least: float) -> float | None:
    """Slope of log(value - fixed) over log(size), least squares; None where the values grow by less than ``least``."""
    if values[-1] - values[0] < least:
        return None
    x = [math.log(size) for size in sizes]
    y = [math.log(max(value - fixed, 1e-3 * least)) for value in values]
    middle = sum(x) / len(x)
    return sum((a - middle) * b for a, b in zip(x, y, strict=True)) / sum((a - middle) ** 2 for a in x)


def smallest(case: ScaleCase) -> int:
    """The size whose cost is the fixed one: a recording must still be one."""
    return {"rows": 400, "designs": 16, "parts": 16}.get(case.name, LEAST_SIZE)


def growth(case: ScaleCase, whole: int, folder: Path) -> Growth:
    """A quarter, a half and the whole of a size, and what the smallest costs."""
    measured(case, smallest(case), folder)  # so that the machine has compiled and read everything once
    fixed = measured(case, smallest(case), folder)
    runs = tuple(measured(case, size, folder) for size in (whole // 4, whole // 2, whole))
    sizes = [float(run.size - fixed.size) for run in runs]
    return Growth(
        case.name,
        fixed,
        runs,
        exponent(sizes, [run.processor for run in runs], fixed.processor, LEAST_SECONDS),
        exponent(sizes, [run.memory for run in runs], fixed.memory, LEAST_BYTES),
    )


def lines_of(case: ScaleCase, found: Growth) -> list[str]:
    """The table's lines of a case."""
    lines = [f"{case.name}: {case.what}; the smallest, {found.fixed.size}: {_cost(found.fixed)}"]
    lines += [f"  {run.size:9,}  {_cost(run)}" for run in found.runs]
    grows = [
        f"{name} grows as n^{value:.2f}" if value is not None else f"{name} hardly grows"
        for name, value in (("time", found.time_exponent), ("memory", found.memory_exponent))
    ]
    return [*lines, f"  {', '.join(grows)}: {'linear or less' if found.linear else 'FASTER THAN LINEAR'}"]


def _cost(run: Measured) -> str:
    return f"{run.seconds:8.1f} s, {run.processor:8.1f} s of the processors, {run.memory / 1e6:6.0f} MB"


def main(given: Sequence[str] | None = None) -> int:
    """Run the cases; 1 where one grows faster than linearly."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--to", type=Path, default=Path("build/scale"))
    parser.add_argument("--cases", default=",".join(case.name for case in CASES), help="names with commas between")
    parser.add_argument("--share", type=float, default=1.0, help="of every size, for a quick look")
    for case in CASES:
        parser.add_argument(f"--{case.name}", type=int, default=case.full, metavar="N", help=f"{case.what}")
    chosen = parser.parse_args(given)
    folder = chosen.to.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    os.environ["PYTHONPATH"] = str(Path(__file__).resolve().parents[2])
    results = []
    for case in CASES:
        if case.name in chosen.cases.split(","):
            whole = max(4 * smallest(case), round(getattr(chosen, case.name) * chosen.share))
            results.append(growth(case, whole, folder))
            sys.stdout.write("\n".join(lines_of(case, results[-1])) + "\n")
            sys.stdout.flush()
    text = json.dumps([asdict(found) for found in results], indent=1)
    (folder / "scale.json").write_text(text + "\n", encoding="utf-8")
    return 0 if all(found.linear for found in results) else 1


if __name__ == "__main__":
    sys.exit(main())
