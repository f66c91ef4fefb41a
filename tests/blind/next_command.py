"""Benefit of a suggested command over a chirp: ``make blind-next``.

Servo-driven legs as of ``blind.servos``, one main cause each, known from two short logs of small slow sines about a
pose; a third one scores. The project states what the next command may ask: angles, speed and torque of each joint, and
its length. The rig is diagnosed. It counts if that leaves its user with a question: the verdict is a tie or unknown,
and does not name the main cause alone (with nothing but causes that act alike beside it). Then the command that the
diagnosis asks for is played on the true rig and added to its logs, and on a copy of it a chirp of the same length, rate
and limits. Both are diagnosed again: how often is the main cause named, alone and rightly?
"""

from __future__ import annotations

import json
import math
import shutil
import sys
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from blind import run
from blind.asked import Asked
from blind.chance import bootstrap, wilson
from blind.servo_engine import Array, Rig, follow, shown_as
from blind.servos import (
    ATTEMPTS,
    DOMINATES,
    LIBRARY,
    MASS_TOLERANCE,
    RATE,
    SMALL,
    SMALL_ONES,
    VARIED,
    Absorbed,
    NotApplicable,
    Setup,
    _alike,
    _level,
    _setup,
    _sized,
    _write,
)
from blind.views import View, read_views
from synth.diagnosis.plants.swinging_chain import command_menu, command_shapes

LOGS = 3  # of small slow sines about a pose, the last of which only scores
KNOWN = 0.8  # s of a known log
SLOW = (0.3, 0.8)  # Hz
SWING = (0.05, 0.15)  # rad, about a pose
# Rad RMS of a servo's own encoder (4096 counts a turn: 4.4e-4), and the main cause in floors of the chirp's log. A
# comparison needs rigs that a chirp does not tell: of 3 to 12 floors a chirp of 3 s named four of five.
FLOOR = (3e-4, 8e-4)
MAIN = (1.5, 5.0)
LENGTH = 1.0  # s of the next command
ANGLE = 0.4  # rad to either side that it may take
SPEED = 6.0  # rad/s, the free speed of the slowest motors drawn
TORQUE = 6.0  # times what holds the leg level: the stall torque of the strongest motors drawn
KEPT = 1.1  # times a limit that the true rig's motion may reach: the limits are kept by the designed one
AWAY = "log_next.csv"
WAYS = ("chirp", "suggested")


class Few(Setup):
    """A setup of which the last log alone scores."""

    @property
    def times(self) -> Array:
        """(m,) s."""
        return np.arange(len(self.commands[0])) / RATE

    @property
    def held_out(self) -> range:
        """Places of the logs that only score."""
        return range(len(self.commands) - 1, len(self.commands))


@dataclass(frozen=True)
class Case:
    """A rig: its name, the known logs, the truth, the encoder's floor (rad RMS), and the main cause.

    ``alone`` : with the main cause only; ``rich`` : varied logs, by which other causes are told from it.
    """

    name: str
    setup: Few
    rig: Rig
    floor: float
    whole: Array
    main: tuple[str, int]
    alone: Rig
    rich: Setup

    def is_right(self, key: Sequence[str]) -> bool:
        """Whether a cause is the main one, or acts alike in varied logs."""
        effect, joint = key[0], self.labels.index(key[1]) if key[1] in self.labels else -1
        if (effect, joint) in shown_as(*self.main, len(self.rig.joints)):
            return True
        varied = Setup(self.rich.design, self.rich.supply, self.rich.commands[:VARIED])
        at_rest = varied.moved(varied.design)
        target, absorbed = varied.moved(self.alone), Absorbed.of(varied, at_rest)
        asked = ("voltage_sag", 0) if joint < 0 else (effect, joint)  # of a whole leg's causes it has this one
        return asked in _alike(varied, at_rest, target, [self.main], absorbed, [asked])

    @property
    def labels(self) -> list[str]:
        """Names of the joints."""
        return [f"joint{k + 1}" for k in range(len(self.rig.joints))]


