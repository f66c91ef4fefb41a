"""Jumps, the effect withheld: ``python -m blind.jumps --seed 2000 --count 48 --to build/blind-jumps``.

As ``python -m blind`` for swinging legs: cases are made by MuJoCo with other functional forms, diagnosed in processes
that can open neither answers nor generator, then joined with the answers and scored on a page.
"""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from blind import run, score
from blind.asked import Asked
from blind.jump_cases import PLACES, make_case
from blind.page import Method, write_page
from blind.views import read_views

KINDS = ("single", "single", "none", "single", "unknown", "single", "two", "single")  # in turn


def kind_of(number: int) -> tuple[str, str | None]:
    """Kind of case ``number``, and for a single cause its effect: all effects in turn."""
    kind = KINDS[number % len(KINDS)]
    if kind != "single":
        return kind, None
    before = sum(KINDS[k % len(KINDS)] == "single" for k in range(number))
    return kind, sorted(PLACES)[before % len(PLACES)]


def make(seed: int, count: int, folder: Path, workers: int) -> None:
    """``cases/NNN`` and, apart from them, ``answers/answers.json``."""
    partial = folder / "partial"
    shutil.rmtree(partial, ignore_errors=True)
    with ProcessPoolExecutor(workers) as pool:
        waiting = {
            f"{number:03d}": pool.submit(_one, seed, number, partial / "cases" / f"{number:03d}")
            for number in range(count)
        }
        answers = {name: future.result() for name, future in waiting.items()}
    (partial / "answers").mkdir()
    (partial / "answers" / "answers.json").write_text(json.dumps(answers, indent=1) + "\n")
    for name in ("cases", "answers"):
        shutil.rmtree(folder / name, ignore_errors=True)
        (partial / name).rename(folder / name)
    partial.rmdir()


def _one(seed: int, number: int, folder: Path) -> dict[str, object]:
    kind, effect = kind_of(number)
    return make_case(seed, number, kind, folder, effect)


def main(words: Sequence[str] | None = None) -> int:
    asked = Asked.of(words, "blind.jumps", __doc__)
    if not asked.answers.exists():
        make(asked.seed, asked.count, asked.folder, asked.workers)
    program = run.snapshot(asked.folder, apart=())
    run.diagnose_all(asked.cases, asked.folder / "diagnosed", asked.answers, asked.workers, program)
    answers = json.loads(asked.answers.read_text())
    views = read_views(asked.folder / "diagnosed", list(answers))
    made = (
        f"Seed {asked.seed}, {len(answers)} cases of a jumping leg; program {program.digest[:12]} (SHA-256). The "
        "recordings are MuJoCo's with other functional forms than the library's; every leg is off within its "
        "tolerances. The gap is what tolerances leave of the effect, in noise floors of the channel that shows it "
        "best; shrink is held against the noise alone. Each diagnosis ran in a process that could open neither the "
        "answers nor the generator."
    )
    write_page(asked.folder, answers, [Method("synth gap", views, score.scores(answers, views))], made)
    asked.show()
    return 0


if __name__ == "__main__":
    sys.exit(main())
