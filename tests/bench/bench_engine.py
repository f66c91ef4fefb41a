"""Trajectories a second and core of the three-link leg, ours beside other engines in the same run.

``PYTHONPATH=tests python -m bench.bench_engine [SECTION.json]``. One second, 501 samples, largest error of any joint
at most 1e-6 rad against DOP853 at 1e-12, each engine at the coarsest setting that holds it. Rates are a core's: by
processor time, one thread. ``BENCH_DIFFRAX`` names a Python that has diffrax.
"""

from __future__ import annotations

import ast
import inspect
import json
import os
import subprocess
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numba import njit
from scipy.integrate import solve_ivp

from bench import engines
from bench import thesis_leg as thesis
from bench.results import Curve, Figure, Goal, Section, Table, load, run_alone, say, seconds
from synth.arrays import Array
from synth.compiling import trigonometry
from synth.parts.damper_law import power_law_curve
from synth.swing import chain_source
from synth.swing.chain import Chain, compiled_chain
from synth.swing.damper_curves import compiled_rows
from synth.swing.effects import effect_named
from synth.swing.lane_layout import CURVE_POINTS, LANES, Layout
from synth.swing.leg_lanes import LegLanes
from synth.threads import core_count

ERROR = 1e-6  # rad
TARGET, OFF_SHARE = 60_000.0, 0.7  # trajectories a second; share of it that is to be left with all effects compiled in
BENT_ERROR, EXPONENT, BENT_AT = 3e-6, 0.45, 5.0  # rad; of the damper's law; rad/s where it meets the linear damper
COUNT = 1024  # trajectories of ours in one call
SETTINGS = (1e-3, 3e-4, 1e-4, 3e-5, 1e-5, 3e-6, 1e-6, 3e-7, 1e-7, 1e-8)


@dataclass(frozen=True)
class Speed:
    """An engine's trajectories a second and core, at the setting that gives ``error`` (rad)."""

    name: str
    setting: str
    error: float
    rate: float


def accuracy_set() -> tuple[Array, Array]:
    """Releases and parameters (14, ...): the seven releases by two parameter sets."""
    return np.repeat(thesis.RELEASES, 2, axis=0), np.tile(thesis.parameters(2), (7, 1))


def timing_set(count: int) -> tuple[Array, Array]:
    """Releases in turn, parameters spread."""
    return thesis.RELEASES[np.arange(count) % 7], thesis.parameters(count)


def reference(releases: Array, parameters: Array) -> Array:
    """(N, 501, 3) rad by DOP853 at 1e-12."""
    found = []
    for release, p in zip(releases, parameters, strict=True):
        solved = solve_ivp(
            thesis.derivative, (0, 1), thesis.start(release), "DOP853", thesis.TIMES, rtol=1e-12, atol=1e-13, args=(p,)
        )
        found.append(thesis.joints(solved.y[:3].T))
    return np.array(found)


def our_lanes(chain: Chain, releases: Array, parameters: Array, friction: float = 0.0) -> Array:
    """(n_row, N) lanes with state; ``friction`` times the leg's dry friction, and without it no effect."""
    legs = LegLanes.of(thesis.leg(), len(releases))
    legs.spring_rate[:], legs.damper_rate[:], legs.rest[:] = (
        parameters[:, :3].T,
        parameters[:, 3:6].T,
        parameters[:, 6:].T,
    )
    if friction:
        for joint, torque in enumerate(friction * thesis.FRICTION):
            legs.put(effect_named("coulomb_friction"), joint, [float(torque), 0.0, 0.0])
    lanes = chain.lanes(legs)
    lanes[chain.layout.rows("rotation")] = releases.T
    return lanes


def bent(lanes: Array, chain: Chain) -> Array:
    """The same lanes with a power law at each joint that has the linear damper's torque at ``BENT_AT``."""
    made, layout = lanes.copy(), chain.layout
    speeds, slopes = made[layout.rows("curve_speed")], made[layout.rows("curve_slope")]
    rates = made[layout.rows("damper_rate")]
    for joint, lane in np.ndindex(rates.shape):
        rows = slice(joint * CURVE_POINTS, (joint + 1) * CURVE_POINTS)
        curve = power_law_curve(float(rates[joint, lane]) * BENT_AT, BENT_AT, EXPONENT)
        speeds[rows, lane], slopes[rows, lane] = compiled_rows(curve)
    rates[:] = 0.0
    return made


