"""Time and error of a fit: seven trials, nine parameters, beside scipy's and MuJoCo's least squares.

``PYTHONPATH=tests python -m bench.bench_fit [SECTION.json]``. Initial states are estimated too by ours; the others are
given the true ones, and a start that is off by 30 %. ``BENCH_SYSID`` names a Python that has ``mujoco[sysid]``.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

from synth.threads import LIBRARIES

os.environ.update({name: os.environ.get(name, "1") for name in LIBRARIES})  # as every command does, before numpy

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

from bench import thesis_leg as thesis
from bench.results import Curve, Figure, Goal, Section, Table, load, run_alone, say, seconds
from peers.mujoco_leg import mjcf
from synth.arrays import Array
from synth.files.leg_file import write_leg
from synth.files.output import write_csv
from synth.files.trial_list import Trial
from synth.fit.estimate import fit_leg
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_result import FitResult
from synth.fit.recordings import recordings
from synth.swing.chain import simulate

NOISE = np.radians(0.1)
WARM, COMMAND, FIRST = 0.025, 1.0, 10.0  # s, targets
COUNTS = (1, 3, 7, 30, 100, 300, 1000)
STARTS_OFF = 1.3


def trials(count: int) -> list[Trial]:
    """The seven releases in turn, each turn a tenth smaller, read with noise."""
    generator = np.random.default_rng(2)
    made, leg = [], thesis.leg()
    for index in range(count):
        release = thesis.RELEASES[index % 7] * 0.9 ** (index // 7 % 5)
        motion = simulate(leg, release, np.zeros(3), thesis.TIMES)
        made.append(Trial(f"{index:03d}.csv", thesis.TIMES, motion + NOISE * generator.standard_normal(motion.shape)))
    return made


def bare_leg():  # type: ignore[no-untyped-def]
    """The links alone."""
    leg = thesis.leg()
    return leg.with_joints(**{name: {"spring": None, "damper": None} for name in leg.joint_names})


@dataclass(frozen=True)
class Spent:
    """Seconds of a processor, all threads together, and on the wall at best, and the six rates found."""

    processor: float
    wall: float
    values: Array


def ours(count: int, free_angle: str) -> Spent:
    """A warm fit of so many trials."""
    leg, given = bare_leg(), recordings(bare_leg(), trials(count))
    options = LegFitOptions(free_angle=free_angle)
    walls: list[float] = []

    def fit() -> None:
        start = time.perf_counter()
        results.append(fit_leg(leg, given, options))
        walls.append(time.perf_counter() - start)

    results: list[FitResult] = []
    spent = seconds(fit, 25 if count <= 7 else 1)
    found = list(results[-1].joints.values())
    values = [joint.spring_rate.value for joint in found]
    values += [joint.damper_rate.value for joint in found if joint.damper_rate]
    say(f"ours, {count} trials, free angle {free_angle}: {spent * 1e3:.1f} ms, on the wall {min(walls) * 1e3:.1f} ms")
    return Spent(spent, min(walls), np.array(values))


def by_scipy(method: str = "RK45") -> tuple[float, Array]:
    """``least_squares`` on ``solve_ivp``, differences for derivatives, in log k and log b; initial states known."""
    given = trials(7)

    def parameters(x: Array) -> Array:
        return np.concatenate([np.exp(x[:6]), x[6:]])

    def residual(x: Array) -> Array:
        parts = []
        for trial in given:
            index = int(trial.name[:3])
            solved = solve_ivp(
                thesis.derivative, (0, 1), thesis.start(thesis.RELEASES[index]), method, thesis.TIMES,
                rtol=1e-6, atol=1e-6, args=(parameters(x),),
            )  # fmt: skip
            parts.append((thesis.joints(solved.y[:3].T) - trial.angles).ravel() / NOISE)
        return np.concatenate(parts)

    first = np.concatenate([np.log(thesis.NOMINAL[:6] * STARTS_OFF), np.zeros(3)])
    start = time.process_time()
    found = least_squares(residual, first, diff_step=1e-4)
    spent = time.process_time() - start
    say(f"scipy: {spent:.1f} s")
    return spent, parameters(found.x)[:6]


def by_sysid() -> tuple[float, Array, str] | None:
    """MuJoCo's system identification on the same trials from the same start, and its version; None where there is none.

    Runge-Kutta steps of 2 ms, whose error of 5e-5 rad is far below the noise.
    """
    python = os.environ.get("BENCH_SYSID")
    if not python:
        return None
    start = np.concatenate([thesis.NOMINAL[:6] * STARTS_OFF, np.zeros(3)])
    with tempfile.TemporaryDirectory() as folder:
        problem = Path(folder) / "problem.npz"
        np.savez(
            problem, names=list(bare_leg().joint_names), start=start, times=thesis.TIMES, releases=thesis.RELEASES,
            angles=np.array([trial.angles for trial in trials(7)]),
            mjcf=mjcf(thesis.leg(start), np.zeros(3), step=2e-3),
        )  # fmt: skip
        script = Path(__file__).with_name("peer_sysid.py")
        told = subprocess.run([python, str(script), str(problem)], check=True, capture_output=True, text=True)
    found = json.loads(told.stdout)
    say(f"mujoco.sysid: {found['seconds']:.1f} s")
    return found["seconds"], np.array(found["values"])[:6], found["version"]


@dataclass(frozen=True)
class Ran:
    """Seconds of a command on the wall and of a processor."""

    wall: float
    processor: float


def commands() -> tuple[Ran, Ran]:
    """``synth fit`` on seven trials: all compiled on disk (median of five), and the first time ever."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for trial in trials(7):
            columns = dict(zip(("hip [deg]", "knee [deg]", "ankle [deg]"), np.degrees(trial.angles).T, strict=True))
            write_csv(folder / trial.name, {"time [s]": trial.time, **columns})
        write_leg(bare_leg(), folder / "bare.leg.yaml")
        (folder / "fit.yaml").write_text('kind: fit\nleg: bare.leg.yaml\ntrials: ["*.csv"]\n', encoding="utf-8")

        def run(turn: str, **environment: str) -> Ran:
            start, before = time.perf_counter(), children()
            arguments = ["fit", str(folder / "fit.yaml"), "--out", str(folder / f"out-{turn}")]
            subprocess.run(
                [sys.executable, "-m", "synth", *arguments], check=True, capture_output=True,
                env={**os.environ, **environment},
            )  # fmt: skip
            return Ran(time.perf_counter() - start, children() - before)

        run("before")
        runs = [run(str(turn)) for turn in range(5)]
        warm = Ran(sorted(r.wall for r in runs)[2], sorted(r.processor for r in runs)[2])
        say(f"synth fit: {warm.wall:.2f} s, of a processor {warm.processor:.2f} s, load {load():.1f}")
        first = run("first", SYNTH_CACHE=str(folder / "cache"))
        say(f"synth fit, nothing compiled: {first.wall:.1f} s, of a processor {first.processor:.1f} s")
        return warm, first


