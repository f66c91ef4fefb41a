"""Sizing: dimensions that the user left open grow until the parts bear their loads."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from typing import Any

from synth.cad.arm_layout import seat_size
from synth.cad.checked_layout import clear_upper_arm_angle, lay_out
from synth.cad.dimensions import JointDimensions
from synth.cad.fittings import PrintDimensions
from synth.cad.hardware import screws, shaft_sizes
from synth.cad.layout import floor_of
from synth.cad.limits import DimensionError
from synth.cad.strength import ALL_AROUND, Stress, stresses, tube_modulus

STOCK: dict[str, tuple[float, ...]] = {  # mm, as screws and ground shafts are sold
    "seat_screw": tuple(screw.size for screw in screws()),
    "shaft_diameter": shaft_sizes(),
}
# Round aluminium tube, outer diameter and wall in mm, each with a larger section modulus than the one before. The sizes
# are common ones of EN AW-6060, from memory; a project states what its dealer has.
TUBES = ((20.0, 1.5), (20.0, 2.0), (25.0, 2.0), (30.0, 2.0), (35.0, 2.0), (40.0, 2.0), (50.0, 2.0), (50.0, 3.0),
         (60.0, 3.0), (80.0, 3.0))  # fmt: skip
SIZED = ("seat_screw", "seat_length", "cap", "floor", "adapter.output_grip", "socket", "link_width")
# The three ways in which a part may lie on the bed.
WORST_LAYERS = (ALL_AROUND[0], ALL_AROUND[1], (0.0, 0.0, 1.0))


def overload(stress: Stress, printing: PrintDimensions) -> float:
    """Stress over the allowable stress in the best print orientation; at most 1 if the part bears the load."""
    return min(stress.value / stress.allowed(printing, layers) for layers in WORST_LAYERS)


def sized(
    dimensions: JointDimensions, printing: PrintDimensions, open_to_change: Collection[str] = SIZED
) -> JointDimensions:
    """The joint with the smallest steps of its open dimensions for which all parts bear their loads.

    A dimension whose next step does not fit the joint is left unchanged; parts that still fail are reported by the
    checks.

    Raises
    ------
    DimensionError
        if the joint does not fit with its initial dimensions.
    """
    lay_out(dimensions)
    while True:
        failing = [s for s in stresses(dimensions, lay_out(dimensions), printing) if overload(s, printing) > 1.0]
        steps = {n: larger for s in failing for n in s.helped_by if n in open_to_change
                 if (larger := _larger(dimensions, n)) is not None}  # fmt: skip
        if not steps:
            return dimensions
        dimensions = min(steps.values(), key=lambda tried: _cost(dimensions, tried, printing))


def _cost(now: JointDimensions, tried: JointDimensions, printing: PrintDimensions) -> float:
    """Added volume of print and steel (relative, approximate) over the overload that a step removes."""
    added = sum(
        weight * (after - before)
        for weight, before, after in (
            (1.0, now.floor_thickness, tried.floor_thickness),
            (0.5, now.cap, tried.cap),
            (1.0, seat_size(now).length, seat_size(tried).length),
            (2.0, seat_size(now).screw, seat_size(tried).screw),
            (1.0, now.shaft_diameter, tried.shaft_diameter),
            (1.0, now.socket_depth, tried.socket_depth),
            (1.0, now.link_width, tried.link_width),
        )
    )
    # At least half a millimetre counts, so that a step without growth does not win at any gain.
    return max(added, 0.5) / max(_excess(now, printing) - _excess(tried, printing), 1e-6)


def _excess(dimensions: JointDimensions, printing: PrintDimensions) -> float:
    """Summed overload beyond 1."""
    found = (overload(stress, printing) for stress in stresses(dimensions, lay_out(dimensions), printing))
    return sum(max(0.0, value - 1.0) for value in found)


def _larger(dimensions: JointDimensions, name: str) -> JointDimensions | None:
    """The joint with one dimension a step larger; None if that is not sold, not allowed or does not fit."""
    adapter = dimensions.damper.adapter
    if name.startswith("adapter."):
        if adapter is None:
            return None
        key = name.removeprefix("adapter.")
        grown = replace(adapter, **{key: getattr(adapter, key) + 1.0})
        tried = replace(dimensions, damper=replace(dimensions.damper, adapter=grown))
    elif name == "link_width":
        tube = _stronger_tube(dimensions)
        if tube is None:
            return None
        tried = replace(dimensions, link_width=tube[0], tube_wall=tube[1])
    else:
        now = _drawn_value(dimensions, name)
        larger = [size for size in STOCK.get(name, (now + 1.0,)) if size > now]
        if not larger:
            return None
        change: dict[str, Any] = {name: larger[0]}
        tried = replace(dimensions, **change)
    try:
        return replace(tried, upper_arm_angle=_arm_angle(tried))
    except DimensionError:
        return None


def _stronger_tube(dimensions: JointDimensions) -> tuple[float, float] | None:
    """The next stock tube, diameter and wall in mm, that bears more and is not narrower; None if none is sold."""
    now = tube_modulus(dimensions.link_width, dimensions.tube_wall)
    return next((tube for tube in TUBES if tube_modulus(*tube) > now and tube[0] >= dimensions.link_width), None)


def _drawn_value(dimensions: JointDimensions, name: str) -> float:
    """A dimension as drawn, including derived ones that are left open."""
    seat = seat_size(dimensions)
    drawn = {
        "floor": floor_of(dimensions, seat), "seat_screw": seat.screw, "seat_length": seat.length,
        "socket": dimensions.socket_depth,
    }  # fmt: skip
    return drawn[name] if name in drawn else float(getattr(dimensions, name))


def _arm_angle(dimensions: JointDimensions) -> float:
    """The upper arm's angle, unchanged if it is still possible, else another."""
    try:
        lay_out(dimensions)
    except DimensionError:
        return clear_upper_arm_angle(dimensions)
    return dimensions.upper_arm_angle
