"""Legs whose recordings are dirty as a camera's or a skin marker's are: do the intervals hold?

The motion is not this program's: the equations are written here and integrated by ``scipy``. A leg, its links' errors
and its joints' rates are drawn as of ``random_legs``; each kind of dirt has one number that says how much of it there
is. ``python -m robustness.dirty --kind lost_frames --seed 41 --count 40 --to FOLDER`` writes a line a leg, goes on
where it was, and prints the share of 90 % intervals that hold. In each line is what the fit says (``said``).
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from robustness.numbers import QUANTITIES, line
from robustness.random_legs import TOLERANCE_OF_LINKS, Case, Recorder, random_leg, slowest_time
from robustness.study import fitted
from synth.files.trial_list import Trial
from synth.fit.fit_options import LegFitOptions
from synth.swing.leg_model import Leg
from synth.swing.mechanics import rest_pose

Array = NDArray[np.float64]
Motion = Callable[[Array], Array]

GRAVITY = 9.81
AS_SYNTH_FIT = LegFitOptions(tolerance=TOLERANCE_OF_LINKS, release="free", laws="auto")


class Pendulums:
    """A leg's equations by absolute angles phi from straight down: positions of the centres of mass, Lagrange."""

    def __init__(self, leg: Leg) -> None:
        links = [joint.link for joint in leg.joints]
        n = len(links)
        arms = np.array([[links[i].length if i < k else links[k].com * (i == k) for i in range(n)] for k in range(n)])
        mass = np.array([link.mass for link in links])
        self.inertia = arms.T @ (mass[:, None] * arms) + np.diag([link.inertia for link in links])
        self.weight = GRAVITY * mass @ arms
        self.turn = np.tril(np.ones((n, n)))  # phi = turn @ q
        self.rate = np.array([joint.spring.rate for joint in leg.joints if joint.spring])
        self.free = np.array([j.sign * (j.spring.free_angle - j.zero) for j in leg.joints if j.spring])
        self.damping = np.array([joint.damper.rate or 0.0 for joint in leg.joints if joint.damper])

    def acceleration(self, angle: Array, rate: Array, torque: Array) -> Array:
        """(n,) rad/s^2 of phi from the joints' angles and rates (n,) and torques (n,) beside springs and dampers."""
        phi, omega = self.turn @ angle, self.turn @ rate
        apart = phi[:, None] - phi
        of_joint = torque - self.rate * (angle - self.free) - self.damping * rate
        on_link = of_joint - np.append(of_joint[1:], 0.0)
        pulled = on_link - self.weight * np.sin(phi) - (self.inertia * np.sin(apart)) @ omega**2
        return np.linalg.solve(self.inertia * np.cos(apart), pulled)

    def released(
        self, start: Array, first: Array, duration: float, hand: Motion | None = None, tissue: float = 0.0
    ) -> tuple[Motion, Motion]:
        """Joint angles, and what markers on soft tissue of natural frequency ``tissue`` Hz turn beside the links."""
        n, stiff = len(start), (2.0 * math.pi * tissue) ** 2
        back = np.linalg.inv(self.turn)

        def slope(time: float, state: Array) -> Array:
            angle, rate, wobble, speed = state.reshape(4, n)
            pushed = np.zeros(n) if hand is None else hand(np.array([time]))[0]
            phi = self.acceleration(angle, rate, pushed)
            shaken = -phi - stiff * wobble - 0.4 * math.sqrt(stiff) * speed if tissue else np.zeros(n)
            return np.concatenate([rate, back @ phi, speed, shaken])

        state = np.concatenate([start, first, np.zeros(2 * n)])
        most = 0.02 if hand is not None else np.inf
        found = solve_ivp(
            slope, (0.0, duration), state, method="DOP853", rtol=1e-8, atol=1e-9, dense_output=True, max_step=most
        )
        assert found.sol is not None
        path: Motion = found.sol
        return lambda t: path(t)[:n].T, lambda t: (back @ path(t)[2 * n : 3 * n]).T


