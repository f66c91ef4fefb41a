"""One cost for every response: ours against each of the thesis' costs on random legs, over- and underdamped mixed.

Every cost of the thesis is minimised with all else given: each release's true initial state and the true free angles,
and the search, the same simplex over all joints at once, begins at the true rates. Where it then walks away, the cost
is at fault and nothing else. One further method, ``trajectory as in the thesis``, starts its releases from their first
samples and takes free angles from their ends. Ours (``fit_leg``) is given the recordings alone. Judged is a release
that took no part, without noise: how far each joint of the fitted leg moves from the true leg, as a share of how far it
swings. That asks nothing of k and b where the recordings fix only b/k.

``python -m robustness.universal --count 500 --to FOLDER`` writes ``universal.json`` and ``universal.html``; stopped, it
goes on from where it was.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from robustness.random_legs import Array, Case, random_case, random_recorder
from synth.errors import UserError
from synth.fit.costs import Cost
from synth.fit.estimate import fit_leg
from synth.fit.fit_options import LegFitOptions
from synth.fit.methods import search_of
from synth.fit.rate_search import Bounds, Search
from synth.fit.recordings import Recording, recordings
from synth.fit.simplex import simplex
from synth.fit.starts import Start
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, Leg, Spring
from synth.swing.mechanics import rest_pose

OURS = "ours"
COSTS = ("trajectory", "transient", "characteristics", "by joint")
AS_IN_THE_THESIS = "trajectory as in the thesis"
CONTESTANTS = (OURS, *COSTS, AS_IN_THE_THESIS)
MOST_LINKS, MOST_TRIALS, MOST_SAMPLES, STEPS = 3, 3, 120, 100
FOLLOWED = 0.05  # of the swing: a joint with a smaller error is followed
ROOM = 10.0  # times the truth, either way: bounds of a search


@dataclass(frozen=True)
class ByJoint:
    """The thesis' choice: rise time for the first joint, decrement and frequency for the second, squares outwards."""

    parts: tuple[tuple[tuple[int, ...], Cost], ...]

    @classmethod
    def of(cls, given: Sequence[Recording]) -> ByJoint:
        """For these recordings."""
        n = given[0].rotation.shape[1]
        terms = (("rise_time",), ("damping_ratio", "damped_frequency"), *[()] * n)[:n]
        features = Cost("characteristics", tuple(given), "equal", terms)
        squares = Cost("transient", tuple(given), "equal")
        return cls(((tuple(range(min(n, 2))), features), (tuple(range(2, n)), squares)))

    def of_motions(self, motions: Sequence[Array]) -> Array:
        """(c, n) costs."""
        found = [(joints, cost.of(motions)) for joints, cost in self.parts if joints]
        total = np.zeros_like(found[0][1])
        for joints, part in found:
            total[:, list(joints)] = part[:, list(joints)]
        return total


class _Adapted:
    """``ByJoint`` in the form that a search takes."""

    def __init__(self, cost: ByJoint) -> None:
        self.cost = cost

    def of(self, motions: Sequence[Array]) -> Array:
        """(c, n) costs."""
        return self.cost.of_motions(motions)


def case_of(seed: int) -> Case:
    """The random leg of a seed with few trials and no external torque: the subject is the cost, not the cut."""
    drawn = random_recorder(np.random.default_rng([seed, 501]))
    links = 1 + int(np.random.default_rng([seed, 502]).choice(MOST_LINKS, p=[0.1, 0.2, 0.7]))
    return random_case(seed, replace(drawn, trials=min(drawn.trials, MOST_TRIALS), driven=0.0), links)


def judge(seed: int) -> dict[str, Any]:
    """Results of every method on one leg: each joint's error on the fresh release, as a share of its swing."""
    case = case_of(seed)
    given = [recording.thinned(MOST_SAMPLES) for recording in recordings(case.bare, case.trials, ())]
    found: dict[str, Leg | None] = {}
    try:
        found[OURS] = fit_leg(case.bare, given, LegFitOptions()).leg
    except UserError:
        found[OURS] = None
    for name in (*COSTS, AS_IN_THE_THESIS):
        found[name] = _by_cost(case, given, name)
    fresh = _fresh(case)
    errors = {name: None if leg is None else _errors(case, leg, fresh) for name, leg in found.items()}
    return {
        "seed": seed,
        "joints": len(case.leg.joints),
        "trials": len(given),
        "noise": case.recorder.noise,
        "counts": case.recorder.counts,
        "damping_ratio": case.damping_ratio.tolist(),
        "errors": errors,
    }


def _by_cost(case: Case, given: Sequence[Recording], name: str) -> Leg:
    """The leg that makes one of the thesis' costs small, its search begun at the truth."""
    cost = _Adapted(ByJoint.of(given)) if name == "by joint" else Cost(name.split()[0], tuple(given), "equal")
    search = search_of(case.bare, given, cost, common=True)
    if name != AS_IN_THE_THESIS:
        search = _Given.of(search, case)
    truth = np.array(
        [
            [joint.spring.rate for joint in case.leg.joints if joint.spring],
            [joint.damper.rate for joint in case.leg.joints if joint.damper],
        ],
        dtype=float,
    )
    rates = _minimised(search, truth)
    rest, _ = search.locals(rates[0])
    joints = [
        replace(joint, spring=Spring(float(k), joint.zero + joint.sign * float(q)), damper=Damper(float(b)))
        for joint, k, b, q in zip(case.leg.joints, *rates, rest, strict=True)
    ]
    return replace(case.leg, joints=tuple(joints))


