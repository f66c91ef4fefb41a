"""Flat outlines of a joint's parts, seen along the hinge axis. Arithmetic only, no solids."""

from __future__ import annotations

from synth.cad.arm_layout import RIM
from synth.cad.dimensions import JointDimensions
from synth.cad.hardware import insert_of
from synth.cad.layout import VERNIER, VERNIER_STEP, JointLayout, bearing_pocket, ear_radius
from synth.cad.outline import Disc, Hull, Point, hull_of, unit


def _corners(layout: JointLayout, way: int) -> list[Disc]:
    """The fillets between a half and its socket: the upper one's (+1), the lower one's (-1)."""
    radius = layout.web_thickness / 2
    side = layout.socket_outer - radius
    end = layout.upper_bottom if way > 0 else layout.lower_bottom
    return [Disc(x, way * (end - radius), radius) for x in (-side, side)]


def ear_outlines(dimensions: JointDimensions, layout: JointLayout) -> tuple[Hull, Hull]:
    """Outlines of ear A (damper's side) and ear B (seat plate's side; of a pair of springs both are)."""
    hub = max(dimensions.shaft_diameter / 2 + dimensions.wall, bearing_pocket(dimensions)) + dimensions.wall
    hub = max(hub, dimensions.hardware.radius)
    seat = ear_radius(layout.plate, dimensions)
    on_a = seat if layout.mirrored else 0.0
    ear_a = hull_of([Disc(0.0, 0.0, max(hub, layout.bracket_radius, on_a)), *_corners(layout, 1)])
    ear_b = hull_of([Disc(0.0, 0.0, max(hub, layout.seat_radius, seat)), *_corners(layout, 1)])
    return ear_a, ear_b


def web_outline(layout: JointLayout) -> Hull:
    """The web between the ears seen along z, with corner radii equal to its thickness."""
    return hull_of(_corners(layout, 1))


def cup_outline(layout: JointLayout) -> Hull:
    """The tongue's cup and stem."""
    return hull_of([Disc(0.0, 0.0, layout.space.tongue_radius), *_corners(layout, -1)])


def floor_outline(layout: JointLayout) -> Hull:
    """The tongue's floor plate: under the cup and round the lower arm's seat."""
    return hull_of([*cup_outline(layout).discs, *layout.lower.outline().discs])


def plate_outline(layout: JointLayout) -> Hull:
    """The seat plate: round the shaft, the arm's seat, the screws, and the vernier's marks on the screws' circle."""
    plate, rim = layout.plate, insert_of(layout.seat.screw).hole / 2 + RIM
    discs = [Disc(0.0, 0.0, plate.hub), *layout.upper.outline().discs]
    ends = [unit(plate.window + VERNIER_STEP * step) for step in (VERNIER[0], VERNIER[-1])]
    places = [*plate.screws, *((plate.radius * x, plate.radius * y) for x, y in ends)]
    return hull_of([*discs, *(Disc(x, y, rim) for x, y in places)])


def mount_screws(dimensions: JointDimensions, layout: JointLayout) -> list[Point]:
    """The four screws' axes (mm) in the flange: across the ears (x) and along the hinge axis (z)."""
    mount = dimensions.mount
    assert mount is not None
    across = mount.spacing_across if mount.spacing_across is not None else mount_across(dimensions, layout)
    return [(x * across / 2, z * mount.spacing_along / 2) for x in (-1, 1) for z in (-1, 1)]


def mount_across(dimensions: JointDimensions, layout: JointLayout) -> float:
    """Smallest distance (mm) of the mount's screws across the ears, which spread below the flange.

    A head is twice as wide as its hole and as high as that is wide.
    """
    bolt = dimensions.mount.bolt_diameter if dimensions.mount is not None else 0.0
    ears = max(hull.half_width_above(layout.upper_bottom - bolt) for hull in ear_outlines(dimensions, layout))
    return 2 * (ears + bolt + dimensions.clearance)


def flange_size(dimensions: JointDimensions, layout: JointLayout) -> tuple[float, float]:
    """Across and along (mm): over the screws' rims, and at least over the ears."""
    mount = dimensions.mount
    assert mount is not None
    rim = mount.bolt_diameter + 2 * dimensions.wall
    (x, z) = mount_screws(dimensions, layout)[-1]
    return 2 * x + rim, max(2 * z + rim, 2 * (max(layout.gap_a, layout.gap_b) + layout.ear))


def _block(half: float, start: float, end: float) -> Hull:
    """A rectangle of a half width across the link's line, from ``start`` to ``end`` along it (y), mm."""
    return hull_of([Disc(x, y, 0.0) for x in (-half, half) for y in (start, end)])


def _link(dimensions: JointDimensions, layout: JointLayout, start: float, way: int) -> list[Hull]:
    """A socket from y = ``way * start`` outwards and the tube in it, as long as the joint's own link."""
    tube = _block(dimensions.link_width / 2, way * start, way * (start + dimensions.link_length))
    return [_block(layout.socket_outer, way * start, way * (start + layout.socket_depth)), tube]


def upper_bodies(dimensions: JointDimensions, layout: JointLayout) -> list[Hull]:
    """Parts of the upper half that cross z = 0: the web with its parts, the socket with its tube, or the flange."""
    start = layout.upper_bottom
    if dimensions.mount is None:
        return [web_outline(layout), *_link(dimensions, layout, start, 1)]
    across, _ = flange_size(dimensions, layout)
    return [web_outline(layout), _block(across / 2, start, start + dimensions.mount.thickness)]


def lower_bodies(dimensions: JointDimensions, layout: JointLayout) -> list[Hull]:
    """Parts of the lower half that meet those: floor plate, socket and tube (its horns should), at q = 0."""
    return [floor_outline(layout), *_link(dimensions, layout, layout.lower_bottom, -1)]
