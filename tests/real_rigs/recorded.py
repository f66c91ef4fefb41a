"""The six real rigs: leg files and trials built in a folder from ``../shared``, of which nothing is in the product."""

from __future__ import annotations

import csv
import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

SHARED = Path(__file__).resolve().parents[3] / "shared"
DOG, DOUBLE, DRIVEN = SHARED / "aarl" / "dog", SHARED / "double_pendulum", SHARED / "rigs" / "driven_pendulum"
LOCKED = {"ankle": "[hip, knee]", "knee": "[hip]", "hip": "[]"}
# Masses and centres of mass differ by tens of per cent between the three sets that were measured; inertias are those of
# a rod; a damper's rate is the chord of a curve that bends; a spring's is the catalogue's. Deviations, not limits.
WIDE = "{length: 1 %, mass: 5 %, com: 5 %, inertia: 15 %, spring: 10 %, damper: 20 %, free_angle: 3 deg}"
COPIES = {f"hip_{number}" for number in range(7, 13)}  # of hip_1 to hip_6, with samples more before the release
PIECE, LONGEST = 2.5, 10.0  # s, length of pieces of a driven recording, and the total used
# A rod of 130 g and .546 kg at its end, .5 m away; the rotor's 6.07e-5 kg m^2 behind a gear of 6. No friction is
# believed in: the owners' own figures of it differ by a factor of seven.
PENDULUM = """kind: leg
name: torque-driven pendulum
gravity: 9.81 m/s^2
joints:
  - name: hinge
    zero: 0 deg
    sign: +1
    range: [-720 deg, 720 deg]
    armature: 2.185e-3 kg*m^2
    link: {length: 500 mm, mass: 676 g, com: 451.9 mm, inertia: 9.27e-3 kg*m^2}
    damper: {rate: 0 N*m*s/rad}
"""


@dataclass(frozen=True)
class Entry:
    """One trial: its entry in the project's list."""

    file: str
    more: str = ""


@dataclass(frozen=True)
class Rig:
    """A leg file's name, tolerances, and trials in the order in which they alternate between the halves."""

    name: str
    leg: str
    tolerance: str
    entries: tuple[Entry, ...]

    def project(self, folder: Path, half: int) -> Path:
        """The project that is fitted to one half (0, 1) of the trials and scored on the other."""
        lines = ["kind: gap", f"leg: {self.leg}", f"tolerance: {self.tolerance}", "trials:"]
        for place, entry in enumerate(self.entries):
            held_out = f", held_out: {str(place % 2 != half).lower()}"
            lines.append(f"  - {{file: {entry.file}{entry.more}{held_out}}}")
        path = folder / f"{self.name.replace(' ', '_')}_{'ab'[half]}.yaml"
        path.write_text("\n".join(lines) + "\n")
        return path


def _robot(folder: Path, name: str, joints: Sequence[str]) -> Rig:
    """Releases of the robot leg as built."""
    shutil.copy(DOG / "dog_built.leg.yaml", folder)
    entries = []
    for joint in joints:
        files = sorted((DOG / "joint_tests").glob(f"{joint}_*.csv"), key=lambda f: int(f.stem.split("_")[1]))
        for file in files:
            if file.stem not in COPIES:
                shutil.copy(file, folder)
                entries.append(Entry(file.name, f", locked: {LOCKED[joint]}"))
    return Rig(name, "dog_built.leg.yaml", WIDE, tuple(entries))


def _double_pendulum(folder: Path) -> Rig:
    """Its four small swings; the dampers' rates are from the authors' fit of all losses."""
    shutil.copy(DOUBLE / "double_pendulum.leg.yaml", folder)
    files = sorted((DOUBLE / "trials").glob("val_*.csv"))
    for file in files:
        shutil.copy(file, folder)
    entries = tuple(Entry(file.name) for file in files)
    return Rig("double pendulum", "double_pendulum.leg.yaml", "{damper: 50 %}", entries)


def _driven_pendulum(folder: Path) -> Rig:
    """Pieces of four recordings that a known torque drives."""
    (folder / "pendulum.leg.yaml").write_text(PENDULUM)
    entries = []
    for name in ("sysid", "ddp_swingup", "dircol_swingup", "energy_shaping"):
        with (DRIVEN / f"{name}_measured.csv").open(newline="") as stream:
            rows = [(float(r["time"]), r["position"], r["torque"]) for r in csv.DictReader(stream)]
        last = min(rows[-1][0], LONGEST)
        for number in range(max(int(last / PIECE), 1)):
            begin = number * PIECE
            part = [row for row in rows if begin <= row[0] < begin + PIECE]
            file = f"{name}_{number}.csv"
            text = "\n".join(f"{t:.6f},{angle},{torque}" for t, angle, torque in part)
            (folder / file).write_text(f"time [s],hinge [rad],hinge torque [N*m]\n{text}\n")
            entries.append(Entry(file))
    tolerance = "{length: 0.5 %, mass: 1 %, com: 2 %, inertia: 10 %, damper: 5 %}"
    return Rig("driven pendulum", "pendulum.leg.yaml", tolerance, tuple(entries))


RIGS: dict[str, Callable[[Path], Rig]] = {
    "robot hip": lambda folder: _robot(folder, "robot hip", ["hip"]),
    "robot knee": lambda folder: _robot(folder, "robot knee", ["knee"]),
    "robot ankle": lambda folder: _robot(folder, "robot ankle", ["ankle"]),
    "robot whole": lambda folder: _robot(folder, "robot whole", ["ankle", "knee", "hip"]),
    "double pendulum": _double_pendulum,
    "driven pendulum": _driven_pendulum,
}


def absent() -> list[str]:
    """Missing folders of recordings."""
    return [str(folder) for folder in (DOG, DOUBLE, DRIVEN) if not folder.is_dir()]
