"""The scale by which a seat is turned: marks and a pit in the ear, marks on the seat plate under the ear's window.

The ear's marks stand outside the window, those of the plate show in it; together they are a vernier. The middle mark of
either is longer, and on the ear it runs into the window: where these two meet, the seat is at 0. A pit on the window's
inner side is at its plus end: turning the seat towards it increases the free angle.
"""

from __future__ import annotations

import math
from typing import Any

from synth.cad import kernel
from synth.cad.dimensions import JointDimensions
from synth.cad.hardware import screw_of
from synth.cad.layout import VERNIER, VERNIER_STEP, JointLayout, ear_radius, window_half
from synth.cad.outline import Point, unit

MARK = (0.5, 0.5)  # mm, width and depth of a scale's marks: printable with one line of 0.4 mm
PIT = 0.5  # mm, radius of the pit, which is as deep as a mark
LINE = 0.4  # mm, least print left between the pit and another cut, and at the ear's edge: one line
ASIDE = 0.3  # mm, from the window's edges to the marks
SCALE_STEP = 5.0  # deg, between the ear's marks
SHORT = 0.6  # most length of the other marks, over that of the middle one: told apart at a glance


def scale_marks(layout: JointLayout) -> list[float]:
    """Directions (deg) of the ear's marks, every 5 deg over the seat's travel and the vernier's ends."""
    count = math.floor((layout.plate.travel + VERNIER_STEP * VERNIER[-1]) / SCALE_STEP)
    return [layout.plate.window + SCALE_STEP * index for index in range(-count, count + 1)]


def zero_ends(dimensions: JointDimensions, layout: JointLayout) -> tuple[float, float]:
    """Radii (mm) between which the ear's middle mark runs: from the window's edge to a line from the ear's."""
    plate = layout.plate
    outer = plate.radius + screw_of(layout.seat.screw).washer / 2 + ASIDE
    return plate.radius + _half(layout), max(outer, ear_radius(plate, dimensions) - LINE)


def mark_ends(dimensions: JointDimensions, layout: JointLayout) -> tuple[float, float]:
    """Radii (mm) between which the ear's other marks run, outside the window."""
    edge, end = zero_ends(dimensions, layout)
    inner, outer = edge + ASIDE, layout.plate.radius + screw_of(layout.seat.screw).washer / 2 + ASIDE
    return inner, min(outer, inner + SHORT * (end - edge))


def plus_pit(dimensions: JointDimensions, layout: JointLayout) -> Point:
    """The pit (mm) on the window's inner side, at the end towards which the free angle grows.

    No mark is there, and it ends before the window does; the grooves for a pair's sunk heads begin farther.
    """
    radius = layout.plate.radius - _half(layout) - LINE - PIT
    end = window_half(layout.plate.travel) - math.degrees(math.asin((PIT + LINE) / radius))
    x, y = unit(layout.plate.window - dimensions.closes * end)
    return radius * x, radius * y


def ear_marks(dimensions: JointDimensions, layout: JointLayout, top: float) -> list[Any]:
    """Cuts of marks and pit in an ear whose outer face is at ``top`` mm."""
    inner, outer = zero_ends(dimensions, layout)
    middle = layout.plate.window
    cuts = [_mark(angle, *mark_ends(dimensions, layout), top) for angle in scale_marks(layout) if angle != middle]
    cuts.append(_mark(middle, inner - ASIDE, outer, top))  # begins inside the window: no face touches the window's
    x, y = plus_pit(dimensions, layout)
    return [*cuts, kernel.cylinder(PIT, MARK[1] + 1.0, (x, y, top - MARK[1]))]


def ear_marks_volume(dimensions: JointDimensions, layout: JointLayout) -> float:
    """Volume (mm^3) of the marks and the pit in an ear, outside its window."""
    inner, outer = mark_ends(dimensions, layout)
    others = (len(scale_marks(layout)) - 1) * (outer - inner) * MARK[0]
    edge, end = zero_ends(dimensions, layout)
    half = MARK[0] / 2
    # The middle mark is a strip from the window's edge, an arc, to a straight end.
    middle = end * MARK[0] - (half * math.sqrt(edge**2 - half**2) + edge**2 * math.asin(half / edge))
    return (others + middle + math.pi * PIT**2) * MARK[1]


def plate_marks(layout: JointLayout) -> list[Any]:
    """Cuts of the vernier's marks in the seat plate, with the seat in the middle of its travel."""
    plate, half = layout.plate, _half(layout) - ASIDE
    return [
        _mark(
            plate.window + VERNIER_STEP * index,
            plate.radius + half - 2 * half * (1.0 if index == 0 else SHORT),
            plate.radius + half,
            plate.top,
        )
        for index in VERNIER
    ]


def _half(layout: JointLayout) -> float:
    """Half of the window's width along the radius, mm: it is as wide as the slots of the seat's screws."""
    return screw_of(layout.seat.screw).hole / 2


def _mark(angle: float, inner: float, outer: float, face: float) -> Any:
    """A mark along the radius in a ``direction``, deg, cut into a face at a height, mm."""
    block = kernel.block((outer - inner, MARK[0], MARK[1] + 1.0), (inner, -MARK[0] / 2, face - MARK[1]))
    return block.rotate((0, 0, 0), (0, 0, 1), angle)
