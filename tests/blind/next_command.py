"""Benefit of a suggested command over a chirp: ``make blind-next``.

Servo-driven legs as of ``blind.servos``, one main cause each, of which only three short logs of slow sines are known.
Each is diagnosed. Where that already names the cause alone, nothing is left to tell and the rig does not count. Else
the command that the diagnosis asks for is played on the true rig and added to its logs, and a chirp of the same length,
rate and limits on a copy of it. Both are diagnosed again: how often is the main cause named first?
"""

from __future__ import annotations

import json
import math
import shutil
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from blind import run
from blind.asked import Asked
from blind.chance import wilson
from blind.servo_engine import Array, Rig, follow
from blind.servos import (
    ATTEMPTS,
    FLOOR,
    LIBRARY,
    MAIN,
    MASS_TOLERANCE,
    RATE,
    SMALL,
    VARIED,
    Absorbed,
    NotApplicable,
    Setup,
    _alike,
    _setup,
    _sized,
    _write,
)
from blind.views import View, read_views
from synth.diagnosis.plants.swinging_chain import command_menu

LOGS = 3  # of slow sines, the last of which only scores
KNOWN = 0.8  # s of a known log: with 4 s every cause was named at once (next_6000_000 and _001)
SLOW = (0.3, 0.8)  # Hz
SWING = (0.3, 0.6)  # rad
SMALL_ONES = 3  # beside the main cause, as in ``blind.servos``
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
    """A rig: its name, the known logs, the truth, the encoder's floor (rad RMS) and the causes to name."""

    name: str
    setup: Few
    rig: Rig
    floor: float
    whole: Array
    right: list[list[str]]

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
    """A main cause that the known logs show, and three small ones, sized on varied logs as in ``blind.servos``.

    What only commands beyond the known ones' limits show, as a torque limit that none of them reaches, nobody can ask
    for.
    """
    rich = _setup(rng)
    n, floor = len(rich.design.joints), math.exp(rng.uniform(*np.log(FLOOR)))
    level, still = floor * math.exp(rng.uniform(*np.log(MAIN))), rich.moved(rich.design)
    setup = Few(rich.design, rich.supply, tuple(_slow(rng, n) for _ in range(LOGS)))
    known = setup.moved(setup.design)
    j, change = int(rng.integers(0, n)), LIBRARY[effect]
    rig = change(rich.design, j, _sized(setup, known, change, j, level, Absorbed.of(setup, known)))
    main = [(effect, j)]
    varied = Setup(rich.design, rich.supply, rich.commands[:VARIED])
    at_rest = varied.moved(rich.design)
    alike = _alike(varied, at_rest, varied.moved(rig), main, Absorbed.of(varied, at_rest))
    for small in rng.permutation(sorted(set(LIBRARY) - {effect})).tolist()[:SMALL_ONES]:
        k, part = int(rng.integers(0, n)), level * math.exp(rng.uniform(*np.log(SMALL)))
        try:
            rig = LIBRARY[small](rig, k, _sized(rich, still, LIBRARY[small], k, part))
        except NotApplicable:
            continue
    k = int(rng.integers(0, n))
    off = float(rng.choice([-1.0, 1.0]) * rng.uniform(0.0, 2.0))
    rig = rig.changed(k, mass=float(rig.joints[k, 1]) * (1.0 + off * MASS_TOLERANCE))
    right = [[word, f"joint{k + 1}"] for word, k in [*main, *alike]]
    return Case(name, setup, rig, floor, setup.moved(rig), right)


def _slow(rng: np.random.Generator, n: int) -> Array:
    t = np.arange(0.0, KNOWN, 1.0 / RATE)
    return np.stack([rng.uniform(*SWING) * np.sin(2.0 * np.pi * rng.uniform(*SLOW) * t) for _ in range(n)], axis=1)


def chirp(case: Case) -> tuple[Array, Array]:
    """Times (m,) s and the chirp (m, n) rad of the menu within the limits of the known commands."""
    known = case.setup.commands
    speed = [np.percentile(np.abs(np.diff(each, axis=0)) * RATE, 98, axis=0) for each in known]
    limits = command_menu.CommandLimits(
        np.min([each.min(axis=0) for each in known], axis=0),
        np.max([each.max(axis=0) for each in known], axis=0),
        np.max(speed, axis=0),
    )
    time = np.arange(0.0, command_menu.LENGTH, 1.0 / command_menu.RATE)
    columns = [command_menu._within(command_menu._chirp, time, limits, j) for j in range(len(case.rig.joints))]
    return time, np.stack(columns, axis=1)


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
    project.write_text(project.read_text().replace("trials:\n", f"trials:\n  - {AWAY}\n", 1))