def made(seed: int, number: int, effect: str) -> Case:
    """The case of a number; the same whenever it is made."""
    rng = np.random.default_rng([seed, number, 0x4E])
    for _ in range(ATTEMPTS):
        try:
            return _attempt(rng, f"next_{seed}_{number:03d}", effect)
        except (NotApplicable, FloatingPointError):
            continue
    raise RuntimeError(f"{effect}: no rig in {ATTEMPTS} attempts")


def _attempt(rng: np.random.Generator, name: str, effect: str) -> Case:
    """A main cause that the chirp shows, and three small ones, sized on varied logs as in ``blind.servos``.

    The main cause takes at least half of the known logs' gap: what they do not show, nobody can ask for.
    """
    rich = _setup(rng)
    n, floor = len(rich.design.joints), math.exp(rng.uniform(*np.log(FLOOR)))
    level, still = floor * math.exp(rng.uniform(*np.log(MAIN))), rich.moved(rich.design)
    setup = Few(rich.design, rich.supply, tuple(_slow(rng, n) for _ in range(LOGS)))
    shown = Few(rich.design, rich.supply, (_fine(*chirp_of(setup)),))
    at_rest = shown.moved(shown.design)
    j, change = int(rng.integers(0, n)), LIBRARY[effect]
    rig = change(rich.design, j, _sized(shown, at_rest, change, j, level, Absorbed.of(shown, at_rest)))
    alone = rig
    for small in rng.permutation(sorted(set(LIBRARY) - {effect})).tolist()[:SMALL_ONES]:
        k, part = int(rng.integers(0, n)), level * math.exp(rng.uniform(*np.log(SMALL)))
        try:
            rig = LIBRARY[small](rig, k, _sized(rich, still, LIBRARY[small], k, part))
        except NotApplicable:
            continue
    k = int(rng.integers(0, n))
    off = float(rng.choice([-1.0, 1.0]) * rng.uniform(0.0, 2.0))
    rig = rig.changed(k, mass=float(rig.joints[k, 1]) * (1.0 + off * MASS_TOLERANCE))
    known, whole, part = setup.moved(setup.design), setup.moved(rig), setup.moved(alone)
    absorbed = Absorbed.of(setup, known)
    if absorbed.rest(whole - part) > DOMINATES * absorbed.rest(whole - known):
        raise NotApplicable("no main cause in the known logs")
    return Case(name, setup, rig, floor, whole, (effect, j), alone, rich)


def _slow(rng: np.random.Generator, n: int) -> Array:
    t = np.arange(0.0, KNOWN, 1.0 / RATE)
    made = [
        rng.uniform(-0.5, 0.5) * ANGLE + rng.uniform(*SWING) * np.sin(2.0 * np.pi * rng.uniform(*SLOW) * t)
        for _ in range(n)
    ]
    return np.stack(made, axis=1)


def _fine(time: Array, command: Array) -> Array:
    """(m, n) rad: a command held from sample to sample, at the rate of the known logs."""
    return np.repeat(command, round(RATE * (time[1] - time[0])), axis=0)


def limits_of(setup: Setup) -> dict[str, dict[str, str]]:
    """``limits:`` of the next command, joint by joint."""
    return {
        f"joint{j + 1}": {
            "lowest": f"{-ANGLE} rad",
            "highest": f"{ANGLE} rad",
            "speed": f"{SPEED} rad/s",
            "torque": f"{TORQUE * _level(setup.design, j):.6g} N*m",
        }
        for j in range(len(setup.design.joints))
    }


def chirp_of(setup: Setup) -> tuple[Array, Array]:
    """Times (m,) s and the chirp (m, n) rad of the menu: as large and as fast as the design keeps the limits."""
    n, time = len(setup.design.joints), np.arange(0.0, LENGTH, 1.0 / command_shapes.COMMAND_RATE)
    wave = np.asarray(command_shapes.chirp(time, 2.0 * ANGLE / SPEED))
    command = ANGLE * np.stack([wave] * n, axis=1)
    for _ in range(command_menu.MOST_SHRINKS):
        over = max(reached(setup, setup.design, time, command))
        if over <= 1.0:
            break
        command = command * max(command_menu.LIMIT_MARGIN / over, 0.5)
    return time, command


