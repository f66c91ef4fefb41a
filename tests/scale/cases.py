"""What is made large: each case writes a project of a given size, and is one command of ``synth``."""

from __future__ import annotations

import csv
import random
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from synth.api.hoppers import read_hopper
from synth.files.leg_file import write_leg
from synth.files.output import write_csv
from synth.swing.chain import simulate
from synth.swing.leg_model import Damper, Joint, Leg, Link, Spring

ROOT = Path(__file__).resolve().parents[2]
LINK = Link(0.3, 0.5, 0.15, 0.004)
FREE = 0.1  # rad
PENDULUM = Leg("pendulum", (Joint("hinge", LINK, spring=Spring(1.0, FREE), damper=Damper(0.02)),))
BARE = Leg("pendulum", (Joint("hinge", LINK),))
SAMPLES, RATE = 200, 100.0  # of a recording, and its samples a second
SCATTER = 0.05  # deg, of a reading
OWN, BARE_OUT = ("--catalog", "springs.csv"), ("--no-cad", "--out", "out")
WISH = "kind: part-wish\nspring: {rate: 1.7 N*m/rad, travel: 40 deg, rate_tolerance: 5 %}\n"


@dataclass(frozen=True)
class ScaleCase:
    """``write`` makes the project of a size below a folder; ``words`` are what is run there."""

    name: str
    what: str
    full: int
    write: Callable[[Path, int], None]
    words: tuple[str, ...]


def recording(path: Path, seed: int, samples: int = SAMPLES, rate: float = RATE) -> None:
    """A release of the pendulum, with noise."""
    generator = np.random.default_rng(seed)
    away = generator.uniform(0.3, 0.6) * generator.choice([-1.0, 1.0])
    time = np.arange(samples) / rate
    angle = np.degrees(simulate(PENDULUM, [FREE + away], [0.0], time)[:, 0])
    path.parent.mkdir(parents=True, exist_ok=True)
    write_csv(path, {"time [s]": time, "hinge [deg]": angle + generator.normal(0.0, SCATTER, samples)})


def _project(folder: Path, kind: str, leg: Leg, trials: int, samples: int = SAMPLES, rate: float = RATE) -> None:
    for number in range(trials):
        recording(folder / "trials" / f"{number:04d}.csv", number, samples, rate)
    write_leg(leg, folder / "pendulum.leg.yaml")
    (folder / f"{kind}.yaml").write_text(f"kind: {kind}\nleg: pendulum.leg.yaml\ntrials: [trials/*.csv]\n")


def _fits(folder: Path, size: int) -> None:
    for number in range(size):
        _project(folder / "many" / f"leg_{number:04d}", "fit", BARE, 2)


def _gaps(folder: Path, size: int) -> None:
    for number in range(size):
        _project(folder / "many" / f"leg_{number:04d}", "gap", PENDULUM, 3)


def _trials(folder: Path, size: int) -> None:
    _project(folder, "fit", BARE, size)


def _rows(folder: Path, size: int) -> None:
    """One recording of two seconds, so finely sampled that it has so many rows."""
    _project(folder, "fit", BARE, 1, size, size / (SAMPLES / RATE))


def _parts(folder: Path, size: int) -> None:
    """A vendor's springs: the built-in rows with their rates drawn anew, each under a number of its own."""
    with (ROOT / "catalogs" / "torsion_springs.csv").open(encoding="utf-8", newline="") as stream:
        table = csv.DictReader(stream)
        heads, rows = list(table.fieldnames or ()), list(table)
    generator = random.Random(size)
    with (folder / "springs.csv").open("w", encoding="utf-8", newline="") as stream:
        written = csv.DictWriter(stream, heads, lineterminator="\n")
        written.writeheader()
        for number in range(size):
            row = rows[number % len(rows)]
            rate = float(row["rate [N*m/rad]"] or 1.0) * generator.uniform(0.5, 2.0)
            written.writerow(row | {"part": f"S{number:06d}", "rate [N*m/rad]": f"{rate:.5g}"})
    (folder / "knee.yaml").write_text(WISH)


def _designs(folder: Path, size: int) -> None:
    """Jumping legs: the example's motors by as many lengths as give so many designs."""
    shutil.copy(ROOT / "synth" / "examples" / "hopper" / "hopper.yaml", folder)
    path = folder / "hopper.yaml"
    text = path.read_text(encoding="utf-8").replace("model: full", "model: A")
    path.write_text(text, encoding="utf-8")
    lengths = max(2, size // read_hopper(path)[2])
    path.write_text(text.replace("step: 10 mm", f"step: {150.0 / (lengths - 1):.9g} mm"), encoding="utf-8")


CASES = (
    ScaleCase("fits", "fit projects in a folder", 300, _fits, ("fit", "many", "--out", "out")),
    ScaleCase("gaps", "gap projects in a folder", 300, _gaps, ("gap", "many", "--out", "out")),
    ScaleCase("trials", "trials of one fit", 1_000, _trials, ("fit", "fit.yaml", "--out", "out")),
    ScaleCase("rows", "rows of one recording", 1_000_000, _rows, ("fit", "fit.yaml", "--out", "out")),
    ScaleCase("parts", "rows of a catalogue", 100_000, _parts, ("catalog", "show", "knee.yaml", *OWN)),
    ScaleCase("designs", "designs of a sweep", 1_000_000, _designs, ("hopper", "hopper.yaml", *BARE_OUT)),
)  # fmt: skip
