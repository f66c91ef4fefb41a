"""Faults of known size put into real recordings: ``python -m real_rigs.planted [large]``, see ``make rigs``.

The double pendulum's four small swings, or with ``large`` fitted on its eight large ones, the small ones held out. Its
remainder is a rig's own: 0.13 deg, a hundred times the encoders' noise.
A reading is changed in the recordings; a number is changed in the leg file, so that the rig departs from it by as much
the other way. A fault counts as shown if the gap within the tolerances is at least 1.5 times that without a fault.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from real_rigs.recorded import DOUBLE, absent
from synth.arrays import Array
from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose
from synth.files.gap_project import read_gap_project

SHOWN = 1.5  # times the gap without a fault
UPPER, LOWER = 1, 2  # columns of the recordings
Read = Callable[[Array], Array]


@dataclass(frozen=True)
class Fault:
    """``read`` changes a recording (m, 3) s and deg; ``numbers`` : text of the leg file -> what stands there instead.

    ``same`` : causes that act alike on these recordings.
    """

    effect: str
    joint: str
    size: str
    read: Read = lambda table: table
    numbers: Mapping[str, str] = field(default_factory=dict)
    same: tuple[tuple[str, str], ...] = ()


def shifted(column: int, degrees: float) -> Read:
    return lambda table: _with(table, column, table[:, column] + degrees)


def scaled(column: int, share: float) -> Read:
    return lambda table: _with(table, column, table[:, column] * (1.0 + share))


def late(column: int, seconds: float) -> Read:
    """Cut at the start, where no earlier reading is known."""
    first = 1 + int(seconds / 0.002)  # 500 Hz

    def read(table: Array) -> Array:
        delayed = np.interp(table[:, 0] - seconds, table[:, 0], table[:, column])
        return _with(table, column, delayed)[first:]

    return read


def coarse(column: int, degrees: float) -> Read:
    return lambda table: _with(table, column, np.round(table[:, column] / degrees) * degrees)


def _with(table: Array, column: int, values: Array) -> Array:
    made = table.copy()
    made[:, column] = values
    return made


DAMPERS = "    damper: {rate: 2.371e-4 N*m*s/rad}", "    damper: {rate: 1e-5 N*m*s/rad}"  # upper, lower
SPRING = "\n    spring: {rate: 0.03 N*m/rad, free_angle: 0 deg}"
ARMATURE = "\n    armature: 5e-4 kg*m^2"
FAULTS = (
    Fault("encoder_offset", "upper", "1 deg", shifted(UPPER, 1.0), same=(("base_tilt", "base"),)),
    Fault("encoder_offset", "lower", "1 deg", shifted(LOWER, 1.0)),
    Fault("encoder_scale", "upper", "15 %", scaled(UPPER, 0.15)),
    Fault("encoder_scale", "lower", "15 %", scaled(LOWER, 0.15)),
    Fault("latency", "lower", "10 ms", late(LOWER, 0.010)),
    Fault("latency", "upper", "20 ms", late(UPPER, 0.020)),
    Fault("encoder_quantisation", "upper", "1 deg", coarse(UPPER, 1.0)),
    Fault("base_tilt", "base", "1.5 deg", shifted(UPPER, 1.5), same=(("encoder_offset", "upper"),)),
    Fault("link_mass", "lower", "-17 %", numbers={"137.6 g": "165.1 g", "1.269e-3": "1.523e-3"}),
    Fault("link_mass", "upper", "-20 %", numbers={"93.84 g": "117.3 g", "4.375e-4": "5.469e-4"}),
    Fault("link_inertia", "lower", "centre of mass +11 %", numbers={"com: 116.8 mm": "com: 105 mm"}),
    Fault("link_inertia", "lower", "inertia +27 %", numbers={"1.269e-3": "1e-3"}),
    Fault("link_inertia", "upper", "inertia -30 %", numbers={"4.375e-4": "6.25e-4"}),
    Fault("spring_rate", "lower", "-0.03 N m/rad", numbers={DAMPERS[1]: DAMPERS[1] + SPRING}),
    Fault("viscous_damping", "upper", "-0.01 N m s/rad", numbers={"2.371e-4": "1e-2"}),
    Fault("armature", "upper", "-0.0005 kg m2", numbers={DAMPERS[0]: DAMPERS[0] + ARMATURE}),
)  # fmt: skip


def project(folder: Path, fault: Fault | None, *, large: bool = False) -> Path:
    """The project without or with a fault: learnt from the four small swings, or from the eight large ones.

    The small ones are then held out.
    """
    text = (DOUBLE / "double_pendulum.leg.yaml").read_text()
    for old, new in (fault.numbers if fault else {}).items():
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    (folder / "double_pendulum.leg.yaml").write_text(text)
    names = []
    for file in sorted((DOUBLE / "trials").glob("*.csv" if large else "val_*.csv")):
        table = np.genfromtxt(file, delimiter=",", skip_header=1)
        made = fault.read(table) if fault else table
        header = "time [s],upper [deg],lower [deg]"
        np.savetxt(folder / file.name, made, delimiter=",", header=header, comments="", fmt="%.4f")
        held_out = str(large and file.name.startswith("val_")).lower()
        names.append(f"  - {{file: {file.name}, held_out: {held_out}}}")
    lines = ["kind: gap", "leg: double_pendulum.leg.yaml", "tolerance: {damper: 50 %}", "trials:", *names]
    (folder / "gap.yaml").write_text("\n".join(lines) + "\n")
    return folder / "gap.yaml"


def diagnosed(fault: Fault | None, *, large: bool = False) -> dict[str, Any]:
    """``gap.json`` of the recordings with a fault; ``large`` as of ``project``."""
    with tempfile.TemporaryDirectory() as folder:
        read = read_gap_project(project(Path(folder), fault, large=large))
        return diagnose(read.leg, read.trials, read.tolerance, seed=read.seed).as_json()


def first_cause(found: Mapping[str, Any]) -> tuple[str, str]:
    """Effect and joint of the cause that stands first."""
    return found["ranked"][0]["effect"], found["ranked"][0]["joint"]


def is_right(fault: Fault, found: Mapping[str, Any]) -> bool:
    """The fault stands first, or one that acts alike."""
    return first_cause(found) in ((fault.effect, fault.joint), *fault.same)


def main() -> int:
    missing = absent()
    if missing:
        print(f"not here: {', '.join(missing)}", file=sys.stderr)  # noqa: T201
        return 1
    large = "large" in sys.argv[1:]
    plain = diagnosed(None, large=large)["gap"]["before"]["value"]
    print(f"without a fault: {plain:.2f} deg within the tolerances; then fault, gap, verdict, first causes")  # noqa: T201
    right = shown = 0
    for fault in FAULTS:
        found = diagnosed(fault, large=large)
        gap = found["gap"]["before"]["value"]
        visible = gap >= SHOWN * plain or fault.effect == "encoder_quantisation"
        shown += visible
        right += visible and is_right(fault, found)
        word = ("right" if is_right(fault, found) else "WRONG") if visible else "not shown"
        causes = ", ".join(f"{c['effect']} ({c['joint']}) {c['probability']:.2f}" for c in found["ranked"][:3])
        what = f"{fault.effect} ({fault.joint})"
        print(f"{what:28s} {fault.size:22s} {gap:5.2f} {found['verdict']:8s} {word:10s} {causes}", flush=True)  # noqa: T201
    print(f"{right} of {shown} shown faults stand first")  # noqa: T201
    return 0


if __name__ == "__main__":
    sys.exit(main())
