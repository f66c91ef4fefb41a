"""Mutation test: each mutant changes one line of the core, and the tests named beside it must fail.

``make mutants`` copies the repository, applies one mutant at a time, and writes ``build/mutants/mutants.csv``. A mutant
is located by its text, not by a file name, so it follows a formula that moves. A text that is missing or occurs twice
is an error. At least ``WANTED`` of the mutants must be caught.
"""

from __future__ import annotations

import argparse
import csv
import os
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
WANTED = 0.95  # share of the mutants that the tests must catch
LONGEST = 900.0  # s for the tests of one mutant; longer counts as caught: without it they pass in that time
COPIED = ("synth", "cad", "reports", "catalogs", "tests", "tools", "pyproject.toml", "README.md", "CHANGELOG.md")


@dataclass(frozen=True)
class Mutant:
    """Replace ``text`` by ``changed`` in the only file that contains it.

    ``tests`` : files below ``tests`` that must fail. ``words`` : pytest's -k.
    """

    name: str
    text: str
    changed: str
    tests: str
    words: str = ""


MUTANTS = (
    # The chain's mechanics.
    Mutant("a link's outboard mass has no inertia", "= own[i] + outboard[i] * reach[i] ** 2",
           "= own[i]", "swing/test_mechanics.py swing/test_chain.py"),
    Mutant("coupling by the wrong length", "inertia[j, i] = length[i] * first_moment[j]",
           "inertia[j, i] = length[j] * first_moment[j]", "swing/test_mechanics.py swing/test_chain_against_mujoco.py"),
    Mutant("gravity pulls up in the weak form", "omega * turning - coefficient.weight_moments(phi)",
           "omega * turning + coefficient.weight_moments(phi)", "fit/test_weak_form.py", "tilted"),
    Mutant("a mass beside its link's line weighs nothing at rest",
           "np.asarray(self.gravity * np.sin(phi) + self.gravity_across * np.cos(phi))",
           "np.asarray(self.gravity * np.sin(phi))", "swing/test_mechanics.py", "energy"),
    Mutant("a mass beside its link's line is on the wrong side in the compiled chain",
           "= weight * moment, weight * across", "= weight * moment, -weight * across",
           "swing/test_chain_against_mujoco.py", "beside"),
    Mutant("a spring pulls to zero, not to its free angle, at rest",
           "found = self.rate * (rotation - self.rest) + static_torque(",
           "found = self.rate * rotation + static_torque(", "swing/test_mechanics.py"),
    Mutant("the free angle's sign", "return self.sign * (self.spring.free_angle - self.zero) if",
           "return (self.spring.free_angle - self.zero) if", "swing/test_chain_against_mujoco.py files/test_leg.py"),
    Mutant("Coriolis torque turned round", 'put(f"sine = s{i} * c{j} - c{i} * s{j}")',
           'put(f"sine = s{i} * c{j} + c{i} * s{j}")',
           "swing/test_chain_against_mujoco.py swing/test_chain.py"),
    Mutant("the damper helps", "'damper_rate', i))} * w{i}", "'damper_rate', i))} * (-w{i})",
           "swing/test_chain_against_mujoco.py swing/test_chain.py"),
    # The weak form.
    Mutant("a trial's tilt forgotten",
           "(recording.conditions.tip, leg.tilt + recording.conditions.tilt), []",
           "(recording.conditions.tip, leg.tilt), []",
           "fit/test_weak_form.py", "tilted"),
    Mutant("a tip mass forgotten", "momentum_and_force(coefficients(leg, tip), angle",
           "momentum_and_force(coefficients(leg), angle", "fit/test_weak_form.py", "tilted"),
    Mutant("a known torque turned round", "force += average_torques(", "force -= average_torques(",
           "fit/test_weak_form.py", "torque"),
    Mutant("the bump's slope halved", "(1.0 - u * u) ** 3, -6.0 * u *", "(1.0 - u * u) ** 3, -3.0 * u *",
           "fit/test_weak_form.py", "quadrature"),
    # Estimation.
    Mutant("trials' own unknowns are not eliminated", "reduced -= cross @ np.linalg.solve(own, cross.T)",
           "reduced -= 0.5 * cross @ np.linalg.solve(own, cross.T)", "fit/test_trajectories.py fit/test_fit.py"),
    Mutant("a 95 % interval called 90 %", "NORMAL90 = 1.6448536269514722", "NORMAL90 = 1.96",
           "fit/test_fit.py fit/test_bootstrap.py"),
    Mutant("autocorrelation counted once", "2.0 * float((weighted",
           "1.0 * float((weighted", "estimation/test_correlation.py"),
    Mutant("autocorrelation not monotone", "np.minimum.accumulate(means) / means", "means / means",
           "estimation/test_correlation.py"),
    # Motion.
    Mutant("decrement of a half cycle", "decrement = 2.0 * float(logs[0] - logs[-1])",
           "decrement = 1.0 * float(logs[0] - logs[-1])", "motion/test_characteristics.py"),
    Mutant("frequency doubled", "frequency = float(np.pi * (len(peaks) - 1)",
           "frequency = float(2 * np.pi * (len(peaks) - 1)",
           "motion/test_characteristics.py"),
    Mutant("rise to 80 %", "above = np.flatnonzero(level[:end] >= 0.9)", "above = np.flatnonzero(level[:end] >= 0.8)",
           "motion/test_characteristics.py"),
    Mutant("noise under-estimated", " / np.sqrt(share[shown])", "", "motion/test_smoothing.py"),
    Mutant("points of a tilted base", "rotation[:, 0] -= leg.tilt", "rotation[:, 0] += leg.tilt",
           "motion/importers/test_points_in_space.py"),
    # Springs.
    Mutant("spring rate by the slip of 10.8 a radian", '"friction": 10.8 * 2.0 * math.pi', '"friction": 10.8',
           "spring"),
    Mutant("rate by the cube of the wire", '_FORM = {"bending": 64.0', '_FORM = {"bending": 66.0', "spring"),
    Mutant("stress halved", "mean_diameter, wire_diameter), form)\n    return factor * 32.0 * moment",
           "mean_diameter, wire_diameter), form)\n    return factor * 16.0 * moment", "spring"),
    Mutant("curvature on the outside", "(4.0 * index**2 - index - 1.0) / (4.0 * index * (index - 1.0))",
           "(4.0 * index**2 + index - 1.0) / (4.0 * index * (index + 1.0))", "spring"),
    Mutant("the coil opens as it winds", "mean_diameter * body_coils / (body_coils + travel / math.tau)",
           "mean_diameter * body_coils / (body_coils - travel / math.tau)", "spring"),
    Mutant("Gerber without the mean stress", "return 2.0 * endurance / (1.0 + root)",
           "return endurance", "spring"),
    Mutant("wire as heavy as its square", "return density * math.pi * wire_diameter**2 / 4.0 * length",
           "return density * wire_diameter**2 * length", "spring"),
    # Parts and design.
    Mutant("a power law of another exponent", "torques = torque * (speeds / speed) ** exponent",
           "torques = torque * (speeds / speed)", "parts fit/test_damper_laws.py"),
    Mutant("parallel springs spread as one", "rate=known.rate / sqrt(count), free_angle=known.free_",
           "rate=known.rate, free_angle=known.free_", "design/test_forecast.py"),
    Mutant("a damper's table goes on where it falls", "end = speed[-1] if slope[-1] < 0.0 else UNBOUNDED",
           "end = UNBOUNDED", "swing/test_curves.py"),
    Mutant("the vendors' filter lets all through", "if parts.vendors and row.vendor.casefold() not in",
           "if parts.vendors and row.vendor.casefold() in", "parts/test_vendor_filter.py"),
    Mutant("the wanted rest drifts with each trial", "recording.time, trial.rotation - shift, trial.rate",
           "recording.time, trial.rotation, trial.rate",
           "design/test_wanted_releases.py"),
    Mutant("an opening coil bears as much as a closing one", "allowed_opening_stress=codes.OPENING * yield_stress",
           "allowed_opening_stress=yield_stress", "spring/test_workshop_papers.py"),
    Mutant("the sheet winds the coil open", 'sense = "clockwise" if spring.hand == "right"',
           'sense = "clockwise" if spring.hand == "left"', "spring/test_workshop_papers.py"),
    Mutant("a joint bears half of its springs", "loads=cad.LoadDimensions(joint.spring.rate, _damper_torque",
           "loads=cad.LoadDimensions(0.5 * joint.spring.rate, _damper_torque", "design/test_drawn_springs.py", "bears"),
    Mutant("a stronger damper's curve is faster too", "made[3 + CURVE_POINTS :] *= strength", "made[3:] *= strength",
           "design/test_forecast.py", "stronger"),
    Mutant("a gear leaves a damper's travel as it is", "travel=wanted * arrangement.ratio", "travel=wanted",
           "design/test_dampers.py", "gear"),
    # The diagnosis.
    Mutant("the shrink of squares", "1.0 - np.sqrt(np.maximum(after, 0.0) / np.where(some, before, 1.0))",
           "1.0 - np.maximum(after, 0.0) / np.where(some, before, 1.0)", "diagnosis/test_shrink.py"),
    Mutant("the noise floor is not subtracted", 'before = _rms(self.squares["before"], self.counts, pick) ** 2 - floor',
           'before = _rms(self.squares["before"], self.counts, pick) ** 2', "diagnosis/test_shrink.py"),
    Mutant("priors are not shared among single causes", "together[k] * factorial(k) / singles**k",
           "together[k] * factorial(k)", "diagnosis/test_verdict.py"),
    Mutant("an unknown parameter is free", "[calibration.per_parameter * h.n_unknown", "[0.0 * h.n_unknown",
           "diagnosis/test_verdict.py"),
    Mutant("a link's states are free near the noise", "calibration.per_state * trials", "0.0 * trials",
           "diagnosis/test_verdict.py"),
    Mutant("never unknown", "if unknown > 0.5:", "if unknown > 1.5:", "diagnosis/test_verdict.py"),
    Mutant("never a tie", "if w * calibration.tie_odds > weights[heaviest]", "if w > 2.0 * weights[heaviest]",
           "diagnosis/test_verdict.py"),
    Mutant("tolerances enter twice", "values *= np.exp(shift[q])", "values *= np.exp(2.0 * shift[q])",
           "diagnosis/test_derivatives.py diagnosis/test_predict.py diagnosis/test_recovery.py"),
    # The jumping leg.
    Mutant("height by v^2 / g", '"clearance": v**2 / (2.0 * leg.gravity)', '"clearance": v**2 / leg.gravity',
           "hopper/test_sweep.py"),
    Mutant("only one side's tolerances", "up = np.sqrt((np.maximum(change, 0.0).max(axis=0) ** 2).sum(axis=1))",
           "up = np.sqrt((np.minimum(change, 0.0).max(axis=0) ** 2).sum(axis=1))",
           "hopper/test_sweep.py"),
    Mutant("a cantilever twice as stiff", "PRB_GAMMA * PRB_STIFFNESS * self.bending_stiffness / length",
           "2.0 * PRB_GAMMA * PRB_STIFFNESS * self.bending_stiffness / length",
           "hopper/test_jump_gap.py hopper/test_sweep.py"),
    # Files.
    Mutant("measured angles mirrored", "return self.zero + self.sign * rotation",
           "return self.zero - self.sign * rotation", "swing/test_leg_model.py"),
)  # fmt: skip