def bent_speeds() -> list[tuple[Speed, float]]:
    """Power-law dampers, sixteen different legs a group and sixteen copies; with times of the linear dampers'."""
    chain, found = compiled_chain(3), []
    for name, copies in (("sixteen legs", 1), ("one leg and its copies", LANES)):
        releases, parameters = (np.repeat(each, copies, axis=0) for each in timing_set(COUNT // copies))
        straight = our_lanes(chain, releases, parameters)
        curved = bent(straight, chain)
        some = curved[:, : 4 * LANES]
        truth = chain.run(some, thesis.TIMES, 1e-9)
        for setting in SETTINGS:
            error = float(np.abs(chain.run(some, thesis.TIMES, setting) - truth).max())
            if error <= BENT_ERROR:
                break
        spent, linear = _spent(chain, curved, setting), _spent(chain, straight, setting)
        label = f"ours, dampers of torque w^{EXPONENT:g}, {name} in a group"
        say(f"{label}: {COUNT / spent:.0f}/s at {setting:g}, error {error:.1e}, {spent / linear:.2f} times linear")
        found.append((Speed(label, f"rtol {setting:g}", error, COUNT / spent), spent / linear))
    return found


def _spent(chain: Chain, lanes: Array, setting: float) -> float:
    """Processor time of all lanes, s."""
    return seconds(lambda: chain.run(lanes, thesis.TIMES, setting), 5)


def coarsest(run, truth: Array, settings=SETTINGS) -> tuple[float, float]:  # type: ignore[no-untyped-def]
    """The coarsest setting whose largest error is at most ``ERROR``, or the finest, and that error."""
    for setting in settings:
        error = float(np.abs(run(setting) - truth).max())
        if error <= ERROR:
            break
    return setting, error


def with_everything(chain: Chain) -> Chain:
    """The chain by the integrator that holds all effects, also where none is on and the plain one would do."""
    made = replace(chain)
    made.__dict__["_plain"] = chain._whole
    return made


def ours(name: str, truth: Array | None, friction: float = 0.0, *, whole: bool = False) -> tuple[Speed, float]:
    """Our engine; without a truth its own at 1e-11 is taken. Also the tolerance."""
    chain = with_everything(compiled_chain(3)) if whole else compiled_chain(3)
    lanes = our_lanes(chain, *accuracy_set(), friction)

    def run(tolerance: float) -> Array:
        return np.moveaxis(chain.run(lanes, thesis.TIMES, tolerance), 2, 0)

    setting, error = coarsest(run, run(1e-11) if truth is None else truth)
    many = our_lanes(chain, *timing_set(COUNT), friction)
    rate = COUNT / seconds(lambda: chain.run(many, thesis.TIMES, setting), 15)
    say(f"{name}: {rate:.0f}/s at {setting:g}, error {error:.1e}")
    return Speed(name, f"rtol {setting:g}", error, rate), setting


def of_engine(engine: engines.Engine, truth: Array) -> Speed:
    """Another engine."""
    releases, parameters = accuracy_set()

    def run(setting: float) -> Array:
        return engine.prepare(releases, parameters, setting)()

    setting, error = coarsest(run, truth, engine.settings)
    timed = engine.prepare(*timing_set(engine.count), setting)
    rate = engine.count / seconds(timed, 3)
    say(f"{engine.name}: {rate:.1f}/s at {setting:g}, error {error:.1e}")
    return Speed(engine.name, f"{engine.unit} {setting:.3g}", error, rate)


def diffrax(truth: Array) -> Speed | None:
    """The rate of diffrax by the Python that ``BENCH_DIFFRAX`` names; None where there is none."""
    python = os.environ.get("BENCH_DIFFRAX")
    if not python:
        return None
    releases, parameters = accuracy_set()
    many_releases, many_parameters = timing_set(256)
    with tempfile.TemporaryDirectory() as folder:
        problem = Path(folder) / "problem.npz"
        np.savez(
            problem, first=np.array([thesis.start(r) for r in releases]), parameters=parameters, reference=truth,
            many_first=np.array([thesis.start(r) for r in many_releases]), many_parameters=many_parameters,
            constants=thesis.CONSTANTS, times=thesis.TIMES, accelerations=inspect.getsource(thesis.accelerations),
        )  # fmt: skip
        script = Path(__file__).with_name("peer_diffrax.py")
        told = subprocess.run([python, str(script), str(problem)], check=True, capture_output=True, text=True)
    found = json.loads(told.stdout)
    name = f"diffrax {found['version']} Dopri5, 256 at once"
    say(f"{name}: {found['rate']:.0f}/s")
    return Speed(name, f"rtol {found['setting']:g}", found["error"], found["rate"])


def scaling(tolerance: float) -> list[tuple[float, float]]:
    """(threads, trajectories a second on the wall)."""
    chain = compiled_chain(3)
    many = our_lanes(chain, *timing_set(COUNT))
    found = []
    for threads in range(1, core_count() + 1):
        parts = np.array_split(many, threads, axis=1)
        with ThreadPoolExecutor(threads) as pool:

            def go(pool: ThreadPoolExecutor = pool, parts: list[Array] = parts) -> None:
                list(pool.map(lambda part: chain.run(part, thesis.TIMES, tolerance), parts))

            go()
            best = min(_wall(go) for _ in range(7))  # the least disturbed
        found.append((float(threads), COUNT / best))
    return found


def _wall(function) -> float:  # type: ignore[no-untyped-def]
    start = time.perf_counter()
    function()
    return time.perf_counter() - start


def operations(tree: ast.AST, sine_cosine: int = 0) -> int:
    """Additions, multiplications, divisions, negations and minima that a text does once."""
    count = 0
    for node in ast.walk(tree):
        if isinstance(node, ast.BinOp | ast.UnaryOp):
            count += 1
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            count += sine_cosine if node.func.id == "sine_cosine" else 2 * (node.func.id in ("min", "max"))
    return count


def work(tolerance: float) -> tuple[float, float]:
    """Steps of a lane group, and floating-point operations a trajectory, counted in the generated text."""
    chain = compiled_chain(3)
    sine = operations(ast.parse(inspect.getsource(trigonometry.sine_cosine.py_func)))
    each = _operations_of_lane(chain_source.right_hand_side(Layout(3, chain.layout.laws)), sine)
    steps = []

    def counted(*arguments):  # type: ignore[no-untyped-def]
        steps.append(seen(*arguments)[0])

    counting, (seen, *called) = replace(chain), chain._plain
    counting.__dict__["_plain"] = (counted, *called)
    counting.run(our_lanes(chain, *timing_set(112)), thesis.TIMES, tolerance)
    # Three links: sums of accelerations for angles and rates, the error and its scale, dense output of the angles.
    of_stages = 3 * (2 * 2 * 17 + 2 * 6 + 2 * (2 * 6 + 6) + 2 * 6 + 8)
    of_samples = 501 * 3 * 7
    mean = float(np.mean(steps))
    return mean, mean * (6 * each + of_stages) + of_samples


def _operations_of_lane(text: str, sine_cosine: int) -> int:
    """Operations that the loops over lanes of a three-link right-hand side do for one lane."""
    loops = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.For)]
    count = 0
    for loop in loops:
        assert isinstance(loop.iter, ast.Call)
        (length,) = [ast.literal_eval(each) for each in loop.iter.args]
        body = ast.Module(loop.body, [])
        for node in ast.walk(body):
            if isinstance(node, ast.Subscript):  # sums of indices are done by the compiler
                node.slice = ast.Constant(0)
        count += length // LANES * operations(body, sine_cosine)
    return count