def drawn_recorder(generator: np.random.Generator) -> Recorder:
    """A camera's or a marker system's: 0.1 to 0.4 deg, 100 to 250 Hz, 3 to 8 trials."""
    noise = math.exp(generator.uniform(math.log(0.1), math.log(0.4)))
    return Recorder(noise, 0, float(generator.choice((100.0, 120.0, 200.0, 250.0))), int(generator.integers(3, 9)))


def dirty_case(kind: str, seed: int) -> Case | None:
    """The case of a seed; None for a leg that falls over. Every kind has the same legs and releases."""
    generator = np.random.default_rng([seed, 510])
    try:
        leg, ratio = random_leg(generator, int(generator.choice((2, 3, 3))))
        rest = rest_pose(leg)
    except ArithmeticError:
        return None
    recorder, duration = drawn_recorder(generator), float(np.clip(4.0 * slowest_time(leg), 0.6, 2.0))
    made, starts = [], []
    for i in range(recorder.trials):
        n = len(leg.joints)
        away = np.radians(generator.uniform(8, 30, n)) * generator.choice((-1, 1), n)
        first = generator.normal(0.0, 0.2, n)
        own = np.random.default_rng([seed, 511, i])
        time, rotation = _KINDS[kind](leg, (rest + away, first), duration, recorder.rate, own)
        noise = np.random.default_rng([seed, 512, i]).normal(0.0, math.radians(recorder.noise), rotation.shape)
        made.append(Trial(f"release {i}", time, leg.to_measured(rotation + noise)))
        starts.append(np.array([rest + away, first]))
    return Case(seed, leg, recorder, tuple(made), ratio, tuple(starts))


Start = tuple[Array, Array]


def _clean(leg: Leg, start: Start, duration: float, rate: float, own: np.random.Generator) -> tuple[Array, Array]:
    time = np.arange(round(duration * rate) + 1) / rate
    return time, Pendulums(leg).released(*start, duration)[0](time)


def _moved_clock(
    leg: Leg, start: Start, duration: float, rate: float, late: Callable[[int], Array]
) -> tuple[Array, Array]:
    """Stamped evenly; ``late`` (m,) steps by which the samples are taken later."""
    count = round(duration * rate) + 1
    true = (np.arange(count) + late(count)) / rate
    motion, _ = Pendulums(leg).released(*start, float(true.max()) + 1e-6)
    return np.arange(count) / rate, motion(np.maximum(true, 0.0))


def _jitter(leg: Leg, start: Start, duration: float, rate: float, own: np.random.Generator) -> tuple[Array, Array]:
    """Stamps off by 0.25 steps RMS, each by itself."""
    return _moved_clock(leg, start, duration, rate, lambda count: np.r_[0.0, own.normal(0.0, 0.25, count - 1)])


def _lost_frames(leg: Leg, start: Start, duration: float, rate: float, own: np.random.Generator) -> tuple[Array, Array]:
    """One or two frames are lost at 1 % of the frames, and nothing says so: the time is frames over the rate."""

    def late(count: int) -> Array:
        lost = np.where(own.random(count) < 0.01, own.integers(1, 3, count), 0)
        lost[0] = 0
        return np.cumsum(lost).astype(float)

    return _moved_clock(leg, start, duration, rate, late)


def _wobble(leg: Leg, start: Start, duration: float, rate: float, own: np.random.Generator) -> tuple[Array, Array]:
    """Markers on tissue that swings at 6 to 12 Hz, damped by 0.2, and takes part in half of the motion."""
    time = np.arange(round(duration * rate) + 1) / rate
    motion, wobble = Pendulums(leg).released(*start, duration, tissue=float(own.uniform(6.0, 12.0)))
    return time, motion(time) + 0.5 * wobble(time)


def _cross_talk(leg: Leg, start: Start, duration: float, rate: float, own: np.random.Generator) -> tuple[Array, Array]:
    """A joint's angle shows 5 % of its neighbour's, as of an axis or a marker that is not where it is taken to be."""
    time = np.arange(round(duration * rate) + 1) / rate
    rotation = Pendulums(leg).released(*start, duration)[0](time)
    n = rotation.shape[1]
    mixed = np.eye(n) + 0.05 * (np.eye(n, k=1) + np.eye(n, k=-1))
    rest = rest_pose(leg)
    return time, rest + np.asarray((rotation - rest) @ mixed)


