"""Make the recorded jumps of the built-in hopper example: MuJoCo, noise, and an effect that the design does not have.

``python tools/make_jumps.py`` writes them into ``synth/examples/hopper``; the same seed gives the same files.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests"))

from blind.jump_cases import UNITS, Asked, Sensors, draw_errors, record  # noqa: E402, an engine of its own
from synth.parts.catalogs import Catalogue  # noqa: E402

SEED = 11
EFFECTS = {"joint_damping.damping": 5e-4}  # N m s/rad, at the rate where both laws have the same torque
BASE = Asked("12cm_150", 150, 0.12)
JUMPS = (
    BASE, replace(BASE, name="12cm_150_again"), replace(BASE, name="10cm_150", length=0.10),
    replace(BASE, name="14cm_150", length=0.14), replace(BASE, name="12cm_100", ratio=100),
    replace(BASE, name="check_13cm_150", length=0.13), replace(BASE, name="check_13cm_100", length=0.13, ratio=100),
    replace(BASE, name="check_11cm_150", length=0.11),
)  # fmt: skip
PULL_UPS = (replace(BASE, name="12cm", kind="pull-up"),)
NOISE = {"upper link": math.radians(0.1), "ground force": 0.02, "hip torque": 1e-3}


def make(out: Path) -> None:
    """Write ``jumps``, ``pull-ups`` and ``truth.json``."""
    rng = np.random.default_rng(SEED)
    errors, sensors, catalogue = draw_errors(rng), Sensors(NOISE, extra=False), Catalogue.load()
    for folder, asked in (("jumps", JUMPS), ("pull-ups", PULL_UPS)):
        (out / folder).mkdir(parents=True, exist_ok=True)
        for item in asked:
            columns = record(item, errors, EFFECTS, sensors, rng, catalogue)
            degrees = {"upper link": np.degrees(columns["upper link"])}
            header = ",".join(f"{name} [{'deg' if name in degrees else UNITS[name]}]" for name in columns)
            values = np.column_stack([degrees.get(name, values) for name, values in columns.items()])
            path = out / folder / f"{item.name}.csv"
            np.savetxt(path, values, delimiter=",", header=header, comments="", fmt="%.6g")
    truth = {"joint_damping": {"joint": "all", "damping": {"value": 5e-4, "unit": "N*m*s/rad"},
                               "form": "a power of the rate, 0.8"},
             "off": {"shared": errors.shared, "motors": errors.motors, "unit": "standard deviations"}}  # fmt: skip
    (out / "truth.json").write_text(json.dumps(truth, indent=1) + "\n")


def main() -> None:
    """Write the recordings beside the design, or under ``--out``."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0] if __doc__ else None)
    parser.add_argument("--out", type=Path, default=ROOT / "synth" / "examples" / "hopper", help="folder to write into")
    out: Path = parser.parse_args().out
    make(out)
    print(f"written under {out}")


if __name__ == "__main__":
    main()
