"""Time of ``synth gap``: the whole command, its parts, and by the number of trials and of effects.

``PYTHONPATH=tests python -m bench.bench_gap [SECTION.json]``. Everything the command compiles is on disk before.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from bench import thesis_leg as thesis
from bench.gap_case import pendulum, write_project
from bench.results import Curve, Figure, Goal, Section, Table, load, run_alone, say
from synth.diagnosis import next_experiment, score, screening, workbench
from synth.diagnosis.plants.swinging_chain import chain_candidates, chain_predictor
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.estimation.linearisation import LinearisedNormal
from synth.files.gap_project import GapProject, read_gap_project
from synth.parts.catalogs import Catalogue
from synth.parts.resolver import resolver
from synth.swing.chain import Chain
from synth.swing.effects import Effect, registered
from synth.threads import core_count

TEN_TRIALS, PENDULUM = 5.0, 1.5  # s, targets
REPEATS = 3
COUNTS = (3, 5, 10, 20)


def command(project: Path, repeats: int = REPEATS) -> tuple[float, float]:
    """Median seconds on the wall and of processors of the command, after one run that does not count.

    That run compiles the bytecode, as an installation does; otherwise 0.4 s of each run would be that.
    """
    spent = []
    with tempfile.TemporaryDirectory() as folder:
        installed = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
        installed["PYTHONPYCACHEPREFIX"] = str(Path(folder) / "bytecode")
        for turn in range(repeats + 1):
            before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
            arguments = ["gap", str(project), "--out", str(Path(folder) / f"out{turn}")]
            called = [sys.executable, "-m", "synth", *arguments]
            subprocess.run(called, check=True, capture_output=True, env=installed)
            wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
            if turn:
                cores = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
                spent.append((wall, cores))
    walls, cores_ = zip(*spent, strict=True)
    found = sorted(walls)[repeats // 2], sorted(cores_)[repeats // 2]
    say(f"{project.parent.name}: {found[0]:.2f} s, processors {found[1]:.2f} s, load {load():.1f}")
    return found


def read(project: Path) -> GapProject:
    """The project as the command reads it."""
    return read_gap_project(project, resolve_part=resolver(Catalogue.load()))


def diagnosis(project: GapProject) -> tuple[float, float]:
    """Seconds on the wall and of processors of the diagnosis alone."""
    start, worked = time.perf_counter(), time.process_time()
    diagnose(project.leg, project.trials, project.tolerance, seed=project.seed)
    return time.perf_counter() - start, time.process_time() - worked


@contextmanager
def only(effects: Sequence[Effect]) -> Iterator[None]:
    """Let only these effects take part; all stay in the compiled chain."""
    seen = chain_candidates.registered
    chain_candidates.registered = lambda: tuple(effects)  # type: ignore[assignment]
    try:
        yield
    finally:
        chain_candidates.registered = seen  # type: ignore[assignment]


def by_effects(project: GapProject) -> list[tuple[float, float]]:
    """(candidates: effects times joints, processor seconds) for growing shares of the library, each other one first."""
    library = registered()
    order = [*library[::2], *library[1::2]]
    found = []
    for count in (4, 8, 14, len(library)):
        with only(order[:count]):
            places = sum(1 if effect.where == "base" else len(project.leg.joints) for effect in order[:count])
            found.append((float(places), diagnosis(project)[1]))
        say(f"{count} effects: {found[-1][1]:.2f} s of processors")
    return found


class Shares:
    """Processor seconds by function, without the functions that it calls."""

    def __init__(self) -> None:
        self.spent: dict[str, float] = defaultdict(float)
        self.calls: dict[str, int] = defaultdict(int)
        self._inner = [0.0]

    def timed(self, function: Callable[..., Any], name: str | Callable[..., str]) -> Callable[..., Any]:
        """The function with its own time taken under a name, or under one made from its arguments."""

        def call(*arguments: Any, **named: Any) -> Any:
            self._inner.append(0.0)
            start = time.thread_time()
            try:
                return function(*arguments, **named)
            finally:
                total = time.thread_time() - start
                key = name if isinstance(name, str) else name(*arguments)
                self.spent[key] += total - self._inner.pop()
                self.calls[key] += 1
                self._inner[-1] += total

        return call


def where_it_goes(project: GapProject) -> list[tuple[str, int, float, float]]:
    """(what, calls, processor seconds, share) of a diagnosis on one thread."""
    shares, put_back = Shares(), []

    def put(owner: Any, name: str, label: str | Callable[..., str]) -> None:
        # Methods of a class stand in it or in one that it inherits from.
        owner = next(each for each in getattr(owner, "__mro__", (owner,)) if name in vars(each))
        put_back.append((owner, name, vars(owner)[name]))
        setattr(owner, name, shares.timed(getattr(owner, name), label))

    def one_thread(function: Callable[[int], Any], count: int, most: int | None = None) -> list[Any]:
        return [function(i) for i in range(count)]

    for module in (workbench, screening, score, next_experiment):
        if hasattr(module, "in_parallel"):
            put_back.append((module, "in_parallel", module.in_parallel))
            module.in_parallel = one_thread  # type: ignore[attr-defined]
    label = ["integrator"]
    run = Chain.run

    def run_labelled(self: Chain, *arguments: Any, **named: Any) -> Any:
        for which in ("_plain", "_whole", "_rubbing"):
            integrate, *called = getattr(self, which)
            if not getattr(integrate, "timed", False):
                put_back.append((None, self, (which, (integrate, *called))))
                timed = shares.timed(integrate, lambda *_: label[0])
                timed.timed = True  # type: ignore[attr-defined]
                self.__dict__[which] = (timed, *called)
        return run(self, *arguments, **named)

    inner = chain_predictor.Predictor._together

    def together(self: Any, trial: Any, groups: Any, kept: Any) -> Any:
        label[0] = _kind(groups[0][0].hypothesis)
        return inner(self, trial, groups, kept)

    put_back += [(Chain, "run", run), (chain_predictor.Predictor, "_together", inner)]
    Chain.run = run_labelled  # type: ignore[method-assign]
    chain_predictor.Predictor._together = together  # type: ignore[method-assign]
    put(Chain, "run", "lanes into the compiled code and out")
    put(Chain, "lanes", "writing lanes")
    put(chain_predictor.Predictor, "_together", "legs, effects and readings around a lane group")
    put(chain_predictor.Predictor, "predict", "packing lane groups")
    put(workbench.Workbench, "residuals", "residuals")
    put(workbench.Workbench, "evaluate", "derivatives from lanes, whitening")
    put(LinearisedNormal, "steps", "steps of Levenberg-Marquardt")
    put(workbench.Workbench, "_parts", "frames: derivatives by tolerances and states")
    put(screening.ScreeningFrame, "left", "promises of starts")
    whole = shares.timed(diagnose, "everything else")
    try:
        whole(project.leg, project.trials, project.tolerance, seed=project.seed)
    finally:
        for owner, name, value in reversed(put_back):
            if owner is None:
                name.__dict__[value[0]] = value[1]
            else:
                setattr(owner, name, value)
    total = sum(shares.spent.values())
    rows = [(name, shares.calls[name], spent, spent / total) for name, spent in shares.spent.items()]
    return sorted(rows, key=lambda row: -row[2])


def _kind(hypothesis: Sequence[Any]) -> str:
    ways = {"memory" if c.effect.memory else c.effect.way for c in hypothesis}
    for way, words in (
        ("structure", "one link more"), ("memory", "friction, hysteresis or backlash"), ("torque", "other torques"),
        ("reading", "sensor"), ("leg", "the leg's numbers"),
    ):  # fmt: skip
        if way in ways:
            return f"integrator: {words}"
    return "integrator: nothing missing"


def section() -> Section:
    """The command on ten trials and on a pendulum, where its time goes, and what it costs by size."""
    before = load()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        legs = {
            count: write_project(thesis.leg(), count, folder / f"leg of three links, {count} trials")
            for count in COUNTS
        }
        swing = write_project(pendulum(), 6, folder / "pendulum, 6 trials")
        ten, alone = command(legs[10]), command(swing)
        rows = [("three links, ten trials", *ten), ("pendulum, six trials", *alone)]
        ten_read = read(legs[10])
        diagnosis(ten_read)
        by_trials = [(float(count), *diagnosis(read(legs[count]))) for count in COUNTS]
        effects = by_effects(ten_read)
        shares = where_it_goes(ten_read)
    return Section(
        "Gap: from trials to a verdict",
        words=(
            "The three-link leg of the thesis with 0.012 N·m of dry friction at its knee that the design, off by its "
            "tolerances, lacks; 1 s, 501 samples, 0.1° of noise; a fifth of the trials held out. The whole command "
            "from the shell, report included, its compiled code on disk. Median of "
            f"{REPEATS} runs; {core_count()} cores.",
            f"Load (1 min) before {before:.1f}, after {load():.1f}: on a busy machine the wall is longer than the "
            "command needs, its processors' seconds hardly.",
        ),
        goals=(
            Goal("three links, ten trials, on the wall", ten[0], "at most", TEN_TRIALS, "s"),
            Goal("pendulum, on the wall", alone[0], "at most", PENDULUM, "s"),
        ),
        tables=(
            Table(
                "The whole command",
                ("what", "wall, s", "processors, s"),
                [(w, round(a, 2), round(b, 2)) for w, a, b in rows],
            ),
            Table(
                "Where the diagnosis of ten trials spends its time, on one thread",
                ("what", "calls", "processor, s", "share, %"),
                [(w, n, round(s, 2), round(100 * share, 1)) for w, n, s, share in shares],
                note="Each without what it calls.",
            ),
        ),
        figures=(
            Figure("By trials", "trials", "s, diagnosis alone", (
                Curve("processors", [(n, cores) for n, _, cores in by_trials]),
                Curve("wall", [(n, wall) for n, wall, _ in by_trials]),
            )),
            Figure("By effects", "effects × joints", "s of processors", (Curve("diagnosis of ten trials", effects),)),
        ),
    )  # fmt: skip


if __name__ == "__main__":
    run_alone(section)
