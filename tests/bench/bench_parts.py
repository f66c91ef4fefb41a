"""Time of choosing parts: a million sets of springs and dampers for a three-link leg, and whether the best are found.

``PYTHONPATH=tests python -m bench.bench_parts [SECTION.json]``. Dampers are concave, springs and dampers spread to 2.5
times under and over what is wanted, as catalogues spread them.
"""

from __future__ import annotations

import time

import numpy as np

from bench import thesis_leg as thesis
from bench.results import Goal, Section, Table, load, run_alone, say
from synth.design.part_lanes import ActingElements, PartLanes
from synth.design.part_search import FoundSets, best_sets
from synth.design.response import WantedRelease, WantedResponse
from synth.parts.damper_law import power_law_curve
from synth.swing.chain import Conditions
from synth.swing.leg_model import Damper

TARGET = 60.0  # s on two cores, for a million sets
BEST = 12
SPREAD = 2.5


def lanes(n_damper: int, n_spring: int) -> PartLanes:
    """``n_damper`` times ``n_spring`` pairs a joint, in an order of their own."""
    leg, generator = thesis.leg(), np.random.default_rng(1)
    times = thesis.TIMES[::5]
    releases = [WantedRelease(f"{k}", times, q, np.zeros(3), Conditions()) for k, q in enumerate(thesis.RELEASES)]
    acting = []
    for joint in leg.joints:
        assert joint.spring is not None
        assert joint.damper is not None
        rate = joint.damper.rate or 0.0
        found = []
        for factor in np.geomspace(1 / SPREAD, SPREAD, n_damper) * generator.uniform(0.93, 1.07, n_damper):
            damper = Damper(curve=power_law_curve(2.0 * rate * float(factor), 5.0, 0.7))
            for part in np.geomspace(1 / SPREAD, SPREAD, n_spring) * generator.uniform(0.95, 1.05, n_spring):
                found.append(ActingElements(joint.spring.rate * float(part), damper))
        acting.append([found[k] for k in generator.permutation(len(found))])
    return PartLanes(WantedResponse.of(leg, releases), leg, acting)


def timed(sets: PartLanes, exhaustive: int) -> tuple[FoundSets, float, float]:
    """What was found, processor seconds of all threads, and seconds on the wall."""
    processor, wall = time.process_time(), time.perf_counter()
    found = best_sets(sets, [0, 0, 0], BEST, exhaustive=exhaustive)
    return found, time.process_time() - processor, time.perf_counter() - wall


def section() -> Section:
    """A million sets screened, and four thousand both ways."""
    before = load()
    few, many = lanes(4, 4), lanes(10, 10)
    timed(few, 0)
    whole, whole_processor, whole_wall = timed(few, 10**9)
    screened, some_processor, some_wall = timed(few, 0)
    same = screened.index.tolist() == whole.index.tolist()
    million, processor, wall = timed(many, 0)
    say(f"{million.n_set} sets: {processor:.1f} s of a processor, {wall:.1f} s on the wall, load {load():.1f}")

    def row(words: str, found: FoundSets, processor: float, wall: float) -> tuple[str | float | None, ...]:
        error = float(np.degrees(found.error[0]))
        return words, found.n_set, found.n_simulated, round(processor, 2), round(wall, 2), round(error, 3)

    return Section(
        "Choosing: springs and dampers of three joints together",
        words=(
            f"Seven releases of the three-link leg of the thesis, 1 s; the best {BEST} sets by the whole leg's "
            "response. Screened: motions of single changes summed, then simulated in the screen's order until none "
            f"that follows can be better by the screen's measured mistakes (so for the million: {million.complete}).",
            f"Of {whole.n_set} sets the best {BEST} by screening are those of simulating all: {same}.",
            f"Load (1 min) before {before:.1f}, after {load():.1f}.",
        ),
        goals=(
            Goal("a million sets, processor seconds of both cores over two", processor / 2.0, "at most", TARGET, "s"),
            Goal("a million sets, on the wall", wall, "at most", TARGET, "s"),
            Goal(
                "best sets that screening misses of those that simulating all finds",
                float(not same),
                "at most",
                0.0,
                "",
            ),
        ),
        tables=(
            Table(
                "Sets",
                ("how", "sets", "simulated", "s of a processor", "s on the wall", "best error, deg"),
                (
                    row("all simulated", whole, whole_processor, whole_wall),
                    row("the same, screened", screened, some_processor, some_wall),
                    row("a million, screened", million, processor, wall),
                ),
            ),
        ),
    )


if __name__ == "__main__":
    run_alone(section)