def reached(setup: Setup, rig: Rig, time: Array, command: Array) -> tuple[float, float]:
    """Largest speed and torque of a rig that follows a command, over their limits."""
    moved = follow(rig, time, command, setup.supply)
    speed = np.gradient(moved, time, axis=0)
    p = rig.joints
    duty = np.clip(p[:, 4] * (command - moved) - p[:, 5] * speed, -p[:, 6], p[:, 6])
    current = np.clip((duty * setup.supply - p[:, 7] * speed) / p[:, 8], -p[:, 9], p[:, 9])
    most = [TORQUE * _level(setup.design, j) for j in range(len(p))]
    return float(np.abs(speed).max()) / SPEED, float((np.abs(p[:, 7] * current).max(axis=0) / most).max())


def chirp(case: Case) -> tuple[Array, Array]:
    """The chirp of a case."""
    return chirp_of(case.setup)


def suggested(folder: Path) -> tuple[Array, Array] | None:
    """The command that a diagnosis suggests; None if it suggests none."""
    path = folder / "next_command.csv"
    if not path.is_file():
        return None
    table = np.atleast_2d(np.genfromtxt(path, delimiter=",", skip_header=1))
    return table[:, 0], np.radians(table[:, 1:])


def played(case: Case, told: tuple[Array, Array], of: Path, to: Path) -> None:
    """A copy of the case's folder with the log of this command among the training logs."""
    time, command = told
    moved = follow(case.rig, time, command, case.setup.supply)
    if not np.all(np.isfinite(moved)):
        raise NotApplicable("the rig runs away")
    shutil.copytree(of, to)
    rng = np.random.default_rng([*case.name.encode(), 0x4F])
    read = moved + case.floor * rng.standard_normal(moved.shape)
    header = ",".join(["time [s]", *[f"{x} [deg]" for x in case.labels], *[f"{x} command [deg]" for x in case.labels]])
    np.savetxt(to / AWAY, np.column_stack([time, np.degrees(read), np.degrees(command)]), "%.7g", ",",
               header=header, comments="")  # fmt: skip
    project = to / "gap.yaml"
    lines = [line for line in project.read_text().splitlines() if not line.startswith('"next_command"')]
    lines.insert(lines.index("trials:") + 1, f"  - {AWAY}")
    short = '"next_command": {"length": "0.5 s"}'  # what comes after is not asked, and costs little
    project.write_text("\n".join([*lines, short]) + "\n")


def causes(seed: int, count: int) -> list[str]:
    """The main cause of each case: every one in turn, in random order."""
    rng, found = np.random.default_rng([seed, 0x4E]), []
    while len(found) < count:
        found += rng.permutation(sorted(LIBRARY)).tolist()
    return found[:count]


def named(view: View, is_right: Callable[[Sequence[str]], bool]) -> bool:
    """Whether the verdict names the right cause first, and no tied explanation does without it."""
    if view.verdict not in ("effect", "tie") or not is_right(view.first[0]):
        return False
    return all(any(is_right(key) for key in keys) for keys in view.tied)


def is_open(view: View, is_right: Callable[[Sequence[str]], bool]) -> bool:
    """Whether a diagnosis leaves its user with a question: a single wrong answer does not, nor does no gap."""
    return view.verdict in ("tie", "unknown") and not named(view, is_right)


def table(said: Mapping[str, Mapping[str, bool]]) -> dict[str, Any]:
    """Share of rightly named causes of each way, with its 90 % interval, and the points gained over the chirp.

    ``said`` : case -> way -> whether the right cause is named; of the cases that a further log was recorded of. The
    interval of the gain is of pairs: both ways are tried on the same rigs.
    """
    counted = [each for each in said.values() if set(WAYS) <= set(each)]
    if not counted:
        return {"of": 0}
    shares: dict[str, Any] = {}
    for way in ("before", *WAYS):
        hits = [each[way] for each in counted]
        low, high = wilson(sum(hits), len(hits))
        shares[way] = {"right": sum(hits), "of": len(hits), "share": sum(hits) / len(hits), "interval90": [low, high]}
    pairs = np.array([[float(each[way]) for way in WAYS] for each in counted])
    low, high = bootstrap(pairs, lambda rows: 100.0 * float(np.mean(rows[:, 1] - rows[:, 0])))
    gained = 100.0 * (shares["suggested"]["share"] - shares["chirp"]["share"])
    return shares | {"points_over_chirp": gained, "points_interval90": [low, high]}


