"""Faults of known size put into the driven pendulum's recordings: ``python -m real_rigs.planted_driven``.

As ``real_rigs.planted``, on a rig that has a fault of its own: dry friction, which the leg file does not state. The
fault put in has to stand before every other cause, the kinds of dry friction aside. Learnt from one half of the
recordings and scored on the other, and the other way round.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from real_rigs.planted import Fault, Read, coarse, scaled
from real_rigs.recorded import RIGS, absent
from synth.arrays import Array
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.files.gap_project import read_gap_project

ANGLE, TORQUE = 1, 2  # columns of the recordings, rad and N m
OWN = {"coulomb_friction", "stribeck_friction", "load_friction"}  # dry friction, which the rig has


def added(column: int, value: float) -> Read:
    """A constant added to a column."""

    def read(table: Array) -> Array:
        made = table.copy()
        made[:, column] += value
        return made

    return read


def delayed(column: int, seconds: float) -> Read:
    """A column that comes later; the first samples, for which no value is known, are cut."""

    def read(table: Array) -> Array:
        made = table.copy()
        made[:, column] = np.interp(table[:, 0] - seconds, table[:, 0], table[:, column])
        kept = made[table[:, 0] >= table[0, 0] + seconds]
        kept[:, 0] -= kept[0, 0]
        return kept

    return read


LINK = "mass: 676 g, com: 451.9 mm"
NO_DAMPER = "    damper: {rate: 0 N*m*s/rad}"
DELAY = ("latency", "hinge"), ("torque_delay", "hinge")  # of one joint that a torque drives the same, but for its sign
HEAVY = ("link_mass", "hinge"), ("torque_gain", "hinge")  # without a spring the same
TILTED = ("encoder_offset", "hinge"), ("base_tilt", "base")
FAULTS = (
    Fault("torque_gain", "hinge", "-20 %", scaled(TORQUE, 0.25), same=HEAVY),
    Fault("torque_offset", "hinge", "0.3 N m", added(TORQUE, -0.3)),
    Fault("latency", "hinge", "40 ms", delayed(ANGLE, 0.040), same=DELAY),
    Fault("encoder_offset", "hinge", "8 deg", added(ANGLE, float(np.radians(8.0))), same=TILTED),
    Fault("encoder_scale", "hinge", "10 %", scaled(ANGLE, 0.10)),
    Fault("encoder_quantisation", "hinge", "3 deg", coarse(ANGLE, float(np.radians(3.0)))),
    Fault("link_mass", "hinge", "-25 %", numbers={"mass: 676 g": "mass: 901 g", "9.27e-3": "1.236e-2"}, same=HEAVY),
    Fault("link_inertia", "hinge", "centre of mass +18 %", numbers={LINK: "mass: 676 g, com: 383 mm"}),
    Fault("armature", "hinge", "-0.04 kg m2", numbers={"2.185e-3": "4.2185e-2"}),
    Fault("viscous_damping", "hinge", "-0.1 N m s/rad", numbers={NO_DAMPER: "    damper: {rate: 0.1 N*m*s/rad}"}),
    Fault("spring_rate", "hinge", "-1 N m/rad",
          numbers={NO_DAMPER: NO_DAMPER + "\n    spring: {rate: 1 N*m/rad, free_angle: 0 deg}"}),
)  # fmt: skip


def diagnosed(fault: Fault | None, half: int) -> dict[str, Any]:
    """``gap.json`` of the recordings with a fault, learnt from one half (0, 1)."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        rig = RIGS["driven pendulum"](folder)
        text = (folder / rig.leg).read_text()
        for old, new in (fault.numbers if fault else {}).items():
            assert text.count(old) == 1, old
            text = text.replace(old, new)
        (folder / rig.leg).write_text(text)
        for entry in rig.entries:
            file = folder / entry.file
            table = np.genfromtxt(file, delimiter=",", skip_header=1)
            table[:, 0] -= table[0, 0]
            made = fault.read(table) if fault else table
            header = "time [s],hinge [rad],hinge torque [N*m]"
            np.savetxt(file, made, delimiter=",", header=header, comments="", fmt="%.6f")
        read = read_gap_project(rig.project(folder, half))
        return diagnose(read.leg, read.trials, read.tolerance, seed=read.seed).as_json()


def first_cause(found: dict[str, Any]) -> tuple[str, str] | None:
    """Effect and joint of the first cause that the rig does not have of its own."""
    others = [(c["effect"], c["joint"]) for c in found["ranked"] if c["effect"] not in OWN]
    return others[0] if others else None


def main() -> int:
    missing = absent()
    if missing:
        print(f"not here: {', '.join(missing)}", file=sys.stderr)  # noqa: T201
        return 1
    halves = [int(word) for word in sys.argv[1:]] or [0, 1]
    for half in halves:
        plain = diagnosed(None, half)["gap"]["before"]["value"]
        print(f"half {'ab'[half]}, without a fault: {plain:.2f} deg; then fault, gap, verdict, first causes")  # noqa: T201
        right = 0
        for fault in FAULTS:
            found = diagnosed(fault, half)
            gap = found["gap"]["before"]["value"]
            stands_first = first_cause(found) in ((fault.effect, fault.joint), *fault.same)
            right += stands_first
            word = "right" if stands_first else "WRONG"
            causes = ", ".join(f"{c['effect']} {c['probability']:.2f}" for c in found["ranked"][:4])
            told = f"{fault.effect:21s} {fault.size:22s} {gap:6.2f} -> {found['gap']['after']['value']:6.2f}"
            print(f"{told} {found['verdict']:8s} {word:6s} {causes}", flush=True)  # noqa: T201
        print(f"half {'ab'[half]}: {right} of {len(FAULTS)} faults stand first")  # noqa: T201
    return 0


if __name__ == "__main__":
    sys.exit(main())
