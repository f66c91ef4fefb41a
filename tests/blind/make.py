"""Write a set of blind cases: ``python -m blind.make --out CASES --answers ANSWERS.json --seed N --count M``.

From the project's root: ``PYTHONPATH=tests .venv/bin/python -m blind.make ...``.
"""

from __future__ import annotations

import argparse
import json
import shutil
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from blind.asked import Asked
from blind.cases import KINDS, make_case
from blind.writing import folder_name, write_case
from synth.planting.effect_makers import EFFECTS
from synth.planting.refusals import NotApplicable
from synth.planting.unlisted_effects import UNLISTED_EFFECTS

MIX = {"single": 0.60, "none": 0.12, "two": 0.10, "unknown": 0.10, "tie": 0.08}


def plan(seed: int, count: int, kind: str, effect: str | None) -> list[tuple[int, str, str | None]]:
    """Number, kind and effect of each case: kinds in the mix's shares, effects in turn, the order shuffled."""
    rng = np.random.default_rng([seed, 0xB11D])
    kinds = [kind] * count
    if kind == "mix":
        kinds = [k for k in ("none", "two", "unknown", "tie") for _ in range(round(MIX[k] * count))]
        kinds += ["single"] * (count - len(kinds))
    turns: dict[str, list[str]] = {}
    cases = []
    for k in kinds:
        chosen = effect
        if effect is None and k in ("single", "unknown", "two"):
            if not turns.get(k):
                turns[k] = rng.permutation(sorted(UNLISTED_EFFECTS if k == "unknown" else EFFECTS)).tolist()
            chosen = turns[k].pop()
        cases.append((k, chosen))
    order = rng.permutation(len(cases))
    return [(number, *cases[i]) for number, i in enumerate(order)]


def one(task: tuple[int, str, str | None], seed: int, out: Path) -> tuple[str, dict[str, Any]]:
    """Make and write one case; its folder's name and answer."""
    number, kind, effect = task
    case = None
    for again in range(5):  # if no leg shows the effect, legs are drawn again, finally with another effect
        try:
            case = make_case(seed, number + 100_000 * again, kind, effect if again < 2 else None)
            break
        except NotApplicable as why:
            print(f"{number}: {why}", file=sys.stderr)  # noqa: T201
    if case is None:
        raise RuntimeError(f"case {number} ({kind} {effect}) cannot be made")
    name = folder_name(seed, number)
    write_case(case, out / name, name)
    return name, case.answer


def once(asked: Asked) -> None:
    """Make the requested cases unless they exist."""
    if not asked.answers.exists():
        shutil.rmtree(asked.folder, ignore_errors=True)
        options = ["--seed", asked.seed, "--count", asked.count, "--workers", asked.workers]
        main([*map(str, options), "--out", str(asked.cases), "--answers", str(asked.answers)])


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="blind.make", description=__doc__)
    parser.add_argument("--out", type=Path, required=True, help="folder for the cases")
    parser.add_argument("--answers", type=Path, required=True, help="file for the answers, outside that folder")
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--count", type=int, required=True)
    parser.add_argument("--kind", choices=[*KINDS, "mix"], default="mix")
    parser.add_argument("--effect", choices=sorted({*EFFECTS, *UNLISTED_EFFECTS}))
    parser.add_argument("--workers", type=int, default=1)
    chosen = parser.parse_args(arguments)
    if chosen.answers.resolve().is_relative_to(chosen.out.resolve()):
        parser.error("the answers must lie outside the cases' folder")
    chosen.out.mkdir(parents=True, exist_ok=True)
    tasks = plan(chosen.seed, chosen.count, chosen.kind, chosen.effect)
    work = partial(one, seed=chosen.seed, out=chosen.out)
    answers: dict[str, Any] = {}
    with ProcessPoolExecutor(chosen.workers) as pool:
        for name, answer in pool.map(work, tasks) if chosen.workers > 1 else map(work, tasks):
            answers[name] = answer
    chosen.answers.parent.mkdir(parents=True, exist_ok=True)
    chosen.answers.write_text(json.dumps(dict(sorted(answers.items())), indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