class _Given(Search):
    """A search with each release's true start and the true free angles, ``true`` (n,) rad."""

    true: Array

    @classmethod
    def of(cls, search: Search, case: Case) -> _Given:
        """The same search, better informed."""
        true = [Start(rotation, rate, rotation) for rotation, rate in case.starts]
        made = cls(search.model, search.recordings, search.cost, True, tuple(true))
        made.true = np.array([j.sign * (j.spring.free_angle - j.zero) for j in case.leg.joints if j.spring])
        return made

    def rests(self, spring_rate: Array) -> Array:
        """(n_trial, n, c) rad: the truth, whatever the spring rates."""
        return np.repeat(
            np.repeat(self.true[None, :, None], len(self.recordings), axis=0), spring_rate.shape[1], axis=2
        )


def _minimised(search: Search, truth: Array) -> Array:
    """(2, n) rates, all joints at once."""
    bounds = Bounds.around(truth, ROOM)

    def cost(columns: Array) -> Array:
        return np.asarray(search.by_joint(np.exp(columns.reshape(2, search.n, -1))).sum(axis=1))

    low, high = np.log(bounds.lower).ravel(), np.log(bounds.upper).ravel()
    return np.exp(simplex(cost, np.log(truth).ravel(), low, high, max_iterations=STEPS).point.reshape(2, -1))


def _fresh(case: Case) -> tuple[Array, Array, Array, Array]:
    """Times, start, first rate and the true motion (m, n) of a release that took no part."""
    generator = np.random.default_rng([case.seed, 777])
    n = len(case.leg.joints)
    start = rest_pose(case.leg) + np.radians(generator.uniform(10, 25, n)) * generator.choice((-1, 1), n)
    times = np.linspace(0.0, float(case.trials[0].time[-1]), 400)
    rate = np.zeros(n)
    return times, start, rate, simulate(case.leg, start, rate, times)


def _errors(case: Case, leg: Leg, fresh: tuple[Array, Array, Array, Array]) -> list[float]:
    """(n,) RMS error of each joint over the RMS of its true motion about rest; 10 where the motion diverges."""
    times, start, rate, true = fresh
    try:
        motion = simulate(leg, start, rate, times)
    except ArithmeticError:
        return [10.0] * true.shape[1]
    swing = np.sqrt(np.mean((true - rest_pose(case.leg)) ** 2, axis=0))
    off = np.sqrt(np.mean((motion - true) ** 2, axis=0)) / swing
    return [float(min(value, 10.0)) for value in off]


@dataclass(frozen=True)
class Share:
    """Of ``joints`` joints a method follows ``followed``; ``median`` and ``worst`` (90 %) errors are shares."""

    joints: int
    followed: int
    median: float
    worst: float

    @classmethod
    def of(cls, errors: Sequence[float]) -> Share:
        """Of these errors."""
        if not errors:
            return cls(0, 0, float("nan"), float("nan"))
        followed = sum(error <= FOLLOWED for error in errors)
        return cls(len(errors), followed, float(np.median(errors)), float(np.quantile(errors, 0.9)))


def groups(results: Sequence[dict[str, Any]]) -> dict[str, dict[str, Share]]:
    """Group -> method -> share: all joints, by damping, and by place in the chain."""
    tests = {
        "all joints": lambda ratio, j, n: True,
        "underdamped, ratio under 0.4": lambda ratio, j, n: ratio < 0.4,
        "between": lambda ratio, j, n: 0.4 <= ratio <= 1.0,
        "overdamped, ratio over 1": lambda ratio, j, n: ratio > 1.0,
        "first joint": lambda ratio, j, n: j == 0,
        "second joint": lambda ratio, j, n: j == 1,
        "joints beyond": lambda ratio, j, n: j > 1,
    }
    found: dict[str, dict[str, Share]] = {}
    for label, belongs in tests.items():
        found[label] = {}
        for name in CONTESTANTS:
            errors = [
                10.0 if result["errors"][name] is None else result["errors"][name][j]
                for result in results
                for j, ratio in enumerate(result["damping_ratio"])
                if belongs(ratio, j, result["joints"])
            ]
            found[label][name] = Share.of(errors)
    return found


def legs_followed(results: Sequence[dict[str, Any]]) -> dict[str, int]:
    """Method -> number of legs of which every joint is followed."""
    return {
        name: sum(r["errors"][name] is not None and max(r["errors"][name]) <= FOLLOWED for r in results)
        for name in CONTESTANTS
    }


def run(count: int, folder: Path, workers: int = 1) -> list[dict[str, Any]]:
    """Compute the missing legs, one line each, and return all in order."""
    folder.mkdir(parents=True, exist_ok=True)
    log = folder / "legs.jsonl"
    done = [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []
    known = {result["seed"] for result in done}
    missing = [seed for seed in range(count) if seed not in known]
    with log.open("a") as stream, ProcessPoolExecutor(max_workers=workers) as pool:
        for result in pool.map(judge, missing):
            stream.write(json.dumps(result) + "\n")
            stream.flush()
            done.append(result)
    return sorted((result for result in done if result["seed"] < count), key=lambda result: int(result["seed"]))


def main() -> None:
    """Run, and write figures and page."""
    from robustness.universal_page import write_page

    parser = argparse.ArgumentParser(description="one cost for every response, against each of the thesis' costs")
    parser.add_argument("--count", type=int, default=500, help="legs (500)")
    parser.add_argument("--to", type=Path, default=Path("build/universal"), help="folder to write")
    parser.add_argument("--workers", type=int, default=1, help="processes")
    arguments = parser.parse_args()
    results = run(arguments.count, arguments.to, arguments.workers)
    write_page(results, arguments.to)


if __name__ == "__main__":
    main()