def children() -> float:
    """Processor seconds of the processes that have ended."""
    times = os.times()
    return times.children_user + times.children_system


def worst(values: Array) -> float:
    """Largest error of k and b, per cent."""
    return float(np.abs(values[:6] / thesis.NOMINAL[:6] - 1).max() * 100)


def section() -> Section:
    """Time and error beside scipy, the command, and the cost by trials."""
    before = load()
    common, auto = ours(7, "common"), ours(7, "auto")
    scipy_time, scipy_values = by_scipy()
    sysid = by_sysid()
    warm, first = commands()
    by_count = [(float(n), common.processor if n == 7 else ours(n, "common").processor) for n in COUNTS]
    rows: list[tuple[str, float, float | None, float]] = [
        ("ours, one free angle", common.processor, common.wall, worst(common.values)),
        ("ours, free angle as the trials decide (the default)", auto.processor, auto.wall, worst(auto.values)),
        ("scipy least_squares on solve_ivp (RK45, numpy)", scipy_time, None, worst(scipy_values)),
    ]
    if sysid:
        rows.append((f"mujoco.sysid {sysid[2]} (Gauss-Newton, RK4 at 2 ms)", sysid[0], None, worst(sysid[1])))
    growth = (by_count[-1][1] / by_count[-1][0]) / (common.processor / 7)
    return Section(
        "Fit: spring rates, damper rates and free angles from trials",
        words=(
            "Seven releases of the three-link leg of the thesis, 1 s, 501 samples, 0.1° of noise; nine parameters. "
            "Ours needs no start and estimates each trial's initial state too (51 unknowns), then intervals; "
            f"the others are given the true initial states and a start that is {STARTS_OFF - 1:.0%} off. "
            "Processor seconds, all threads together; on the wall the least of 25 fits.",
            *(() if sysid else ("mujoco.sysid: not run here (name a Python that has it in BENCH_SYSID).",)),
            f"A trial of {COUNTS[-1]} costs {growth:.2f} times what one of seven does.",
            "The first time ever two modules are compiled, the equations of motion and the integrator, and the command "
            "says so, how long it takes and where they are kept.",
            f"Load (1 min) before {before:.1f}, after {load():.1f}.",
        ),
        goals=(
            Goal("fit of seven trials, warm, of a processor", 1e3 * common.processor, "at most", 1e3 * WARM, "ms"),
            Goal("the same on the wall", 1e3 * common.wall, "at most", 1e3 * WARM, "ms"),
            Goal("synth fit, on the wall", warm.wall, "at most", COMMAND, "s"),
            Goal("synth fit, of a processor", warm.processor, "at most", COMMAND, "s"),
            Goal("synth fit the first time ever, on the wall", first.wall, "at most", FIRST, "s"),
            Goal("synth fit the first time ever, of a processor", first.processor, "at most", FIRST, "s"),
            Goal("a trial of a thousand by one of seven", growth, "at most", 1.5, "×"),
        ),
        tables=(
            Table(
                "Same data",
                ("what", "ms of a processor", "times ours", "ms on the wall", "largest error of k and b, %"),
                [
                    (words, round(1e3 * t, 1), round(t / common.processor, 1),
                     None if wall is None else round(1e3 * wall, 1), round(error, 2))
                    for words, t, wall, error in rows
                ],
            ),
        ),
        figures=(
            Figure("By trials", "trials", "s of a processor", (
                Curve("fit, one free angle", by_count),
                Curve("in proportion to seven", [(n, common.processor * n / 7) for n, _ in by_count]),
            ), logarithmic=True),
        ),
    )  # fmt: skip


if __name__ == "__main__":
    run_alone(section)
