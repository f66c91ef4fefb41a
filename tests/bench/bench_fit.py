"""What a fit costs and how near it comes: seven trials, nine parameters, beside scipy's least squares.

``PYTHONPATH=tests python -m bench.bench_fit [SECTION.json]``. Initial states are estimated too by ours; scipy is given
the true ones, and a start that is off by 30 %.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import least_squares

from bench import thesis_leg as thesis
from bench.results import Curve, Figure, Goal, Section, Table, load, run_alone, say, seconds
from synth.files.leg import write_leg
from synth.files.output import write_csv
from synth.files.trials import Trial
from synth.fit.estimate import FitOptions, fit_leg
from synth.fit.recordings import recordings
from synth.model.chain import simulate
from synth.model.leg import Array

NOISE = np.radians(0.1)
WARM, COMMAND, FIRST = 0.025, 1.0, 10.0  # s, targets
COUNTS = (1, 3, 7, 14, 28, 56)
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


def ours(count: int, free_angle: str) -> tuple[float, Array]:
    """Processor seconds of a fit, and its nine values."""
    leg, given = bare_leg(), recordings(bare_leg(), trials(count))
    options = FitOptions(free_angle=free_angle)
    spent = seconds(lambda: fit_leg(leg, given, options), 5 if count <= 7 else 1)
    found = list(fit_leg(leg, given, options).joints.values())
    values = [joint.spring_rate.value for joint in found]
    values += [joint.damper_rate.value for joint in found if joint.damper_rate]
    say(f"ours, {count} trials, free angle {free_angle}: {spent * 1e3:.1f} ms")
    return spent, np.array(values)


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


def commands() -> tuple[float, float]:
    """Wall seconds of ``synth fit`` on seven trials: all compiled on disk (median of three), and the first ever."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for trial in trials(7):
            columns = dict(zip(("hip [deg]", "knee [deg]", "ankle [deg]"), np.degrees(trial.angles).T, strict=True))
            write_csv(folder / trial.name, {"time [s]": trial.time, **columns})
        write_leg(bare_leg(), folder / "bare.leg.yaml")
        (folder / "fit.yaml").write_text('kind: fit\nleg: bare.leg.yaml\ntrials: ["*.csv"]\n', encoding="utf-8")

        def run(turn: str, **environment: str) -> float:
            start = time.perf_counter()
            arguments = ["fit", str(folder / "fit.yaml"), "--out", str(folder / f"out-{turn}")]
            subprocess.run(
                [sys.executable, "-m", "synth", *arguments], check=True, capture_output=True,
                env={**os.environ, **environment},
            )  # fmt: skip
            return time.perf_counter() - start

        run("before")
        warm = sorted(run(str(turn)) for turn in range(3))[1]
        say(f"synth fit: {warm:.2f} s, load {load():.1f}")
        first = run("first", SYNTH_CACHE=str(folder / "cache"))
        say(f"synth fit, nothing compiled: {first:.1f} s")
        return warm, first


def worst(values: Array) -> float:
    """Largest error of k and b, per cent."""
    return float(np.abs(values[:6] / thesis.NOMINAL[:6] - 1).max() * 100)


def section() -> Section:
    """Time and error beside scipy, the command, and the cost by trials."""
    before = load()
    common, values = ours(7, "common")
    auto, free = ours(7, "auto")
    scipy_time, scipy_values = by_scipy()
    warm, first = commands()
    by_count = [(float(n), common if n == 7 else ours(n, "common")[0]) for n in COUNTS]
    rows = [
        ("ours, one free angle", common, worst(values)),
        ("ours, free angle as the trials decide (the default)", auto, worst(free)),
        ("scipy least_squares on solve_ivp (RK45, numpy)", scipy_time, worst(scipy_values)),
    ]
    return Section(
        "Fit: spring rates, damper rates and free angles from trials",
        words=(
            "Seven releases of the three-link leg of the thesis, 1 s, 501 samples, 0.1° of noise; nine parameters. "
            "Ours needs no start and estimates each trial's initial state too (51 unknowns), then intervals; "
            f"scipy's least squares is given the true initial states and a start that is {STARTS_OFF - 1:.0%} off. "
            "Processor seconds, all threads together. mujoco.sysid: not run here.",
            f"Load (1 min) before {before:.1f}, after {load():.1f}.",
        ),
        goals=(
            Goal("fit of seven trials, warm", 1e3 * common, "at most", 1e3 * WARM, "ms"),
            Goal("synth fit, on the wall", warm, "at most", COMMAND, "s"),
            Goal("synth fit the first time ever, on the wall", first, "at most", FIRST, "s"),
        ),
        tables=(
            Table(
                "Same data",
                ("what", "ms", "times ours", "largest error of k and b, %"),
                [(words, round(1e3 * t, 1), round(t / common, 1), round(error, 2)) for words, t, error in rows],
            ),
        ),
        figures=(
            Figure("By trials", "trials", "s of a processor", (
                Curve("fit, one free angle", by_count),
                Curve("in proportion to seven", [(n, common * n / 7) for n, _ in by_count]),
            ), logarithmic=True),
        ),
    )  # fmt: skip


if __name__ == "__main__":
    run_alone(section)
