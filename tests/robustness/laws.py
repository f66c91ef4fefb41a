"""Legs with another law than springs and linear dampers: ``python -m robustness.laws --seed 980000 --count 22``.

Each leg is recorded with dry friction at its joints, with quadratic damping, with hardening springs, driven by a hand
for 0.15 s, and free. It is fitted as ``synth fit`` does and with ``laws: linear``, from links that are off by their
tolerances.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from robustness.random_legs import TOLERANCE_OF_LINKS, Case, random_case, with_law
from synth.errors import UserError
from synth.fit.estimate import fit_leg
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_result import FitResult
from synth.fit.recordings import recordings

MOST_TRIALS = 4  # so that a leg takes seconds
AUTO = LegFitOptions(release="free", laws="auto", tolerance=TOLERANCE_OF_LINKS)


def free(case: Case, driven: float = 0.0) -> Case:
    """The same leg let go freely, or driven for so many s at first."""
    return random_case(case.seed, replace(case.recorder, driven=driven))


KINDS: dict[str, Callable[[Case], Case]] = {
    "dry friction": lambda case: with_law(case, "coulomb_friction"),
    "quadratic damping": lambda case: with_law(case, "quadratic_damping"),
    "hardening spring": lambda case: with_law(case, "hardening_spring"),
    "hand for 0.15 s": lambda case: free(case, 0.15),
    "free": free,
}


@dataclass(frozen=True)
class Fitted:
    """One fit: intervals that hold, the largest error of a spring's logarithm, the law named, and the cut, s."""

    held: int
    intervals: int
    off: float
    law: str
    cut: float


def cases(seed: int, count: int) -> Iterator[Case]:
    """``count`` legs with few trials, from this seed on."""
    while count:
        case = random_case(seed)
        if case.recorder.trials <= MOST_TRIALS:
            count -= 1
            yield case
        seed += 1


def fitted(case: Case, laws: str) -> Fitted | None:
    """As ``synth fit`` does; None if it says that it cannot."""
    try:
        result = fit_leg(case.off, recordings(case.off, case.trials), replace(AUTO, laws=laws))
    except UserError:
        return None
    rates = np.array([joint.spring_rate.value for joint in result.joints.values()])
    off = float(np.abs(np.log(rates / case.leg.spring_rate)).max())
    return Fitted(*held(result, case), off, str(result.law.get("effect", "")), result.cut)


def held(result: FitResult, case: Case) -> tuple[int, int]:
    """How many 90 % intervals hold the truth, and how many there are."""
    inside = []
    for joint in case.leg.joints:
        found = result.joints[joint.name]
        assert joint.spring is not None
        assert joint.damper is not None
        truth = joint.spring.rate, joint.damper.rate, joint.spring.free_angle
        for item, value in zip((found.spring_rate, found.damper_rate, found.free_angle), truth, strict=True):
            assert item is not None
            assert item.low is not None
            assert item.high is not None
            assert value is not None
            inside.append(item.low <= value <= item.high)
    return sum(inside), len(inside)


def line(kind: str, laws: str, fits: list[Fitted]) -> dict[str, object]:
    """The numbers of one row."""
    return {
        "leg": kind,
        "laws": laws,
        "fits": len(fits),
        "held": round(sum(each.held for each in fits) / sum(each.intervals for each in fits), 3),
        "spring off by more than a half": int(sum(each.off > np.log(1.5) for each in fits)),
        "law named": sum(bool(each.law) for each in fits),
        "cut": sum(each.cut > 0.0 for each in fits),
    }


def main() -> int:
    """Print the table and write it."""
    parser = argparse.ArgumentParser(prog="robustness.laws", description=__doc__)
    parser.add_argument("--seed", type=int, default=980000)
    parser.add_argument("--count", type=int, default=22)
    parser.add_argument("--to", type=Path, required=True, help="folder for laws.json")
    asked = parser.parse_args()
    rows = []
    for kind, made in KINDS.items():
        legs = [made(case) for case in cases(asked.seed, asked.count)]
        for laws in ("auto", "linear"):
            rows.append(line(kind, laws, [each for each in (fitted(leg, laws) for leg in legs) if each is not None]))
            print(rows[-1], flush=True)  # noqa: T201
    asked.to.mkdir(parents=True, exist_ok=True)
    (asked.to / "laws.json").write_text(json.dumps({"seed": asked.seed, "rows": rows}, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