@njit(fastmath={"contract"})
def _multiply_and_add(x, a, b, count):  # type: ignore[no-untyped-def]
    for _ in range(count):
        for k in range(x.size):
            value = x[k]
            for _ in range(16):  # in registers: a store at every operation would be the limit
                value = value * a + b
            x[k] = value


def peak() -> float:
    """Floating-point operations a second of one core: multiply-and-add as the same compiler's vector code does it."""
    best, count = 0.0, 4_000
    for size in (64, 128, 256):
        x = np.ones(size)
        spent = seconds(lambda x=x: _multiply_and_add(x, 0.999999, 1e-7, count), 5)  # type: ignore[misc]
        best = max(best, 2.0 * 16 * size * count / spent)
    return best


def section() -> Section:
    """All engines, ratios, scaling and how near the machine's limit ours is."""
    before = load()
    releases, parameters = accuracy_set()
    truth = reference(releases, parameters)
    plain, tolerance = ours("ours, sixteen lanes, no effect on", truth)
    whole, _ = ours("ours, by the integrator with all effects in it, every one off", truth, whole=True)
    rubbed, _ = ours("ours, with dry friction at every joint", None, friction=1.0)
    curved = bent_speeds()
    found = [plain, whole, rubbed, *(speed for speed, _ in curved)]
    peer = diffrax(truth)
    found += [peer] if peer else []
    others = [*engines.sundials_engines(), *engines.scipy_engines(), *engines.mujoco_engines()]
    found += [of_engine(engine, truth) for engine in others]
    threads = scaling(tolerance)
    steps, flop = work(tolerance)
    limit = peak() / flop
    rate = {speed.name: speed.rate for speed in found}
    lsoda = max(value for name, value in rate.items() if "LSODA" in name)
    numpy_lsoda = rate["scipy LSODA, numpy right-hand side"]
    return Section(
        "Engine: trajectories a second and core",
        words=(
            "The three-link leg of the thesis, 1 s, 501 samples, spring and damper rates spread by exp(±0.3); each "
            "engine at its coarsest setting with at most 1e-6 rad of error at any sample of 14 trajectories, against "
            "DOP853 at 1e-12 (where effects are on: against our own at 1e-11; bent dampers: 3e-6 rad, against "
            "1e-9). One thread, by processor time, so that other work on the machine counts little.",
            f"A trajectory takes {steps:.0f} steps and {flop / 1e6:.2f} million operations (counted in the generated "
            f"text); one core does {flop * limit / 1e9:.0f} GFLOP/s of multiply-and-add, compiled "
            f"by the same compiler, so the limit is {limit:,.0f} trajectories a second and ours stands at "
            f"{plain.rate / limit:.0%} of it. In the way: additions and multiplications that do not pair, divisions, "
            "sixteen lanes that share the step of the hardest, more values at once than the processor has registers, "
            "and the state's way through memory between stages.",
            "Where no effect is on in any lane an integrator runs that has nothing of them in it; the one with all of "
            "them is given beside it. A call holds 1024 trajectories and makes its arrays anew.",
            *(() if peer else ("diffrax: not run here (name a Python that has it in BENCH_DIFFRAX).",)),
            f"Load (1 min) before {before:.1f}, after {load():.1f}.",
        ),
        goals=(
            Goal("trajectories, no effect on", plain.rate, "at least", TARGET, "1/s and core"),
            Goal("the same, all effects in and off", whole.rate, "at least", OFF_SHARE * TARGET, "1/s and core"),
            Goal("times MuJoCo's RK4", plain.rate / rate["MuJoCo rollout, RK4"], "at least", 400.0, "×"),
            Goal("times LSODA, numpy", plain.rate / numpy_lsoda, "at least", 250.0, "×"),
            Goal("times LSODA, its faster form", plain.rate / lsoda, "at least", 250.0, "×"),
            Goal("time of w^0.45 dampers over linear ones, sixteen legs", curved[0][1], "at most", 3.0, "×"),
            Goal("the same, one leg and its copies", curved[1][1], "at most", 3.0, "×"),
            Goal("all threads against one", threads[-1][1] / threads[0][1], "at least", 0.95 * threads[-1][0], "×"),
        ),
        tables=(
            Table(
                "Side by side",
                ("engine", "setting", "largest error, rad", "trajectories/s and core", "ours is faster by"),
                [(s.name, s.setting, f"{s.error:.1e}", round(s.rate, 1), round(plain.rate / s.rate, 2)) for s in found],
                note="An error above 1e-6 rad means that none of the settings tried reached it.",
            ),
        ),
        figures=(
            Figure("Over threads", "threads", "trajectories/s", (Curve("ours, on the wall", threads),)),
        ),
    )  # fmt: skip


if __name__ == "__main__":
    run_alone(section)
