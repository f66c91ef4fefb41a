"""Write the OpenSim samples of ``tests/motion/importers/data`` with OpenSim itself.

OpenSim is 220 MB and used only here, so it is not a dependency of the tests. In a separate environment:
``pip install opensim && python tools/make_opensim_samples.py tests/motion/importers/data``.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import opensim

RATE = 100.0  # Hz
COUNT = 60


def angles(time: float) -> tuple[float, float, float]:
    """Hip flexion, knee angle (negative: flexed) and ankle angle, deg; the tests use the same formulas."""
    swing = math.exp(-3.0 * time)
    return (
        10.0 + 25.0 * swing * math.cos(9.0 * time),
        -40.0 + 30.0 * swing * math.cos(14.0 * time),
        5.0 - 12.0 * swing * math.sin(11.0 * time),
    )


def table(labels: list[str], factor: float) -> opensim.TimeSeriesTable:
    """The angles as an OpenSim table."""
    made = opensim.TimeSeriesTable()
    made.setColumnLabels(labels)
    for k in range(COUNT):
        made.appendRow(k / RATE, opensim.RowVector([factor * angle for angle in angles(k / RATE)]))
    made.addTableMetaDataString("name", "Coordinates")
    return made


def main(folder: Path) -> None:
    """Write coordinates in degrees (.mot), model states in radians (.sto), and a file that does not state the unit."""
    coordinates = ["hip_flexion_r", "knee_angle_r", "ankle_angle_r"]
    in_degrees = table(coordinates, 1.0)
    in_degrees.addTableMetaDataString("inDegrees", "yes")
    opensim.STOFileAdapter.write(in_degrees, str(folder / "degrees.mot"))
    joints = ["hip_r", "knee_r", "ankle_r"]
    paths = [f"/jointset/{joint}/{name}/value" for joint, name in zip(joints, coordinates, strict=True)]
    in_radians = table(paths, math.pi / 180.0)
    in_radians.addTableMetaDataString("inDegrees", "no")
    opensim.STOFileAdapter.write(in_radians, str(folder / "radians.sto"))
    opensim.STOFileAdapter.write(table(coordinates, 1.0), str(folder / "unsaid.sto"))
    vectors = opensim.TimeSeriesTableVec3()
    vectors.setColumnLabels(["toe"])
    for k in range(3):
        vectors.appendRow(k / RATE, opensim.RowVectorVec3([opensim.Vec3(k, 2, 3)]))
    vectors.addTableMetaDataString("inDegrees", "no")
    opensim.STOFileAdapterVec3.write(vectors, str(folder / "vectors.sto"))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
