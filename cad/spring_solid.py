"""Properties measured on a spring's solid: its arms' lines and, with the clamping points, its rate."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from synth.cad.flexed_wire import effective_length


@dataclass(frozen=True)
class MeasuredArm:
    """An arm's straight axis in the solid: a point (3,) and a unit direction (3,) outwards, mm."""

    point: np.ndarray[Any, Any]
    direction: np.ndarray[Any, Any]

    def seen_angle(self) -> float:
        """Direction seen along z, deg."""
        return math.degrees(math.atan2(self.direction[1], self.direction[0]))

    def distance(self) -> float:
        """From the hinge axis to the arm's line, seen along z, mm."""
        across = np.array([self.direction[1], -self.direction[0]]) / np.hypot(*self.direction[:2])
        return float(abs(np.dot(self.point[:2], across)))

    def reach(self) -> float:
        """From the arm's tangent point to its tip, seen along z, mm."""
        along = self.direction[:2] / np.hypot(*self.direction[:2])
        return float(np.dot(self.point[:2], along))

    def start_of(self, solid: Any, turn: float) -> float:
        """From the arm's tangent point to the start of a solid, turned by ``turn`` deg about z, along the arm, mm."""
        along = self.direction[:2] / np.hypot(*self.direction[:2])
        corners = [vertex.toTuple() for vertex in solid.rotate((0, 0, 0), (0, 0, 1), turn).Vertices()]
        return min(float(np.dot(corner[:2], along)) for corner in corners)


def measured_arms(solid: Any) -> tuple[MeasuredArm, MeasuredArm]:
    """Both arms of a spring's solid, from its flat ends: lower end first.

    Each end is a disc square to its arm, so its centre and outward normal are the arm's axis.
    """
    ends = [face for face in solid.Faces() if face.geomType() == "PLANE"]
    if len(ends) != 2:
        raise ValueError(f"a spring has two flat ends, this solid has {len(ends)}")
    arms = []
    for face in sorted(ends, key=lambda face: face.Center().z):
        centre, normal = face.Center(), face.normalAt()
        arms.append(MeasuredArm(np.array(centre.toTuple()), np.array(normal.toTuple())))
    return arms[0], arms[1]


def measured_stiff_length(solid: Any, wire_diameter: float, frees: tuple[float, float]) -> float:
    """Length (mm) of a straight beam with the stiffness of a drawn spring with free arms of ``frees`` mm.

    From its solid: the arms' lines give the coil's radius; the volume gives the wire's length and thus the turns.
    """
    arms = measured_arms(solid)
    radius = (arms[0].distance() + arms[1].distance()) / 2
    length = float(solid.Volume()) / (math.pi * wire_diameter**2 / 4)
    flat = length * float(np.hypot(*arms[0].direction[:2]))  # seen along z: the slope is the same all along
    coils = (flat - arms[0].reach() - arms[1].reach()) / (2 * math.pi * radius)
    return effective_length(radius, coils, (frees[0] + frees[1]) / 2)
