"""The whole study: ``python -m robustness --seed 1 --count 500 --to build/robustness``; see ``make robustness``.

Each leg's record is stored at once, so that an interrupted or killed run resumes. Records of another
program are deleted: the hash of its source is stored with them.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import sys
from pathlib import Path

from robustness.page import write_page
from robustness.study import study_case
from synth.batch.local import run_here
from synth.threads import core_count

ROOT = Path(__file__).parents[2]
PARTS = (
    "synth/fit",
    "synth/estimation",
    "synth/swing",
    "synth/compiling",
    "synth/motion",
    "tests/robustness",
)  # of the source that determines a record
APART = ("page.py", "__main__.py", "importers")


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="robustness", description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=500)
    parser.add_argument("--to", type=Path, required=True, help="folder for everything")
    parser.add_argument("--workers", type=int, default=core_count())
    chosen = parser.parse_args(arguments)
    folder = chosen.to / "records"
    digest = _source_hash()
    stamp = folder / "program.txt"
    if not stamp.exists() or stamp.read_text() != digest:
        for old in folder.glob("*.json"):
            old.unlink()
        folder.mkdir(parents=True, exist_ok=True)
        stamp.write_text(digest)
    seeds = [1000 * chosen.seed + number for number in range(chosen.count)]
    missing = [seed for seed in seeds if not (folder / f"{seed}.json").exists()]
    _say(f"{len(seeds)} legs, {len(seeds) - len(missing)} done before")
    failed = 0
    for done, (key, ended) in enumerate(run_here(study_case, ((str(s), s) for s in missing), chosen.workers), start=1):
        if ended.value is None:
            failed += 1
            _say(ended.crash or str(ended.problems[0]))
            continue
        partial = folder / f"{key}.partial"
        partial.write_text(json.dumps(ended.value))
        partial.rename(folder / f"{key}.json")
        if done % 10 == 0 or done == len(missing):
            _say(f"{done}/{len(missing)}")
    records = [json.loads(path.read_text()) for path in (folder / f"{s}.json" for s in seeds) if path.exists()]
    if not records:
        return 1 if failed else 0
    made = f"Seed {chosen.seed}, {len(records)} legs; source {digest[:12]} (SHA-256)."
    print(write_page(chosen.to, records, made))  # noqa: T201
    return 1 if failed else 0


def _source_hash() -> str:
    total = hashlib.sha256()
    for part in PARTS:
        for path in sorted((ROOT / part).rglob("*.py")):
            if path.name not in APART and not set(path.parts) & set(APART):
                total.update(str(path.relative_to(ROOT)).encode() + path.read_bytes())
    return total.hexdigest()


def _say(text: str) -> None:
    print(text, file=sys.stderr, flush=True)  # noqa: T201


if __name__ == "__main__":
    sys.exit(main())
