"""A loaded spring outside its seats: a tube between the clamps, and its coil apart from its arms.

The coil lies in a ring about the hinge axis, which one look at a half's pocket clears for every angle; only the arms
are left to be tested pose by pose.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from synth.cad.dimensions import JointDimensions
from synth.cad.layout import JointLayout
from synth.cad.parts import Array, Mesh
from synth.cad.pose import loaded_line, loaded_wire
from synth.cad.torsion_spring import SIDES, tube_faces, tube_mesh
from synth.cad.turning_rings import Ring

BEGINNING = 2  # sections of the coil at each end that count as the arm's


@dataclass(frozen=True)
class FreeWire:
    """A tube along the wire from one clamp to the other, in the joint's canonical frame.

    ``sections`` (n, sides, 3) mm: the polygons round the wire from end to end. ``ends`` (2, 3) mm: the centres of the
    first and last. ``coil``: the first and last section of the coil without its beginnings. ``signs``: those of
    ``Mesh.scaled`` that bring it into the joint's frame.
    """

    sections: Array
    ends: Array
    coil: tuple[int, int]
    signs: tuple[int, int, int]

    def whole(self) -> Mesh:
        """The tube, in the joint's frame."""
        return self._tube(0, len(self.sections) - 1).scaled(self.signs)

    def arms(self) -> Mesh:
        """Both arms, each with the beginning of the coil, as two closed tubes in the joint's frame."""
        first, last = self._tube(0, self.coil[0]), self._tube(self.coil[1], len(self.sections) - 1)
        faces = np.vstack([first.faces, last.faces + len(first.vertices)])
        return Mesh(np.vstack([first.vertices, last.vertices]), faces).scaled(self.signs)

    def _tube(self, first: int, last: int) -> Mesh:
        """The closed tube between two sections."""
        part = self.sections[first : last + 1]
        begin = self.ends[0] if first == 0 else part[0].mean(axis=0)
        end = self.ends[1] if last == len(self.sections) - 1 else part[-1].mean(axis=0)
        vertices = np.vstack([part.reshape(-1, 3), begin, end])
        return Mesh(vertices, tube_faces(len(part), part.shape[1]))

    def coil_ring(self) -> Ring:
        """The ring that holds the coil, in the joint's frame.

        Between two sections the tube lies in their convex hull, thus beyond each line, seen along the axis, beyond
        which both of them lie.
        """
        part = self.sections[self.coil[0] : self.coil[1] + 1]
        heights = part[..., 2] * self.signs[2]
        centres = part[..., :2].mean(axis=1)
        way = centres[1:] + centres[:-1]
        way /= np.linalg.norm(way, axis=1, keepdims=True)
        inner = min(float(np.einsum("nsi,ni->ns", each[..., :2], way).min()) for each in (part[:-1], part[1:]))
        outer = float(np.hypot(part[..., 0], part[..., 1]).max())
        return Ring(inner, outer, float(heights.min()), float(heights.max()))


def free_wire(dimensions: JointDimensions, layout: JointLayout, angle: float, sides: int | None = None) -> FreeWire:
    """The wire at the measured joint ``angle`` (deg) without its ends in the seats and the clearance before them.

    ``sides`` of its section, default those of its picture.
    """
    count = sides or SIDES
    wire = loaded_wire(dimensions, layout, angle)
    points = loaded_line(dimensions, layout, angle)[1:-1]
    for end, inner in ((0, 1), (-1, -2)):
        way = points[inner] - points[end]
        points[end] += way * min(0.5, dimensions.clearance / float(np.linalg.norm(way)))
    vertices, _ = tube_mesh(points, dimensions.spring.wire_diameter, count)
    coil = (wire.first + BEGINNING, wire.last - BEGINNING)
    signs = (layout.flips[0], 1, layout.flips[1])
    return FreeWire(vertices[:-2].reshape(-1, count, 3), vertices[-2:], coil, signs)