def causes(seed: int, count: int) -> list[str]:
    """The main cause of each case: every one in turn, in random order."""
    rng, found = np.random.default_rng([seed, 0x4E]), []
    while len(found) < count:
        found += rng.permutation(sorted(LIBRARY)).tolist()
    return found[:count]


def named(view: View, right: Sequence[Sequence[str]]) -> bool:
    """Whether the verdict names a cause, and the right one first."""
    return view.verdict in ("effect", "tie") and list(view.first[0]) in [list(key) for key in right]


def table(answers: Mapping[str, Mapping[str, Any]], views: Mapping[str, Mapping[str, View]]) -> dict[str, Any]:
    """Share of rightly named causes of each way, with its 90 % interval, and the points gained over the chirp.

    Of the rigs that a further log was recorded of.
    """
    shares: dict[str, Any] = {}
    counted = {name: answer for name, answer in answers.items() if name in views["chirp"]}
    if not counted:
        return {"of": 0}
    for way, seen in views.items():
        hits = [named(seen[name], answer["right"]) for name, answer in counted.items()]
        low, high = wilson(sum(hits), len(hits))
        shares[way] = {"right": sum(hits), "of": len(hits), "share": sum(hits) / len(hits), "interval90": [low, high]}
    return shares | {"points_over_chirp": 100.0 * (shares["suggested"]["share"] - shares["chirp"]["share"])}


def open_still(view: View, right: Sequence[Sequence[str]]) -> bool:
    """Whether a further log has something to tell: the right cause is not named alone."""
    return not (view.verdict == "effect" and named(view, right))


def followed_up(case: Case, asked: Asked, program: run.Program) -> dict[str, View]:
    """Diagnoses of a case before, with the chirp's log and with the suggested command's; finished ones are reused.

    Without the latter two if the first already names the cause alone.
    """
    folder = asked.folder / "cases" / case.name
    if not folder.exists():
        rng = np.random.default_rng([*case.name.encode(), 0x50])
        _write(rng, case.setup, case.whole, case.floor, case.labels, folder)
    views: dict[str, View] = {}
    for way in ("before", *WAYS):
        place, out = asked.folder / way / case.name, asked.folder / f"diagnosed-{program.digest[:12]}" / way
        told = (
            None if way == "before" else chirp(case) if way == "chirp" else suggested(out.parent / "before" / case.name)
        )
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
        if way == "before" and not open_still(views[way], case.right):
            break
    return views


def main(words: Sequence[str] | None = None) -> int:
    """Make, diagnose, play, diagnose again, case by case; the table of all so far is written after each."""
    asked = Asked.of(words, "blind.next_command", __doc__)
    asked.folder.mkdir(parents=True, exist_ok=True)
    asked.answers.parent.mkdir(exist_ok=True)
    program = run.snapshot(asked.folder)
    answers: dict[str, dict[str, Any]] = {}
    views: dict[str, dict[str, View]] = {way: {} for way in ("before", *WAYS)}
    cases: dict[str, Any] = {}
    text = ""
    for number, effect in enumerate(causes(asked.seed, asked.count)):
        case = made(asked.seed, number, effect)
        answers[case.name] = {"right": case.right}
        asked.answers.write_text(json.dumps(answers))
        for way, view in followed_up(case, asked, program).items():
            views[way][case.name] = view
        said = {way: {"first": list(seen[case.name].first[0]), "verdict": seen[case.name].verdict,
                      "named": named(seen[case.name], case.right)}
                for way, seen in views.items() if case.name in seen}  # fmt: skip
        cases[case.name] = {**answers[case.name], **said}
        document = {"format": "synth/blind-next/1", "seed": asked.seed, "program": program.digest}
        text = json.dumps({**document, **table(answers, views), "cases": cases}, indent=1)
        (asked.to / "blind-next.json").write_text(text + "\n")
        print(case.name, json.dumps(cases[case.name]), file=sys.stderr, flush=True)  # noqa: T201
    print(text)  # noqa: T201
    return 0


if __name__ == "__main__":
    sys.exit(main())
