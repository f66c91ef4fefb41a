"""The hinge's shaft, its rings and pins, and the cross-sections that drive a damper.

A section is round, a D (a disc with a flat), a square or a hexagon; its size is the diameter, or across the flats. All
flats of a D stand on the +x side.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal

from synth.cad import kernel

Form = Literal["round", "d", "square", "hex"]
FORMS: tuple[Form, ...] = ("round", "d", "square", "hex")
SIDES: dict[Form, int] = {"square": 4, "hex": 6}  # of a section
FLAT_DEPTH = 0.1  # of the shaft's diameter: depth of the flat of a D-shaft
PUSHED = 0.004  # of a shaft's diameter: drawn clearance of the bores on it, so that chords of meshes do not touch
LEAST_PUSHED = 0.02  # mm: chord error of the meshes


def loose(diameter: float) -> float:
    """Diameter (mm) at which the bore of a bearing, collar or washer is drawn."""
    return diameter + 2 * max(LEAST_PUSHED, PUSHED * diameter / 2)


def circumradius(form: Form, size: float) -> float:
    """Radius (mm) of the circle round a section."""
    return size / 2 / math.cos(math.pi / SIDES[form]) if form in SIDES else size / 2


def flat_distance(form: Form, size: float) -> float:
    """Distance (mm) of a flat from the axis."""
    return size * (0.5 - FLAT_DEPTH) if form == "d" else size / 2


def build_section(form: Form, size: float, grow: float, bottom: float, top: float) -> Any:
    """A section as a cadquery Solid along z, ``grow`` mm larger on every side."""
    if form in SIDES:
        count, radius = SIDES[form], circumradius(form, size + 2 * grow)
        turns = [math.radians(180.0 / count + 360.0 * k / count) for k in range(count)]
        corners = [(radius * math.cos(turn), radius * math.sin(turn), bottom) for turn in turns]
        return kernel.prism(corners, (0.0, 0.0, top - bottom))
    rod = kernel.cylinder(size / 2 + grow, top - bottom, (0.0, 0.0, bottom))
    if form == "round":
        return rod
    flat = flat_distance(form, size) + grow
    block = kernel.block((size, 2 * size, top - bottom), (flat, -size, bottom))
    return rod.cut(block).Solids()[0]


def section_area(form: Form, size: float, grow: float = 0.0) -> float:
    """Area (mm^2) of a section."""
    if form in SIDES:
        return SIDES[form] * (size / 2 + grow) ** 2 * math.tan(math.pi / SIDES[form])
    radius = size / 2 + grow
    return math.pi * radius**2 - (_segment(radius, flat_distance(form, size) + grow) if form == "d" else 0.0)


def milled_area(form: Form, size: float, diameter: float) -> float:
    """Area (mm^2) of a section milled from a round rod: what both have in common."""
    radius = diameter / 2
    if form == "round":
        return math.pi * radius**2
    if circumradius(form, size) <= radius:
        return section_area(form, size)
    return math.pi * radius**2 - SIDES.get(form, 1) * _segment(radius, flat_distance(form, size))


def _segment(radius: float, distance: float) -> float:
    """Area (mm^2) of the segment of a disc beyond a line at a distance (mm) from its centre."""
    if distance >= radius:
        return 0.0
    half = math.acos(distance / radius)
    return radius**2 * (half - math.sin(half) * math.cos(half))


@dataclass(frozen=True)
class ShaftShape:
    """The hinge's shaft: a stock rod, its end for the damper, pin holes and a magnet's pocket; mm."""

    diameter: float
    bottom: float
    top: float
    form: Form  # of the lower end
    form_size: float
    form_length: float  # 0: the end is round
    pins: tuple[tuple[float, float, float], ...]  # height, diameter and direction (deg) of each cross hole
    pocket: tuple[float, float]  # diameter and depth of a magnet's pocket in the upper end


def build_shaft(shape: ShaftShape) -> Any:
    """The shaft as one cadquery Solid."""
    radius, (wide, deep) = shape.diameter / 2, shape.pocket
    rod = kernel.cylinder(radius, shape.top - shape.bottom, (0.0, 0.0, shape.bottom))
    cuts = [cross_hole(height, size / 2, 2 * shape.diameter, turn) for height, size, turn in shape.pins]
    if shape.form != "round" and shape.form_length > 0.0:
        low, high = shape.bottom - 1.0, shape.bottom + shape.form_length
        ring = kernel.cylinder(2 * shape.diameter, high - low, (0.0, 0.0, low))
        cuts.append(ring.cut(build_section(shape.form, shape.form_size, 0.0, low - 1.0, high + 1.0)))
    if deep > 0.0:
        cuts.append(kernel.cylinder(wide / 2, deep + 1.0, (0.0, 0.0, shape.top - deep)))
    return rod.cut(*cuts).Solids()[0] if cuts else rod


def shaft_volume(shape: ShaftShape) -> float:
    """Volume of :func:`build_shaft`, mm^3."""
    round_area = math.pi * shape.diameter**2 / 4
    end = 0.0 if shape.form == "round" else shape.form_length
    volume = round_area * (shape.top - shape.bottom - end)
    volume += end * milled_area(shape.form, shape.form_size, shape.diameter)
    volume -= sum(cross_volume(shape.diameter / 2, 0.0, size / 2) for _, size, _ in shape.pins)
    return volume - math.pi * shape.pocket[0] ** 2 / 4 * shape.pocket[1]


def cross_hole(height: float, radius: float, reach: float, turn: float, start: float | None = None) -> Any:
    """A cylinder square to the hinge at a height, from ``start`` (mm; None: -reach) to ``reach`` along ``turn`` deg."""
    low = -reach if start is None else start
    x, y = math.cos(math.radians(turn)), math.sin(math.radians(turn))
    return kernel.cylinder(radius, reach - low, (low * x, low * y, height), (x, y, 0.0))


@lru_cache(maxsize=256)  # a leg's parts ask for a dozen, each time that they are drawn or weighed
def cross_volume(outer: float, inner: float, radius: float) -> float:
    """Volume (mm^3) that a cross hole of a radius takes from a tube of outer and inner radius.

    The integral of the chords over the hole. x = a sin t turns the disc's edge into a smooth periodic integrand, on
    which the trapezoid rule is exact.
    """
    import numpy as np

    t = (np.arange(400) + 0.5) / 400 * math.pi - math.pi / 2
    x, width = radius * np.sin(t), 2 * radius * np.cos(t)
    chord = 2 * (np.sqrt(outer**2 - x**2) - np.sqrt(np.maximum(inner**2 - x**2, 0.0)))
    return float(np.sum(chord * width * radius * np.cos(t)) * math.pi / 400)


def build_ring(outer: float, bore: float, bottom: float, top: float) -> Any:
    """A ring (cadquery Solid) about the hinge axis: bearing, collar or thrust washer, by its diameters (mm)."""
    return kernel.placed(_ring, (outer, bore, top - bottom), (0.0, 0.0, bottom))


def _ring(outer: float, bore: float, height: float) -> Any:
    body = kernel.cylinder(outer / 2, height)
    return body.cut(kernel.cylinder(bore / 2, height + 2, (0.0, 0.0, -1.0))).Solids()[0]


def ring_volume(outer: float, bore: float, height: float) -> float:
    """Volume of :func:`build_ring`, mm^3."""
    return math.pi / 4 * (outer**2 - bore**2) * height


def build_pin(size: float, length: float, height: float, turn: float) -> Any:
    """A dowel pin through the hinge axis."""
    return cross_hole(height, size / 2, length / 2, turn)
