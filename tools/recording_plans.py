"""Causes that a set of recordings can show: `synth gap --check` on simulated recordings of one leg, one plan per row.

The leg is the nominal one of `synth init gap`. Each plan adds trials to the previous one, or degrades the best one.
Prints the table of docs/record_for_cause.md: the smallest detectable cause at the knee, and the angle between the
responses of pairs of causes there. A pair below 8.6 deg (``separability.ALIKE_SINE``) cannot be distinguished.

    python tools/recording_plans.py          # all plans, about a minute
    python tools/recording_plans.py --only 1 # the first plans
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from synth.diagnosis.check.run import check  # noqa: E402
from synth.files.gap_project import read_gap_project  # noqa: E402
from synth.files.leg_file import read_leg  # noqa: E402
from synth.swing.chain import Conditions, simulate  # noqa: E402

LEG = ROOT / "synth" / "examples" / "gap" / "nominal.leg.yaml"
REST = np.array([105.0, 117.0, 139.0])  # deg, rest pose of the leg, from `synth check`
FULL = np.array([14.0, 34.0, 25.0])  # deg from rest, about the release poses of the example
NOISE = 0.05  # deg, SD of a good encoder: half of the example's

FREE = Conditions()


@dataclass(frozen=True)
class Trial:
    """One release: share of ``FULL``, side of each joint, keys of the trial and its conditions."""

    size: float
    sides: tuple[int, int, int]
    keys: str = ""
    conditions: Conditions = FREE


ONE = {"big": Trial(1.0, (1, -1, 1))}
ALIKE = ONE | {"again": Trial(0.95, (1, -1, 1)), "once_more": Trial(0.9, (1, -1, 1))}
SIZES = ONE | {"half": Trial(0.5, (-1, 1, -1)), "third": Trial(0.33, (1, 1, -1)), "other_side": Trial(1.0, (-1, 1, 1))}
HELD = SIZES | {
    f"{name}_held": Trial(0.9, (1, 1, -1), f"locked: [{name}]", Conditions(locked=(j,)))
    for j, name in enumerate(("hip", "knee", "ankle"))
}
LOADED = HELD | {"heavy": Trial(0.8, (-1, 1, 1), "tip_mass: 50 g", Conditions(tip_mass=0.05))}
TILTED = LOADED | {"tilted": Trial(0.8, (1, -1, -1), "tilt: 30 deg", Conditions(tilt=float(np.radians(30.0))))}
# Name -> trials, samples a second, seconds, noise in deg.
PLANS: dict[str, tuple[dict[str, Trial], float, float, float]] = {
    "one release": (ONE, 200.0, 2.0, NOISE),
    "three, alike": (ALIKE, 200.0, 2.0, NOISE),
    "four: three sizes, both sides": (SIZES, 200.0, 2.0, NOISE),
    "and each joint held in turn": (HELD, 200.0, 2.0, NOISE),
    "and 50 g at the foot": (LOADED, 200.0, 2.0, NOISE),
    "and the base tilted by 30°": (TILTED, 200.0, 2.0, NOISE),
    "the last at 20 Hz": (TILTED, 20.0, 2.0, NOISE),
    "the last, first 0.3 s only": (TILTED, 200.0, 0.3, NOISE),
    "the last, noise tenfold": (TILTED, 200.0, 2.0, 10 * NOISE),
}
SHOWN = (("coulomb_friction", "torque"), ("backlash", "gap"), ("latency", "delay"), ("link_mass", "share"))
PAIRS = (
    ("viscous_damping", "shear_thinning_damping"),
    ("coulomb_friction", "load_friction"),
    ("encoder_offset", "encoder_scale"),
    ("link_inertia", "armature"),
)


def write(folder: Path, trials: Mapping[str, Trial], rate: float, duration: float, noise: float) -> Path:
    """Write the gap project of a plan; returns its file."""
    leg, generator = read_leg(LEG), np.random.default_rng(1)
    times = np.arange(round(duration * rate) + 1) / rate
    listed = []
    for name, trial in trials.items():
        start = leg.to_rotation(np.radians(REST + trial.size * FULL * np.array(trial.sides)))
        angle = np.degrees(leg.to_measured(simulate(leg, start, np.zeros(3), times, trial.conditions)))
        angle += generator.normal(0.0, noise, angle.shape)
        head = ",".join(["time [s]", *(f"{joint} [deg]" for joint in leg.joint_names)])
        rows = [",".join(f"{value:.5f}" for value in (t, *row)) for t, row in zip(times, angle, strict=True)]
        (folder / f"{name}.csv").write_text("\n".join([head, *rows, ""]), encoding="utf-8")
        listed.append(f"  - {{file: {name}.csv{', ' + trial.keys if trial.keys else ''}}}")
    (folder / LEG.name).write_bytes(LEG.read_bytes())
    project = folder / "gap.yaml"
    project.write_text("\n".join(["kind: gap", f"leg: {LEG.name}", "trials:", *listed, ""]), encoding="utf-8")
    return project


def answer(found: Mapping[str, Any]) -> dict[str, str]:
    """Cells of a plan's row, from a check's JSON."""
    causes = [(item["effect"], item["joint"]) for item in found["causes"]]
    cells = {}
    for effect, parameter in SHOWN:
        size = found["causes"][causes.index((effect, "knee"))]["visible_from"]
        cells[effect] = f"{size[parameter]['value']:.2g} {size[parameter]['unit']}" if size else "–"
    for pair in PAIRS:
        rows = [causes.index((effect, "knee")) for effect in pair]
        sine = min(found["sines"][rows[0]][rows[1]], 1.0)
        cells[" / ".join(pair)] = f"{np.degrees(np.arcsin(sine)):.2g}°"
    cells["groups"] = str(len(found["not_told_apart"]))
    return cells


def plan(name: str) -> dict[str, str]:
    """The cells of one plan's row."""
    with tempfile.TemporaryDirectory() as folder:
        return answer(check(read_gap_project(write(Path(folder), *PLANS[name]))).as_json())


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", type=int, default=len(PLANS), metavar="N", help="the first N plans")
    names = list(PLANS)[: parser.parse_args().only]
    rows = {name: plan(name) for name in names}
    heads = [head.replace("_", " ") for head in rows[names[0]]]
    print("| recordings | " + " | ".join(heads) + " |")
    print("|---" * (len(heads) + 1) + "|")
    for name, cells in rows.items():
        print(f"| {name} | " + " | ".join(cells.values()) + " |", flush=True)


if __name__ == "__main__":
    main()
