"""The whole check: ``python -m blind --seed 2000 --count 200 --to build/blind``; see ``make blind``.

Cases are made once per seed and count, diagnosed without access to their answers, then joined with these and scored
beside three baselines. An interrupted run resumes.
"""

from __future__ import annotations

import json
import sys

from blind import baselines, make, next_trial, run, score
from blind.asked import Asked
from blind.page import Method, write_page
from blind.views import read_views


def main(words: list[str] | None = None) -> int:
    asked = Asked.of(words, "blind", __doc__)
    make.once(asked)
    program = run.snapshot(asked.folder)
    run.diagnose_all(asked.cases, asked.folder / "diagnosed", asked.answers, asked.workers, program)
    baselines.run_all(asked.cases, asked.folder / "baselines", asked.workers)
    join(asked, program)
    asked.show()
    return 0


def join(asked: Asked, program: run.Program) -> None:
    """Read the answers, make and diagnose the trials suggested for ties, score, and write the page."""
    folder = asked.folder
    answers = json.loads(asked.answers.read_text())
    views = read_views(folder / "diagnosed", list(answers))
    stamp = folder / "next-cases.txt"
    if not stamp.exists() or stamp.read_text() != program.digest:
        next_trial.make_all(asked.cases, folder / "next-cases", answers, views)
        stamp.write_text(program.digest)
    run.diagnose_all(folder / "next-cases", folder / "next-diagnosed", asked.answers, asked.workers, program)
    suggested = [path.name for path in (folder / "next-cases").iterdir()]
    with_next = read_views(folder / "next-diagnosed", suggested)
    lines = [*score.scores(answers, views), *score.gain(*next_trial.first_right(answers, views, with_next))]
    methods = [Method("synth gap", views, lines), *baselines.methods(folder / "baselines", answers)]
    seeds = sorted({answer["seed"][0] for answer in answers.values()})
    made = (
        f"Seed {', '.join(map(str, seeds))}, {len(answers)} cases; program {program.digest[:12]} (SHA-256). "
        "The generator is an engine of its own with other functional forms than the library's; every design is off "
        "within its tolerances. Each diagnosis ran in a process that could open neither the answers nor the generator."
    )
    write_page(folder, answers, methods, made)


if __name__ == "__main__":
    sys.exit(main())
