"""Make the import example's videos: a simulated swinging leg as DeepLabCut would track it."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests"))
RATE, NOISE, SEED = 200.0, 0.3, 11  # Hz, pixels, of the noise
STARTS = {"release_1": (0.25, -0.75, 0.35), "release_2": (0.0, -1.6, 1.0)}  # rad from rest, times ``SHARE``
SHARE = 0.35  # factor on ``STARTS``
LOST = range(90, 94)  # frames of the first video in which the toe is lost
NAMES = ("hip", "knee", "ankle", "toe")


def make(folder: Path) -> None:
    """Write ``videos/*.csv`` into the folder."""
    from fit.simulated_legs import robot
    from synth.swing.chain import simulate

    leg, rng = robot(), np.random.default_rng(SEED)
    (folder / "videos").mkdir(parents=True, exist_ok=True)
    time = np.arange(0, 1.2, 1 / RATE)
    rest = leg.to_rotation(np.radians([105.0, 117.0, 139.0]))
    for name, start in STARTS.items():
        rotation = simulate(leg, np.array(rest) + np.array(start) * SHARE, [0.0] * 3, time, tolerance=1e-8)
        absolute = np.cumsum(rotation, axis=1)
        places = [np.zeros((len(time), 2))]
        for j, joint in enumerate(leg.joints):
            way = np.stack([np.sin(absolute[:, j]), -np.cos(absolute[:, j])], 1)
            places.append(places[-1] + joint.link.length * way)
        pixels = [np.stack([640 + 1000 * at[:, 0], 120 - 1000 * at[:, 1]], 1) for at in places]
        seen = [at + rng.normal(0, NOISE, at.shape) for at in pixels]
        lines = [
            "scorer," + ",".join(["DLC_example"] * 12),
            "bodyparts," + ",".join(n for n in NAMES for _ in range(3)),
        ]
        lines.append("coords," + ",".join(["x", "y", "likelihood"] * 4))
        for k in range(len(time)):
            lost = name == "release_1" and k in LOST
            cells = [
                f"{at[k, 0]:.2f},{at[k, 1]:.2f},{'0.120' if lost and i == 3 else '0.998'}" for i, at in enumerate(seen)
            ]
            lines.append(",".join([str(k), *cells]))
        (folder / "videos" / f"{name}.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    make(ROOT / "synth" / "examples" / "import")