def followed_up(case: Case, asked: Asked, program: run.Program) -> dict[str, View]:
    """Diagnoses of a case before, with the chirp's log and with the suggested command's; finished ones are reused.

    Without the latter two if the first leaves nothing open.
    """
    folder = asked.folder / "cases" / case.name
    if not folder.exists():
        rng = np.random.default_rng([*case.name.encode(), 0x50])
        _write(rng, case.setup, case.whole, case.floor, case.labels, folder)
        wanted = {"next_command": {"length": f"{LENGTH} s", "limits": limits_of(case.setup)}}
        project = folder / "gap.yaml"
        project.write_text(project.read_text() + json.dumps(wanted)[1:-1] + "\n")
    views: dict[str, View] = {}
    for way in ("before", *WAYS):
        place, out, told = asked.folder / way / case.name, _out(asked, program, way), told_by(case, way, asked, program)
        if way != "before" and told is None:
            views[way] = views["before"]  # no command is suggested, so nothing is gained
            continue
        if told is not None:
            shutil.rmtree(place, ignore_errors=True)
            played(case, told, folder, place)
        out.mkdir(parents=True, exist_ok=True)
        if not (out / case.name / "gap.json").is_file():
            run.diagnose(folder if told is None else place, out / case.name, [asked.answers.parent], program)
        views[way] = read_views(out, [case.name])[case.name]
        if way == "before" and not is_open(views[way], case.is_right):
            break
    return views


def told_by(case: Case, way: str, asked: Asked, program: run.Program) -> tuple[Array, Array] | None:
    """The command of a way; None if there is none."""
    if way == "before":
        return None
    return chirp(case) if way == "chirp" else suggested(_out(asked, program, "before") / case.name)


def limits_reached(case: Case, way: str, asked: Asked, program: run.Program) -> dict[str, list[float]]:
    """Largest speed and torque of the true rig over their limits."""
    told = told_by(case, way, asked, program)
    return {} if told is None else {"reached": [round(x, 2) for x in reached(case.setup, case.rig, *told)]}


def _out(asked: Asked, program: run.Program, way: str) -> Path:
    return asked.folder / f"diagnosed-{program.digest[:12]}" / way


def tried(number: int, effect: str, asked: Asked, program: run.Program) -> tuple[str, dict[str, Any], dict[str, bool]]:
    """A case's name, what was said of it, and whether each way names its cause."""
    case = made(asked.seed, number, effect)
    views = followed_up(case, asked, program)
    right = {way: named(view, case.is_right) for way, view in views.items()}
    found: dict[str, Any] = {"main": case.main}
    for way, view in views.items():
        found[way] = {"first": list(view.first[0]), "verdict": view.verdict, "named": right[way]}
        found[way] |= {"tied": len(view.tied)} | limits_reached(case, way, asked, program)
    return case.name, found, right


def main(words: Sequence[str] | None = None) -> int:
    """Make, diagnose, play, diagnose again, case by case; the table of all so far is written after each."""
    asked = Asked.of(words, "blind.next_command", __doc__)
    asked.folder.mkdir(parents=True, exist_ok=True)
    asked.answers.parent.mkdir(exist_ok=True)
    program = run.snapshot(asked.folder)
    said: dict[str, dict[str, bool]] = {}
    cases: dict[str, Any] = {}
    text = ""
    with ProcessPoolExecutor(asked.workers) as pool:
        planned = enumerate(causes(asked.seed, asked.count))
        waiting = [pool.submit(tried, number, effect, asked, program) for number, effect in planned]
        for future in as_completed(waiting):
            name, cases[name], said[name] = future.result()
            document = {"format": "synth/blind-next/2", "seed": asked.seed, "program": program.digest}
            document |= {"rigs": len(cases), "named_at_once": sum(each["before"] for each in said.values())}
            text = json.dumps({**document, **table(said), "cases": dict(sorted(cases.items()))}, indent=1)
            (asked.to / "blind-next.json").write_text(text + "\n")
            print(name, json.dumps(cases[name]), file=sys.stderr, flush=True)  # noqa: T201
    print(text)  # noqa: T201
    return 0


if __name__ == "__main__":
    sys.exit(main())
