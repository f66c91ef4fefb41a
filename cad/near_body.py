"""A body of which only what lies near another one is tested. A boolean operation costs as much as both meshes are long.

What lies outside the other body's bounding box cannot overlap it, and what lies farther from that box than a distance
is not within that distance. So the result is that of the whole body; the faces of the cut lie outside the box.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from synth.cad.parts import Array

# mm, by which a box is larger than asked for: the cut's faces touch nothing, and the poses of a spring two degrees
# apart, whose boxes differ by less, are tested with one cut.
MARGIN = 2.0


def box_of(body: Any) -> tuple[Array, Array]:
    """Least and largest coordinates (3,) of a manifold3d solid, mm."""
    found = np.array(body.bounding_box())
    return found[:3], found[3:]


class NearBody:
    """A manifold3d solid, cut to the boxes that are asked for; the last cut serves again where it is large enough."""

    def __init__(self, body: Any) -> None:
        self._body = body
        self._low, self._high = np.full(3, np.inf), np.full(3, -np.inf)
        self._cut: Any = None

    def near(self, other: Any, distance: float = 0.0) -> Any:
        """The solid as far as it is within ``distance`` mm of another one's bounding box, and some more of it."""
        low, high = box_of(other)
        return self.within(low - distance, high + distance)

    def within(self, low: Array, high: Array) -> Any:
        """The solid as far as it is in the box between two corners (3,) mm, and some more of it."""
        if self._cut is None or np.any(low < self._low) or np.any(high > self._high):
            self._low, self._high = np.minimum(self._low, low - MARGIN), np.maximum(self._high, high + MARGIN)
            self._cut = self._body ^ box_between(self._low, self._high)
        return self._cut


def box_between(low: Array, high: Array) -> Any:
    """A manifold3d cuboid between two corners (3,), mm."""
    import manifold3d

    return manifold3d.Manifold.cube(tuple(high - low)).translate(tuple(low))
