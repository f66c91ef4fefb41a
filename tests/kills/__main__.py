"""``make kill``: COUNT kills at random moments over gap, leg, folder, sweep and cluster."""

from __future__ import annotations

import argparse
import json
import random
import shutil
import sys
from dataclasses import asdict
from pathlib import Path

from kills.rounds import CASES, killed, prepared


def main() -> int:
    """Run the rounds, print each, and write them to ``rounds.json``; 1 where any has a fault."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cases", nargs="+", choices=CASES, default=list(CASES))
    parser.add_argument("--to", type=Path, default=Path("build/kill"))
    arguments = parser.parse_args()
    shutil.rmtree(arguments.to, ignore_errors=True)
    draw = random.Random(arguments.seed)
    rounds = []
    with prepared(arguments.cases, arguments.to.resolve() / "work") as cases:
        for case in cases:
            sys.stdout.write(f"{case.name}: {len(case.whole)} files in {case.seconds:.1f} s undisturbed\n")
        for index in range(arguments.count):
            rounds.append(killed(cases[index % len(cases)], draw))
            last = rounds[-1]
            place = "over an earlier result" if last.over else "into a new folder"
            when = f"{last.signal} at {last.moment:5.1f} s {place}"
            when += ", after the end" if last.ended else ""
            sys.stdout.write(f"{index + 1:3} {last.case:8} {when}: {'; '.join(last.faults) or 'holds'}\n")
            sys.stdout.flush()
            (arguments.to / "rounds.json").write_text(json.dumps([asdict(item) for item in rounds], indent=1) + "\n")
    wrong = sum(bool(item.faults) for item in rounds)
    late = sum(item.ended for item in rounds)
    sys.stdout.write(f"{len(rounds)} kills, {late} of them after the end, {wrong} with faults\n")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
