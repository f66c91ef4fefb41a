"""What the suggested trial gains: made with the tied case's true leg, added to the trials, and diagnosed again."""

from __future__ import annotations

import json
import math
import re
import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from blind.cases import Case, make_case
from blind.make import plan
from blind.score import true_keys
from blind.views import View
from blind.writing import folder_name
from synth.planting.model import Array, Law, PlantedTrial
from synth.planting.simulation import fastest, release
from synth.planting.torque_laws import KNOCKS
from synth.units import parse

RAMP = re.compile(r"a torque on (\w+) that rises slowly to ([\d.e+-]+) N m in ([\d.]+) s")
HALF_WAVE = 1e3  # s, of the sine whose first seconds serve as a ramp: straight to 1e-5


@dataclass(frozen=True)
class Suggestion:
    """The trial that a diagnosis suggests: keys of its entry, release in measured angles, rad, and torque's ramp."""

    keys: Mapping[str, Any]
    release: Array
    ramp: tuple[int, float, float] | None  # joint, N m in the measured sense, s

    @classmethod
    def of(cls, asked: Mapping[str, Any], names: tuple[str, ...]) -> Suggestion:
        """From ``next_experiment``; a torque to apply stands in its words only."""
        keys = {key: value for key, value in asked["trial"].items() if key not in ("file", "held_out")}
        angles = np.array([math.radians(asked["release"][name]["value"]) for name in names])
        found = RAMP.search(asked["menu"][0]["what"])
        ramp = (names.index(found[1]), float(found[2]), float(found[3])) if found else None
        return cls(keys, angles, ramp)


def made_again(name: str, answers: Mapping[str, Mapping[str, Any]]) -> Case:
    """The case with its truth, by the seed in its answer.

    Raises
    ------
    RuntimeError
        If the generator makes another case now than it did then.
    """
    seed, drawn = answers[name]["seed"]
    again, number = divmod(drawn, 100_000)
    _, kind, effect = next(task for task in plan(seed, len(answers), "mix", None) if task[0] == number)
    case = make_case(seed, drawn, kind, effect if again < 2 else None)
    if folder_name(seed, number) != name or json.loads(json.dumps(case.answer)) != answers[name]:
        raise RuntimeError(f"{name} is not what the generator makes from seed {seed}: make the cases again")
    return case


def recorded(case: Case, asked: Suggestion) -> tuple[Array, Array]:
    """Times (m,) s and readings (m, n) rad of the suggested trial, with the case's own sensors."""
    setup, leg = case.setup, case.setup.true
    given = [trial for trial in setup.trials if not trial.held_out]
    keys = asked.keys
    trial = PlantedTrial(
        pose=_posed(case, asked.release),
        duration=asked.ramp[2] if asked.ramp else max(t.duration for t in given),
        tip_mass=parse(keys["tip_mass"], "kg") if "tip_mass" in keys else 0.0,
        locked=tuple(sorted(leg.names.index(joint) for joint in keys.get("locked", ()))),
        tilt=parse(keys["tilt"], "rad") if "tilt" in keys else 0.0,
    )
    truth = case.truth
    if asked.ramp:
        joint, torque, rise = asked.ramp
        size = leg.sign[joint] * torque * HALF_WAVE / (math.pi * rise)
        ramp = Law(KNOCKS, joint, (size, 2 * HALF_WAVE, 0.0, HALF_WAVE))
        truth = type(truth)(truth.leg, (*truth.laws, ramp), truth.base, truth.bends, truth.tilt, truth.bare)
    step = float(np.clip(0.7 / fastest(truth, trial), 2.5e-5, 2.5e-4))
    longer = trial._replace(duration=trial.duration + case.sensor.reach)
    motion = release(truth, longer, step, case.rest)
    times = np.arange(round(trial.duration * setup.sampling) + 1) / setup.sampling
    clean = case.sensor.read(leg, motion, times, 0.0, counted=False)
    noise = np.random.default_rng([*case.answer["seed"], 0xE])
    return times, case.sensor.record(clean, setup.noise, setup.counts, noise)


def _posed(case: Case, reading: Array) -> Array:
    """(n,) rad rotations at which the encoders show ``reading``: the experimenter goes by what they show."""
    leg, sensor = case.setup.true, case.sensor
    angle = reading.copy()
    for _ in range(20):
        shown = angle + sensor.talk @ (angle - sensor.talk_about)
        if sensor.wobble is not None:
            j, size, harmonic, phase = sensor.wobble
            shown[j] += size * np.sin(harmonic * shown[j] + phase)
        shown = shown * (1 + sensor.scale) + sensor.offset
        angle = angle + 0.7 * (reading - shown)
    return np.asarray((angle - leg.zero) * leg.sign)


def add_trial(case: Case, folder: Path, to: Path, asked: Suggestion) -> None:
    """The case's folder once more, with the suggested trial among those to learn from."""
    shutil.copytree(folder, to)
    times, readings = recorded(case, asked)
    names = case.setup.true.names
    columns = [f"{name} [deg]" for name in names]
    table = [times, *np.degrees(readings).T]
    if asked.ramp:
        joint, torque, rise = asked.ramp
        columns.append(f"{names[joint]} torque [N*m]")
        table.append(torque * times / rise)
    rows = [",".join(["time [s]", *columns])]
    rows += [",".join([f"{row[0]:.6f}", *(f"{value:.9g}" for value in row[1:])]) for row in zip(*table, strict=True)]
    (to / "trials" / "next.csv").write_text("\n".join(rows) + "\n")
    entry = ["file: trials/next.csv"]
    for key, value in asked.keys.items():
        entry.append(f"{key}: [{', '.join(value)}]" if isinstance(value, list) else f"{key}: {value}")
    project = to / "gap.yaml"
    project.write_text(project.read_text().replace("trials:\n", f"trials:\n  - {{{', '.join(entry)}}}\n", 1))


def make_all(cases: Path, to: Path, answers: Mapping[str, Mapping[str, Any]], views: Mapping[str, View]) -> None:
    """Every tied case for which a trial was suggested, with that trial, in a folder of its name under ``to``."""
    shutil.rmtree(to, ignore_errors=True)
    to.mkdir(parents=True)
    for name, answer in answers.items():
        asked = views[name].next_trial
        if answer["kind"] == "tie" and asked is not None:
            case = made_again(name, answers)
            add_trial(case, cases / name, to / name, Suggestion.of(asked, case.setup.true.names))


def first_right(
    answers: Mapping[str, Mapping[str, Any]], before: Mapping[str, View], after: Mapping[str, View]
) -> tuple[list[bool], list[bool]]:
    """Of each tied case whether the first-ranked cause is the true one, without and with the suggested trial.

    Without a suggestion nothing is gained.
    """
    names = [name for name, answer in answers.items() if answer["kind"] == "tie"]
    true = {name: true_keys(answers[name])[0] for name in names}
    once = [before[name].first[0] == true[name] for name in names]
    again = [after.get(name, before[name]).first[0] == true[name] for name in names]
    return once, again
