"""``make fuzz-files``: COUNT seeded cases, on all cores; a table by tag, every failure with its seed, ``fuzz.json``."""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import traceback
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path

from fuzzing.bases import bases
from fuzzing.forked import FAILURES, Case, prepared, run_case


def main() -> int:
    """Run the cases; 1 with any failure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=2000)
    parser.add_argument("--undamaged", action="store_true", help="every project once, as it is")
    parser.add_argument("--quick", action="store_true", help="only check the projects that run for many seconds")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--to", type=Path, default=Path("build/fuzz-files"))
    arguments = parser.parse_args()
    arguments.to = arguments.to.resolve()  # every case runs in a folder of its own
    arguments.to.mkdir(parents=True, exist_ok=True)
    prepared()
    seeds = [arguments.seed * 1_000_000 + k for k in range(arguments.count)]
    how = {"undamaged": arguments.undamaged, "quick": arguments.quick}
    seeds = list(range(len(bases()))) if arguments.undamaged else seeds
    cases = sorted(_all(seeds, arguments.workers, arguments.to, how), key=lambda case: case.seed)
    text = json.dumps([case.as_json() for case in cases], indent=1, default=str)
    (arguments.to / "fuzz.json").write_text(text + "\n", encoding="utf-8")
    tags = Counter(case.tag for case in cases)
    sys.stdout.write("".join(f"{tag:8} {tags[tag]:5}\n" for tag in ("DONE", "REFUSED", *FAILURES)))
    for case in cases:
        if case.tag in FAILURES:
            _say(case)
    slowest = max(cases, key=lambda case: case.seconds)
    sys.stdout.write(f"slowest: {slowest.seconds:.1f} s, seed {slowest.seed} ({slowest.base})\n")
    return 1 if any(tags[tag] for tag in FAILURES) else 0


def _say(case: Case) -> None:
    changes = "; ".join(case.changes)
    sys.stdout.write(
        f"{case.tag} {case.seed} {case.base}: {case.why}\n    {changes}\n    {' '.join(case.command)[:200]}\n"
    )
    sys.stdout.flush()


def _work(listed: Path, seeds: list[int], room: Path, how: Mapping[str, bool]) -> None:
    """One worker's cases, a line each."""
    with listed.open("w", encoding="utf-8") as stream:
        for seed in seeds:
            case = run_case(seed, room, **how)
            stream.write(json.dumps(case.as_json(), default=str) + "\n")
            stream.flush()
            if case.tag in FAILURES:
                _say(case)


def _all(seeds: list[int], workers: int, to: Path, how: Mapping[str, bool]) -> Iterator[Case]:
    """Every case, dealt out to forked workers that write theirs as lines."""
    with tempfile.TemporaryDirectory(prefix="fuzz-", dir=to) as name:
        lists = [Path(name) / f"worker-{k}" for k in range(workers)]
        children = []
        for k, listed in enumerate(lists):
            child = os.fork()
            if child == 0:
                try:
                    _work(listed, seeds[k::workers], to / "cases", how)
                except BaseException:
                    traceback.print_exc()
                finally:
                    os._exit(0)  # whatever happens: what the parent cleans up is not this process's
            children.append(child)
        for child in children:
            os.waitpid(child, 0)
        found = [line for listed in lists for line in listed.read_text(encoding="utf-8").splitlines()]
        if len(found) < len(seeds):
            raise RuntimeError(f"{len(seeds) - len(found)} cases were not run")
        for line in found:
            case = json.loads(line)
            yield Case(**case | {"changes": tuple(case["changes"]), "command": tuple(case["command"])})


if __name__ == "__main__":
    raise SystemExit(main())
