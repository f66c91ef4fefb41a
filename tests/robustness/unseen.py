"""Legs whose recordings show no hand, as ``synth fit`` treats them: driven ones, and with ``--free`` those without.

``make robustness`` drives a quarter of its legs, and a tenth of those recordings do not show the hand: some 12 legs of
500. Here every leg is driven, and only those whose hand is not seen are fitted. With ``--free`` none is driven, and all
are fitted. Printed are the shares of intervals that hold, and how many legs are cut: of free ones, without need.

``python -m robustness.unseen --seed 950 --count 1200 --to FOLDER`` writes ``legs.jsonl``, a line a leg; stopped, it
goes on where it was.
"""

from __future__ import annotations

import argparse
import json
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from robustness.numbers import QUANTITIES, line
from robustness.random_legs import TOLERANCE_OF_LINKS, Case, random_case, random_leg, random_recorder
from robustness.study import fitted, hand_until
from synth.fit.fit_options import LegFitOptions

DRIVEN = 0.15  # s, as in ``random_recorder``
AS_SYNTH_FIT = LegFitOptions(tolerance=TOLERANCE_OF_LINKS, release="free", laws="auto")


def case_with_hand(seed: int, driven: float) -> Case | None:
    """The case of a seed, driven by a hand for so many s; None for a leg that falls over: it has no rest pose."""
    generator = np.random.default_rng([seed, 500])
    random_leg(generator)
    try:
        return random_case(seed, replace(random_recorder(generator), driven=driven))
    except ArithmeticError:
        return None


def unseen_hand(seed: int) -> dict[str, Any]:
    """The fit of a seed's driven leg as ``synth fit`` does it; without ``fit`` if a recording shows the hand."""
    case = case_with_hand(seed, DRIVEN)
    if case is None or any(hand_until(case, trial) is not None for trial in case.trials):
        return {"seed": seed}
    return {"seed": seed, "fit": fitted(case, case.off, case.trials, AS_SYNTH_FIT)}


def no_hand(seed: int) -> dict[str, Any]:
    """The fit of a seed's leg that no hand drives, as ``synth fit`` does it."""
    case = case_with_hand(seed, 0.0)
    return {"seed": seed} | ({"fit": fitted(case, case.off, case.trials, AS_SYNTH_FIT)} if case is not None else {})


def main(arguments: list[str] | None = None) -> None:
    """Fit the missing legs, and print the shares of intervals that hold."""
    parser = argparse.ArgumentParser(description="intervals of legs whose recordings show no hand")
    parser.add_argument("--free", action="store_true", help="legs that no hand drives")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=1200, help="legs (1200); a tenth of driven ones show no hand")
    parser.add_argument("--to", type=Path, default=Path("build/unseen"), help="folder to write")
    parser.add_argument("--workers", type=int, default=1, help="processes")
    chosen = parser.parse_args(arguments)
    chosen.to.mkdir(parents=True, exist_ok=True)
    log = chosen.to / "legs.jsonl"
    done = [json.loads(text) for text in log.read_text().splitlines()] if log.exists() else []
    known = {record["seed"] for record in done}
    missing = [s for s in range(1000 * chosen.seed, 1000 * chosen.seed + chosen.count) if s not in known]
    with log.open("a") as stream, ProcessPoolExecutor(max_workers=chosen.workers) as pool:
        for record in pool.map(no_hand if chosen.free else unseen_hand, missing):
            stream.write(json.dumps(record) + "\n")
            stream.flush()
            done.append(record)
    fits = [record["fit"] for record in done if "fit" in record]
    for name, quantities in {"all": tuple(QUANTITIES), **{words: (key,) for key, words in QUANTITIES.items()}}.items():
        found = line(name, fits, quantities)
        print(  # noqa: T201
            f"{name}: {100 * found.held:.1f} +- {100 * found.error:.1f} % of {found.intervals} intervals, "
            f"{found.legs} legs of {len(done)}"
        )
    print(f"cut: {sum(fit.get('cut', 0.0) > 0.0 for fit in fits)} of {len(fits)} legs")  # noqa: T201


if __name__ == "__main__":
    main()
