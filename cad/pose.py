"""The shape of the spring at a joint angle: bent between its seats, from ``cad.flexed_wire``."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from synth.cad.arm_layout import OVERHANG
from synth.cad.dimensions import JointDimensions
from synth.cad.flexed_wire import FlexedWire, flex_wire
from synth.cad.layout import JointLayout
from synth.cad.parts import Array


@lru_cache(maxsize=512)
def _flexed_wire(radius: float, coils: float, arm: float, closing: float) -> FlexedWire | None:
    return flex_wire(radius, coils, arm, closing)


def loaded_wire(dimensions: JointDimensions, layout: JointLayout, angle: float) -> FlexedWire:
    """The bent wire at the measured joint ``angle``, deg, in its own frame.

    Raises
    ------
    ValueError
        if the wire cannot be bent so far; this does not occur within the travel of a checked layout.
    """
    spring = dimensions.spring
    closing = round(dimensions.closing(angle), 6)
    wire = _flexed_wire(spring.radius, spring.drawn_coils, round(layout.free_arm, 6), closing)
    if wire is None:
        raise ValueError(f"no shape of the spring at {angle:g} deg")
    return wire


def loaded_line(dimensions: JointDimensions, layout: JointLayout, angle: float) -> Array:
    """Points (n, 3) mm on the wire's centre line at the measured joint ``angle`` (deg), canonical upper frame.

    From the lower arm's tip to the upper's. Both ends are in their seats. Along the hinge axis the coil keeps its pitch
    about its middle, so its length grows as it winds; the free arms compensate for it.
    """
    closing, wire = dimensions.closing(angle), loaded_wire(dimensions, layout, angle)
    # The wire's own frame: the still arm is the lower one, its tangent point on +x, winding counter-clockwise.
    seat = layout.seat.length + OVERHANG
    end = math.pi / 2 + float(np.sum(wire.curvature * np.diff(wire.lengths)))
    first = wire.points[:1] + seat * np.array([[0.0, -1.0]])
    last = wire.points[-1:] + seat * np.array([[math.cos(end), math.sin(end)]])
    flat = np.vstack([first, wire.points, last])
    heights = _heights(dimensions, layout, wire, closing, seat)
    # The upper arm's direction is known in the upper frame; the whole is turned so that it lies there.
    turn = math.radians(layout.upper.direction) - end
    c, s = math.cos(turn), math.sin(turn)
    return np.column_stack([c * flat[:, 0] - s * flat[:, 1], s * flat[:, 0] + c * flat[:, 1], heights])


def _heights(dimensions: JointDimensions, layout: JointLayout, wire: FlexedWire, closing: float, seat: float) -> Array:
    """Z (n + 2,) mm along the wire: sloped in seats and coil, between them as the free arms have to."""
    slope = layout.upper.slope
    coils = dimensions.spring.drawn_coils
    lengths = wire.lengths - wire.lengths[wire.first]
    total = lengths[wire.last]
    middle = layout.coil_start + layout.coil_height / 2
    wound = layout.coil_height * (coils + closing / 360.0) / coils
    coil = middle + wound * (lengths / total - 0.5)
    bottom = layout.coil_start + slope * lengths  # where the unloaded wire lies
    heights = np.where((lengths >= 0.0) & (lengths <= total), coil, bottom)
    off = coil[wire.first] - layout.coil_start
    before, after = lengths < 0.0, lengths > total
    arm = -lengths[0]
    blend = np.zeros_like(lengths)
    blend[before] = off * (1.0 + lengths[before] / arm)
    blend[after] = -off * (1.0 - (lengths[after] - total) / arm)
    heights = heights + np.where(before | after, blend, 0.0)
    return np.concatenate([[bottom[0] - slope * seat], heights, [bottom[-1] + slope * seat]])
