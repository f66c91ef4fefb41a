"""A torsion spring as a dimensioned DXF drawing with all data for a maker's quotation.

Two views at full size in millimetres: along the axis (coil, arms, angle between them, diameters) and from the side
(body, wire, hand), and the table of the request beside them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from synth.cad.dxf import drawing

TEXT = 2.5  # mm, height of letters: the smallest of ISO 3098 in common use


@dataclass(frozen=True)
class SpringRequest:
    """The drawing's data; lengths mm, angles deg.

    ``included_angle`` between tangent arms of ``arm`` length, ``coils`` of the body; ``lines`` are the request's text.
    ``mirrored``: a second spring, the mirror image of the drawn one, is asked for too.
    """

    wire: float
    mean: float
    coils: float
    body: float
    included_angle: float
    arms: tuple[float, float]
    hand: str
    lines: Sequence[str]
    mirrored: bool = False


def write_spring_request(request: SpringRequest, path: Path) -> None:
    """Write the drawing: outlines on layer PART, dimensions on DIM, text on TEXT."""
    with drawing(path) as (document, space):
        for layer, color in (("PART", 7), ("DIM", 1), ("CENTRE", 4), ("TEXT", 3)):
            document.layers.add(layer, color=color)
        _along_the_axis(space, request)
        offset = request.mean / 2 + request.wire + max(request.arms) + 12.0 * TEXT
        _from_the_side(space, request, offset)
        _words(space, request, offset + request.body + 10.0 * TEXT)


def _along_the_axis(space: Any, request: SpringRequest) -> None:
    """Coil as two circles, arms as tangents at their angle, with diameters and the angle between the arms."""
    outer, inner = (request.mean + request.wire) / 2, (request.mean - request.wire) / 2
    for radius in (outer, inner):
        space.add_circle((0.0, 0.0), radius, dxfattribs={"layer": "PART"})
    space.add_circle((0.0, 0.0), request.mean / 2, dxfattribs={"layer": "CENTRE"})
    sense = 1.0 if request.hand == "right" else -1.0
    for (begin, direction), length, outwards in zip(arm_axes(request), request.arms, (sense, -sense), strict=True):
        for side in (-0.5, 0.5):
            normal = (-direction[1] * side * request.wire, direction[0] * side * request.wire)
            start = (begin[0] + normal[0], begin[1] + normal[1])
            end = (start[0] + direction[0] * length, start[1] + direction[1] * length)
            space.add_line(start, end, dxfattribs={"layer": "PART"})
        end = (begin[0] + direction[0] * length, begin[1] + direction[1] * length)
        _dimension(space, begin, end, outwards * (request.wire / 2 + 3.0 * TEXT), f"{length:.2f}")
    low = -outer - max(request.arms) - 4.0 * TEXT
    _dimension(space, (-outer, low), (outer, low), 0.0, f"%%c{2 * outer:.2f} outside")
    _dimension(space, (-inner, low - 3 * TEXT), (inner, low - 3 * TEXT), 0.0, f"%%c{2 * inner:.2f} inside, free")
    _text(space, (-outer, low - 6 * TEXT), f"{request.included_angle:.1f} deg between the arms, free")


def arm_axes(request: SpringRequest) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    """The point where each arm, near and far, leaves the mean circle, and its direction.

    The near arm points down; the wire runs on round the circle, so that the far one leaves along it as well.
    """
    radius = request.mean / 2
    sense = 1.0 if request.hand == "right" else -1.0
    near = ((sense * radius, 0.0), (0.0, -1.0))
    turned = math.radians(request.included_angle)
    direction = (sense * -math.sin(turned), -math.cos(turned))
    begin = (radius * direction[1] * sense, -radius * direction[0] * sense)
    return [near, (begin, direction)]


def _from_the_side(space: Any, request: SpringRequest, left: float) -> None:
    """Close-wound coils as oblique lines in the body's outline, with its length and the wire."""
    outer = (request.mean + request.wire) / 2
    corners = [(left, -outer), (left + request.body, -outer), (left + request.body, outer), (left, outer)]
    space.add_lwpolyline(corners, close=True, dxfattribs={"layer": "PART"})
    slant = request.wire if request.hand == "right" else -request.wire
    for k in range(math.floor(request.coils) + 1):
        x = left + (k + 0.5) * request.wire
        if left <= x <= left + request.body and left <= x + slant / 2 <= left + request.body:
            space.add_line((x, -outer), (x + slant / 2, outer), dxfattribs={"layer": "PART"})
    space.add_line((left - TEXT, 0.0), (left + request.body + TEXT, 0.0), dxfattribs={"layer": "CENTRE"})
    _dimension(space, (left, -outer), (left + request.body, -outer), -3.0 * TEXT, f"{request.body:.2f} body, free")
    hand = f"{request.hand}-hand" + (" as drawn, and one mirrored" if request.mirrored else "")
    _text(space, (left, outer + 2 * TEXT), f"wire %%c{request.wire:.3f}, {request.coils:.3f} coils, {hand}")


def _words(space: Any, request: SpringRequest, left: float) -> None:
    top = (request.mean + request.wire) / 2
    for k, line in enumerate(request.lines):
        _text(space, (left, top - 1.8 * TEXT * k), line)


def _dimension(space: Any, one: tuple[float, float], two: tuple[float, float], aside: float, text: str) -> None:
    """A dimension line ``aside`` of the measured points, with its text."""
    made = space.add_aligned_dim(
        p1=one, p2=two, distance=aside, text=text, override={"dimtxt": TEXT, "dimasz": TEXT, "dimexe": 1.0},
        dxfattribs={"layer": "DIM"},
    )  # fmt: skip
    made.render()


def _text(space: Any, at: tuple[float, float], text: str) -> None:
    space.add_text(text, height=TEXT, dxfattribs={"layer": "TEXT"}).set_placement(at)
