"""Diagnose a set of blind cases: ``python -m blind.run --cases CASES --out OUT --answers ANSWERS.json``.

Each case in a process of its own (``synth gap``) that can open neither the answers nor the generator (``watched``).
Finished cases are reused, so that an interrupted run resumes. The program is copied first, so that it may
be changed meanwhile; a run that resumes after a change starts again.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path

from synth.threads import core_count

ROOT = Path(__file__).parents[2]
LONGEST = 600.0  # s, a case; longer is a failure
PROGRAM = "program.txt"  # in the outputs' folder: the program that made them
# No part of a diagnosis of swings.
APART = ("hopper", "jump", "design", "spring", "parts", "examples", "commands", "planting", "rehearsal")


@dataclass(frozen=True)
class Run:
    """The outcome of one case's diagnosis: ``seconds``, exit status, and the end of its messages if it failed."""

    seconds: float
    status: int
    said: str = ""


@dataclass(frozen=True)
class Program:
    """A copy of the packages in ``folder``, and the hash of the source that determines a diagnosis."""

    folder: Path
    digest: str


def snapshot(to: Path, apart: Sequence[str] = APART) -> Program:
    """A copy of the current program in a separate folder below ``to``; ``apart`` as for ``source_hash``."""
    digest = source_hash(apart)
    folder = to / f"program-{digest[:12]}"
    if not folder.exists():
        for old in to.glob("program-*"):
            shutil.rmtree(old)
        partial = to / "partial-program"
        shutil.rmtree(partial, ignore_errors=True)
        shutil.copytree(ROOT / "synth", partial / "synth", ignore=shutil.ignore_patterns("__pycache__"))
        partial.rename(folder)
    return Program(folder.resolve(), digest)


def source_hash(apart: Sequence[str] = APART) -> str:
    """Hash of the source: outputs of another program are not to be mixed in.

    ``apart`` : rooms and files of ``synth`` that these outputs do not rest on.
    """
    total = hashlib.sha256()
    for path in sorted((ROOT / "synth").rglob("*.py")):
        place = path.relative_to(ROOT / "synth")
        if not {place.parts[0], str(place)} & {*apart}:
            total.update(str(place).encode() + path.read_bytes())
    return total.hexdigest()


def diagnose(case: Path, out: Path, hidden: Sequence[Path], program: Program) -> Run:
    """``synth gap`` on one case's folder; its files in ``out``, its outcome in ``out`` + .run.json."""
    generator = [Path(__file__).parent, *(root / "synth" / "planting" for root in (ROOT, program.folder))]
    closed = os.pathsep.join(str(folder.resolve()) for folder in [*hidden, *generator])
    command = [sys.executable, str(ROOT / "synth" / "commands" / "watched.py"), closed, "--", "gap"]
    command += [str((case / "gap.yaml").resolve()), "--out", str(out.resolve())]
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    environment["PYTHONPATH"] = str(program.folder)
    start = time.perf_counter()
    with tempfile.TemporaryDirectory() as elsewhere:
        try:
            ended = subprocess.run(
                command, cwd=elsewhere, env=environment, capture_output=True, text=True, timeout=LONGEST, check=False
            )
            run = Run(0.0, ended.returncode, ended.stderr[-3000:] if ended.returncode else "")
        except subprocess.TimeoutExpired:
            run = Run(0.0, -1, f"longer than {LONGEST:g} s")
    run = Run(round(time.perf_counter() - start, 2), run.status, run.said)
    noted(out).write_text(json.dumps(asdict(run)) + "\n")
    return run


def noted(out: Path) -> Path:
    """The file of a diagnosis's outcome."""
    return out.parent / f"{out.name}.run.json"


@contextmanager
def sealed(file: Path) -> Iterator[None]:
    """Nobody may read the file while the block runs."""
    file.chmod(0o000)
    try:
        yield
    finally:
        file.chmod(0o600)


def diagnose_all(cases: Path, out: Path, answers: Path, workers: int, program: Program) -> int:
    """Diagnose every case without an output of this program; return the number of failures."""
    names = sorted(folder.name for folder in cases.iterdir() if (folder / "gap.yaml").is_file())
    note = out / PROGRAM
    if out.exists() and (not note.exists() or note.read_text() != program.digest):
        shutil.rmtree(out)
    out.mkdir(parents=True, exist_ok=True)
    note.write_text(program.digest)
    waiting = [name for name in names if not (out / name / "gap.json").is_file()]
    _say(f"{len(names)} cases, {len(names) - len(waiting)} diagnosed before")
    failed = 0
    with sealed(answers), ThreadPoolExecutor(workers) as pool:
        runs = pool.map(lambda name: diagnose(cases / name, out / name, [answers.parent], program), waiting)
        for number, (name, run) in enumerate(zip(waiting, runs, strict=True), start=1):
            failed += run.status != 0
            _say(f"{number}/{len(waiting)} {name} {run.seconds:.1f} s{' FAILED' if run.status else ''}")
    return failed


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)  # noqa: T201


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="blind.run", description=__doc__)
    parser.add_argument("--cases", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--answers", type=Path, required=True, help="read by nobody here; its folder is closed")
    parser.add_argument("--workers", type=int, default=core_count())
    chosen = parser.parse_args(arguments)
    closed = chosen.answers.resolve().parent
    if any(folder.resolve().is_relative_to(closed) for folder in (chosen.cases, chosen.out)):
        parser.error("the answers need a folder of their own, apart from cases and outputs")
    chosen.out.parent.mkdir(parents=True, exist_ok=True)
    program = snapshot(chosen.out.parent)
    diagnose_all(chosen.cases, chosen.out, chosen.answers, chosen.workers, program)
    return 0


if __name__ == "__main__":
    sys.exit(main())
