"""The whole check: ``python -m blind --seed 2000 --count 200 --to build/blind``; see ``make blind``.

Cases are made once a seed and count, diagnosed where their answers cannot be read, then joined with these and scored
beside three baselines. Stopped, it goes on from where it was.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import sys
from pathlib import Path

from blind import baselines, make, next_trial, run, score
from blind.page import Method, write_page
from blind.views import read_views


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="blind", description=__doc__)
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--count", type=int, required=True)
    parser.add_argument("--to", type=Path, required=True, help="folder for everything")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    chosen = parser.parse_args(arguments)
    folder = chosen.to / f"seed-{chosen.seed}-{chosen.count}"
    cases, file = folder / "cases", folder / "answers" / "answers.json"
    if not file.exists():
        shutil.rmtree(folder, ignore_errors=True)
        options = ["--seed", chosen.seed, "--count", chosen.count, "--workers", chosen.workers]
        make.main([*map(str, options), "--out", str(cases), "--answers", str(file)])
    program = run.snapshot(folder)
    run.diagnose_all(cases, folder / "diagnosed", file, chosen.workers, program)
    baselines.run_all(cases, folder / "baselines", chosen.workers)
    page = join(folder, program, chosen.workers)
    for name in ("blind.html", "blind.json"):
        shutil.copy(folder / name, chosen.to / name)
    print(f"{chosen.to / page.name}")  # noqa: T201
    return 0


def join(folder: Path, program: run.Program, workers: int) -> Path:
    """Read the answers, make and diagnose the trials suggested for ties, score, and write the page."""
    cases, file = folder / "cases", folder / "answers" / "answers.json"
    answers = json.loads(file.read_text())
    views = read_views(folder / "diagnosed", list(answers))
    stamp = folder / "next-cases.txt"
    if not stamp.exists() or stamp.read_text() != program.digest:
        next_trial.make_all(cases, folder / "next-cases", answers, views)
        stamp.write_text(program.digest)
    run.diagnose_all(folder / "next-cases", folder / "next-diagnosed", file, workers, program)
    asked = [path.name for path in (folder / "next-cases").iterdir()]
    with_next = read_views(folder / "next-diagnosed", asked)
    lines = [*score.scores(answers, views), *score.gain(*next_trial.first_right(answers, views, with_next))]
    methods = [Method("synth gap", views, lines), *baselines.methods(folder / "baselines", answers)]
    seeds = sorted({answer["seed"][0] for answer in answers.values()})
    made = (
        f"Seed {', '.join(map(str, seeds))}, {len(answers)} cases; program {program.digest[:12]} (SHA-256). "
        "The generator is an engine of its own with other functional forms than the library's; every design is off "
        "within its tolerances. Each diagnosis ran in a process that could open neither the answers nor the generator."
    )
    return write_page(folder, answers, methods, made)


if __name__ == "__main__":
    sys.exit(main())