@dataclass(frozen=True)
class Verdict:
    """Result of the tests on one mutant; ``message`` : the first failure."""

    mutant: Mutant
    file: str
    caught: bool
    seconds: float
    message: str


def file_of(mutant: Mutant, root: Path = ROOT) -> Path:
    """The only source file that contains the mutant's text.

    Raises
    ------
    ValueError : the text occurs in no file, or more than once.
    """
    found = [path for tree in ("synth", "cad", "reports") for path in sorted((root / tree).rglob("*.py"))]
    found = [path for path in found if "planting" not in path.parts]  # an independent engine, for tests
    counts = {path: path.read_text(encoding="utf-8").count(mutant.text) for path in found}
    holding = {path: count for path, count in counts.items() if count}
    if sum(holding.values()) != 1:
        raise ValueError(f"{mutant.name}: its text stands {sum(holding.values())} times in the sources: {mutant.text}")
    return next(iter(holding))


def _copied(copy: Path) -> Path:
    """A copy of what the tests need of the repository."""
    shutil.rmtree(copy, ignore_errors=True)
    copy.mkdir(parents=True)
    for name in COPIED:
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, copy / name, symlinks=True, ignore=shutil.ignore_patterns("__pycache__"))
        elif source.exists():
            shutil.copy(source, copy / name)
    return copy


