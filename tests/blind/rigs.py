"""Dirty rigs, the causes withheld: ``python -m blind.rigs --seed 4000 --count 60 --to build/blind-rigs``.

Like ``python -m blind``: rigs are made once per seed and count, diagnosed without access to their answers, then scored.
An interrupted run resumes.
"""

from __future__ import annotations

import json
import shutil
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np

from blind import run
from blind.asked import Asked
from blind.rig_cases import LIBRARY, make_rig
from blind.rig_score import main_keys, right, scores
from blind.score import Answer, Score
from blind.views import View, read_views
from blind.writing import folder_name, write_case
from synth.planting.refusals import NotApplicable
from synth.planting.unlisted_effects import UNLISTED_EFFECTS

# Seed, (number, kind, effect) and the folder of cases -> the name of the case that it wrote, and its answer.
One = Callable[[int, tuple[int, str, str], Path], tuple[str, dict[str, Any]]]
MIX = {"none": 0.15, "two": 0.15, "unknown": 0.15}  # the rest has one main cause


def plan(seed: int, count: int) -> list[tuple[int, str, str]]:
    """As ``mixed``, of the library and the outsiders."""
    return mixed(np.random.default_rng([seed, 0xD12]), count, LIBRARY, UNLISTED_EFFECTS)


def mixed(
    rng: np.random.Generator, count: int, library: Iterable[str], outside: Iterable[str]
) -> list[tuple[int, str, str]]:
    """Number, kind and main effect of each rig: kinds in the mix's shares, effects in turn, the order shuffled."""
    kinds = [kind for kind, share in MIX.items() for _ in range(round(share * count))]
    kinds += ["single"] * (count - len(kinds))
    turns: dict[str, list[str]] = {}
    planned = []
    for kind in kinds:
        if not turns.get(kind):
            turns[kind] = rng.permutation(sorted(outside if kind == "unknown" else library)).tolist()
        planned.append((kind, turns[kind].pop()))
    return [(number, *planned[i]) for number, i in enumerate(rng.permutation(count))]


def one(seed: int, task: tuple[int, str, str], out: Path) -> tuple[str, dict[str, Any]]:
    """Make and write one rig; its folder's name and answer."""
    number, kind, effect = task
    for again in range(5):  # an effect that no leg drawn can show is drawn again, in the end another one
        try:
            case = make_rig(seed, number + 100_000 * again, kind, effect if again < 2 else None)
        except NotApplicable as why:
            print(f"{number}: {why}", file=sys.stderr)  # noqa: T201
            continue
        name = folder_name(seed, number)
        write_case(case, out / name, name)
        return name, case.answer
    raise RuntimeError(f"rig {number} ({kind} {effect}) cannot be made")


def make(asked: Asked, tasks: Sequence[tuple[int, str, str]], one: One) -> None:
    """``cases/NAME`` and, apart from them, ``answers/answers.json``; an interrupted attempt leaves nothing."""
    partial = asked.folder / "partial"
    shutil.rmtree(partial, ignore_errors=True)
    (partial / "answers").mkdir(parents=True)
    with ProcessPoolExecutor(asked.workers) as pool:
        waiting = [pool.submit(one, asked.seed, task, partial / "cases") for task in tasks]
        answers = dict(future.result() for future in waiting)
    (partial / "answers" / "answers.json").write_text(json.dumps(dict(sorted(answers.items())), indent=1) + "\n")
    for name in ("cases", "answers"):
        shutil.rmtree(asked.folder / name, ignore_errors=True)
        (partial / name).rename(asked.folder / name)
    partial.rmdir()


def table(lines: Sequence[Score]) -> str:
    """The scores as text, one per line: value, 90 % interval, level and cases."""
    rows = []
    for line in lines:
        if not line.count:
            continue
        scale = 100.0 if line.unit == "%" else 1.0
        low, high = (scale * end for end in line.interval)
        goal = (
            "" if line.level is None else f"{'at most' if line.level.most else 'at least'} {scale * line.level.goal:g}"
        )
        kept = "" if line.level is None else ("kept" if line.reached else "MISSED")
        digits = 0 if line.unit == "%" else 3
        value = f"{scale * line.value:.{digits}f} [{low:.{digits}f}, {high:.{digits}f}]"
        rows.append(f"{line.what:62s} {value:>22s}  {goal:14s} {kept:7s} {line.count:4d} rigs")
    return "\n".join(rows)


def failures(answers: Mapping[str, Answer], views: Mapping[str, View]) -> str:
    """One line per wrongly diagnosed rig: its causes and its diagnosis."""
    rows = []
    for name, answer in answers.items():
        view = views[name]
        if not right(answer, view):
            true = " + ".join(f"{e} ({j})" for e, j in main_keys(answer)) or "nothing"
            said = ", ".join(f"{e} ({j}) {p:.2f}" for (e, j), p in view.ranked[:3])
            rows.append(f"{name} {answer['kind']:8s} {true:50s} {view.verdict:8s} {said}")
    return "\n".join(rows)


def main(words: Sequence[str] | None = None) -> int:
    asked = Asked.of(words, "blind.rigs", __doc__)
    return check(asked, "blind-rigs", plan(asked.seed, asked.count), one)


def check(asked: Asked, name: str, tasks: Sequence[tuple[int, str, str]], one: One) -> int:
    """Make missing rigs, diagnose, score, and write ``NAME.json``."""
    if not asked.answers.exists():
        make(asked, tasks, one)
    program = run.snapshot(asked.folder)
    run.diagnose_all(asked.cases, asked.folder / "diagnosed", asked.answers, asked.workers, program)
    answers = json.loads(asked.answers.read_text())
    views = read_views(asked.folder / "diagnosed", list(answers))
    lines = scores(answers, views)
    document = {
        "format": f"synth/{name}/1",
        "seed": asked.seed,
        "cases": len(answers),
        "program": program.digest,
        "scores": {line.key: line.as_json() for line in lines},
        "list": {
            n: {"kind": a["kind"], "right": right(a, views[n]), "verdict": views[n].verdict} for n, a in answers.items()
        },
    }
    (asked.to / f"{name}.json").write_text(json.dumps(document, indent=1, allow_nan=False) + "\n")
    print(f"{table(lines)}\n\nNot right:\n{failures(answers, views)}\n{asked.to / f'{name}.json'}")  # noqa: T201
    return 0


if __name__ == "__main__":
    sys.exit(main())
