"""Measure the errors of detected releases and of the ends of external torques: a table of docs/measured.md.

``python tools/measure_release.py [COUNT] [FOLDER]``: COUNT simulated legs per line; FOLDER contains a leg file,
``recordings/*.csv`` and ``windows.csv`` with releases picked by hand.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))

from motion.driven_releases import driven_release
from synth.files.leg_file import read_leg
from synth.motion.release import find_release

SHARES = (5, 25, 50, 75, 95)


def simulated(count: int) -> None:
    """Print errors for random legs at 100, 250 and 500 Hz, released at once or by a fading torque."""
    shares = " ".join(f"{share:>5}%" for share in SHARES)
    print(f"{count} legs a line; ms late\nfade   noise   release: {shares}   worst   hand seen   its end: {shares}")
    for fade in (0.0, 0.15, 0.25):
        for noise in (0.05, 0.1, 0.2, 0.4):
            generator = np.random.default_rng(11)
            late, ends, missed = [], [], 0
            for _ in range(count):
                made = driven_release(generator, fade, noise, float(generator.choice([100.0, 250.0, 500.0])))
                found = find_release(made.time, made.angles, made.leg)
                if found.released is None:
                    missed += 1
                    continue
                late.append(1e3 * (found.released - made.released))
                if found.driven_until is not None:
                    ends.append(1e3 * (found.driven_until - made.free_from))
            line = " ".join(f"{x:6.1f}" for x in np.percentile(late, SHARES))
            ended = " ".join(f"{x:6.1f}" for x in np.percentile(ends, SHARES)) if fade and ends else ""
            print(
                f"{fade:4.2f} s {noise:4.2f} deg         {line}  {max(late, key=abs):6.1f}   "
                f"{len(ends) / count:9.0%}            {ended}" + (f"   {missed} missed" if missed else "")
            )


def recorded(folder: Path) -> None:
    """Print differences from windows picked by hand."""
    (leg_file,) = folder.glob("*.leg.yaml")
    leg = read_leg(leg_file)
    late = {}
    with (folder / "windows.csv").open() as stream:
        for row in csv.DictReader(stream):
            table = np.genfromtxt(folder / "recordings" / row["file"], delimiter=",", skip_header=1)
            found = find_release(table[:, 0], np.radians(table[:, 1:]), leg)
            start = float(row["release start [s]"])
            late[row["file"]] = np.nan if found.released is None else 1e3 * (found.released - start)
    values = np.array(list(late.values()))
    print(f"\n{len(late)} recordings; ms later than the hand: " + " ".join(f"{x:.0f}" for x in np.sort(values)))
    print(f"median {np.nanmedian(values):.1f}; beyond 30 ms: {[k for k, v in late.items() if not abs(v) <= 30]}")


if __name__ == "__main__":
    simulated(int(sys.argv[1]) if len(sys.argv) > 1 else 40)
    if len(sys.argv) > 2:
        recorded(Path(sys.argv[2]))