def _failure(tests: str, words: str, copy: Path) -> str:
    """The first failure of these tests in a copy of the repository; empty if all pass."""
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-n", "0", "-p", "no:cacheprovider"]
    command += [f"tests/{place}" for place in tests.split()]
    command += ["-k", words] if words else []
    environment = {**os.environ, "PYTHONPATH": str(copy), "SYNTH_THREADS": "1", "PYTHONDONTWRITEBYTECODE": "1"}
    try:
        ended = subprocess.run(
            command, cwd=copy, env=environment, capture_output=True, text=True, timeout=LONGEST, check=False
        )
    except subprocess.TimeoutExpired:
        return f"longer than {LONGEST:g} s"
    if ended.returncode not in (0, 1):  # 1: tests failed; any other status is a broken run
        raise RuntimeError(f"tests {tests}: pytest ended with {ended.returncode}\n{ended.stdout[-2000:]}")
    lines = ended.stdout.splitlines()
    return next((line for line in lines if line.startswith(("FAILED", "ERROR"))), "failed") if ended.returncode else ""


def check_unchanged(mutants: Sequence[Mutant], folder: Path, workers: int) -> None:
    """Run each mutant's tests on an unchanged copy: only tests that pass there can catch a mutant.

    Raises
    ------
    RuntimeError : a test fails without a mutant.
    """
    copy = _copied(folder / "unchanged")
    wanted = sorted({(mutant.tests, mutant.words) for mutant in mutants})
    with ThreadPoolExecutor(workers) as pool:
        for (tests, _), message in zip(
            wanted, pool.map(lambda one: _failure(one[0], one[1], copy), wanted), strict=True
        ):
            if message:
                raise RuntimeError(f"the tests {tests} fail without a mutant: {message}")
    shutil.rmtree(copy)


