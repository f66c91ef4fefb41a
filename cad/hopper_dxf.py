"""A flat layer as DXF: what is cut on layer CUT, fold lines on FOLD, finished plates on PLATE, millimetres."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from synth.cad.dxf import drawing

HOLE_DIAMETER = 1.6  # mm: clearance hole, M1.6
MARGIN = 10.0  # mm of frame round the strip: room for the dowels
OVER = 2.0  # mm, extension of a hinge's window beyond the strip's edges, so that the release cut crosses it
DOWEL = 3.0  # mm, ISO 2338: dowel pins that align the stacked layers


@dataclass(frozen=True)
class Layer:
    """One layer of the strip: plates from ``begin`` to ``end`` (mm) along it, hinge axes and screw holes.

    A layer without a gap at a hinge is one plate; its hinge axes are then fold lines.
    """

    name: str
    material: str
    thickness: float
    width: float
    plates: tuple[tuple[float, float], ...]
    folds: tuple[float, ...]
    holes: tuple[tuple[float, float], ...]

    @property
    def cut_length(self) -> float:
        """Total length of outlines and holes, mm."""
        outlines = sum(2 * (end - begin + self.width) for begin, end in self.plates)
        return outlines + len(self.holes) * 3.141592653589793 * HOLE_DIAMETER

    @property
    def area(self) -> float:
        """Area of the plates, without holes, mm^2."""
        return sum(end - begin for begin, end in self.plates) * self.width

    @property
    def folded(self) -> bool:
        """Whether it continues through the hinges."""
        return len(self.plates) == 1


def windows(layer: Layer) -> tuple[tuple[float, float], ...]:
    """Begin and end (mm) of the gaps in a layer at each hinge, between successive plates."""
    pairs = zip(layer.plates, layer.plates[1:], strict=False)
    return tuple((before[1], after[0]) for before, after in pairs)


def alignment(layer: Layer) -> tuple[tuple[float, float], ...]:
    """Positions of the dowel holes in the frame, equal in every layer: at both ends and the middle, above and below.

    One of them is 2 mm off the symmetric position, so that no layer can be stacked the wrong way round.
    """
    end = layer.plates[-1][1]
    low, high = -0.5 * MARGIN, layer.width + 0.5 * MARGIN
    places = [(x, y) for x in (0.0, 0.5 * end, end) for y in (low, high)]
    return (*places[:-1], (end - 2.0, high))


def write_layer(layer: Layer, path: Path, kerf: float) -> None:
    """Write the layer as cut before lamination; the same layer gives the same bytes.

    The strip stays in its frame. At each hinge a window is cut that extends beyond both edges; the frame has the dowel
    holes, and every plate is attached to it by its long edges. The release cut through all layers removes these
    bridges. Cut outlines are drawn smaller by half the ``kerf`` (mm) on every side. PLATE has the finished outlines,
    which are not cut.
    """
    half, end = 0.5 * kerf, layer.plates[-1][1]
    with drawing(path) as (document, space):
        document.layers.add("FOLD", color=5, linetype="CONTINUOUS")
        document.layers.add("PLATE", color=8, linetype="CONTINUOUS")
        for begin, stop in layer.plates:
            _rectangle(space, (begin, stop), (0.0, layer.width), "PLATE")
        for begin, stop in windows(layer):
            _rectangle(space, (begin + half, stop - half), (-OVER + half, layer.width + OVER - half), "CUT")
        _rectangle(space, (-MARGIN, end + MARGIN), (-MARGIN - half, layer.width + MARGIN + half), "CUT")
        for x, y in layer.holes:
            space.add_circle((x, y), 0.5 * HOLE_DIAMETER - half, dxfattribs={"layer": "CUT"})
        for x, y in alignment(layer):
            space.add_circle((x, y), 0.5 * DOWEL - half, dxfattribs={"layer": "CUT"})
        if layer.folded:
            for x in layer.folds:
                space.add_line((x, 0.0), (x, layer.width), dxfattribs={"layer": "FOLD"})


def write_release(layer: Layer, path: Path, kerf: float) -> None:
    """Write the last cut through the whole laminate: the strip's outline, half the kerf outside it."""
    half = 0.5 * kerf
    with drawing(path) as (_, space):
        _rectangle(space, (-half, layer.plates[-1][1] + half), (-half, layer.width + half), "CUT")


def _rectangle(space: Any, x: tuple[float, float], y: tuple[float, float], layer: str) -> None:
    corners = [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])]
    space.add_lwpolyline(corners, close=True, dxfattribs={"layer": layer})