def _spread(leg: Leg, start: Start, duration: float, rate: float, own: np.random.Generator) -> tuple[Array, Array]:
    """Damper rates differ by 15 % from trial to trial; the truth is their median."""
    own_rates = {
        joint.name: {"damper": replace(joint.damper, rate=joint.damper.rate * math.exp(own.normal(0.0, 0.15)))}
        for joint in leg.joints
        if joint.damper and joint.damper.rate
    }
    return _clean(leg.with_joints(**own_rates), start, duration, rate, own)


def _hand(leg: Leg, start: Start, duration: float, rate: float, own: np.random.Generator) -> tuple[Array, Array]:
    """A hand pushes every joint for the first 0.15 s."""
    stiffness = np.array([joint.spring.rate for joint in leg.joints if joint.spring])
    push = stiffness * np.radians(15.0) * own.choice((-1, 1), len(stiffness))
    time = np.arange(round(duration * rate) + 1) / rate

    def hand(at: Array) -> Array:
        return np.where(at < 0.15, np.sin(np.pi * at / 0.15) ** 2, 0.0)[:, None] * push

    return time, Pendulums(leg).released(*start, duration, hand)[0](time)


_KINDS: dict[str, Callable[[Leg, Start, float, float, np.random.Generator], tuple[Array, Array]]] = {
    "clean": _clean,
    "jitter": _jitter,
    "lost_frames": _lost_frames,
    "wobble": _wobble,
    "cross_talk": _cross_talk,
    "spread": _spread,
    "hand": _hand,
}


def one_leg(kind: str, seed: int) -> dict[str, Any]:
    """The record of one leg; without ``fit`` if it falls over."""
    case = dirty_case(kind, seed)
    return {"seed": seed} | ({} if case is None else {"fit": fitted(case, case.off, case.trials, AS_SYNTH_FIT)})


def main(arguments: list[str] | None = None) -> None:
    """Fit the missing legs, and print the shares of intervals that hold."""
    parser = argparse.ArgumentParser(description="intervals of legs whose recordings are dirty")
    parser.add_argument("--kind", choices=tuple(_KINDS), required=True, help="of dirt")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=40, help="legs (40)")
    parser.add_argument("--to", type=Path, default=Path("build/dirty"), help="folder to write")
    parser.add_argument("--workers", type=int, default=1, help="processes")
    chosen = parser.parse_args(arguments)
    chosen.to.mkdir(parents=True, exist_ok=True)
    log = chosen.to / f"{chosen.kind}.jsonl"
    done = [json.loads(text) for text in log.read_text().splitlines()] if log.exists() else []
    known = {record["seed"] for record in done}
    missing = [s for s in range(1000 * chosen.seed, 1000 * chosen.seed + chosen.count) if s not in known]
    with log.open("a") as stream, ProcessPoolExecutor(max_workers=chosen.workers) as pool:
        for record in pool.map(one_leg, [chosen.kind] * len(missing), missing):
            stream.write(json.dumps(record) + "\n")
            stream.flush()
            done.append(record)
    fits = [record["fit"] for record in done if "fit" in record]
    ended = [fit for fit in fits if fit["done"]]
    for name, quantities in {"all": tuple(QUANTITIES), **{words: (key,) for key, words in QUANTITIES.items()}}.items():
        found = line(name, ended, quantities)
        share = f"{100 * found.held:.1f} +- {100 * found.error:.1f} % of {found.intervals}"
        print(f"{name}: {share}, half-width of rates {100 * found.width:.2g} %")  # noqa: T201
    cut = sum(fit["cut"] > 0.0 for fit in ended)
    print(f"{chosen.kind}: {len(fits)} legs, {len(fits) - len(ended)} refused, {cut} cut")  # noqa: T201


if __name__ == "__main__":
    main()