def judge(mutant: Mutant, folder: Path) -> Verdict:
    """Apply the mutant to a copy of the repository in ``folder``, and run its tests there."""
    copy = _copied(folder / f"mutant-{hash(mutant) & 0xFFFFFFFF:08x}")
    target = file_of(mutant, copy)
    target.write_text(target.read_text(encoding="utf-8").replace(mutant.text, mutant.changed), encoding="utf-8")
    begun = time.perf_counter()
    message = _failure(mutant.tests, mutant.words, copy)
    shutil.rmtree(copy)
    return Verdict(mutant, str(target.relative_to(copy)), bool(message), time.perf_counter() - begun, message)


def main(words: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--to", type=Path, default=ROOT / "build" / "mutants")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--only", default="", help="names that hold this text")
    asked = parser.parse_args(words)
    chosen = [mutant for mutant in MUTANTS if asked.only in mutant.name]
    for mutant in chosen:
        file_of(mutant)  # before anything runs
    asked.to.mkdir(parents=True, exist_ok=True)
    check_unchanged(chosen, asked.to, asked.workers)
    with ThreadPoolExecutor(asked.workers) as pool:
        verdicts = []
        for verdict in pool.map(lambda mutant: judge(mutant, asked.to), chosen):
            verdicts.append(verdict)
            print(f"{'caught  ' if verdict.caught else 'SURVIVED'} {verdict.seconds:5.0f} s  {verdict.mutant.name}")
    with (asked.to / "mutants.csv").open("w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream)
        table.writerow(["mutant", "file", "caught", "test run time [s]", "first failure"])
        for v in verdicts:
            table.writerow([v.mutant.name, v.file, v.caught, round(v.seconds, 1), v.message])
    share = sum(v.caught for v in verdicts) / len(verdicts)
    print(f"{sum(v.caught for v in verdicts)} of {len(verdicts)} mutants are caught ({share:.0%}; wanted {WANTED:.0%})")
    return 0 if share >= WANTED else 1


if __name__ == "__main__":
    sys.exit(main())
