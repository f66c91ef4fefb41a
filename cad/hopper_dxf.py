"""A flat layer as DXF: outlines to cut on layer CUT, fold lines on layer FOLD, millimetres."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from cad.dxf import drawing

HOLE_DIAMETER = 1.6  # mm


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
        """All outlines and holes together, mm."""
        outlines = sum(2 * (end - begin + self.width) for begin, end in self.plates)
        return outlines + len(self.holes) * 3.141592653589793 * HOLE_DIAMETER

    @property
    def area(self) -> float:
        """Of the plates, without holes, mm^2."""
        return sum(end - begin for begin, end in self.plates) * self.width

    @property
    def folded(self) -> bool:
        """Whether it runs through the hinges."""
        return len(self.plates) == 1


def write_layer(layer: Layer, path: Path) -> None:
    """Write the layer; the same layer gives the same bytes."""
    with drawing(path) as (document, space):
        document.layers.add("FOLD", color=5, linetype="CONTINUOUS")
        for begin, end in layer.plates:
            corners = [(begin, 0.0), (end, 0.0), (end, layer.width), (begin, layer.width)]
            space.add_lwpolyline(corners, close=True, dxfattribs={"layer": "CUT"})
        for x, y in layer.holes:
            space.add_circle((x, y), 0.5 * HOLE_DIAMETER, dxfattribs={"layer": "CUT"})
        if layer.folded:
            for x in layer.folds:
                space.add_line((x, 0.0), (x, layer.width), dxfattribs={"layer": "FOLD"})
