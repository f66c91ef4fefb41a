"""Where a joint's fittings lie and whether they fit: encoder, damper's adapter, mount. Arithmetic only, no solids."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from cad.dimensions import JointDimensions
from cad.fittings import DamperDimensions, EncoderDimensions
from cad.limits import DimensionProblem
from cad.outline import Point, unit

if TYPE_CHECKING:
    from cad.arm_layout import ArmLayout
    from cad.layout import JointLayout

LOOSEST_KEY = 0.06  # of the shaft's diameter; its flat is 0.1 deep
LEAST_BRIDGE = 1.2  # mm of print between an encoder's screw and an arm's shaft


def seat_radius(dimensions: JointDimensions) -> float:
    """Outside of the encoder's seat, mm; 0 without an encoder."""
    encoder = dimensions.encoder
    return 0.0 if encoder is None else encoder.bolt_circle / 2 + encoder.bolt_diameter / 2 + dimensions.wall


def seat_screws(encoder: EncoderDimensions, upper: ArmLayout) -> list[Point]:
    """Screw axes (mm) on the encoder's circle, turned so that they stand as far as can be from the arm's shafts."""
    return _farthest(encoder.bolt_circle, encoder.bolt_count, upper)


def damper_screws(damper: DamperDimensions, upper: ArmLayout | None) -> tuple[Point, ...]:
    """Screw axes (mm) on the damper's circle, turned so that none lies on the link's centre line.

    Where an ``upper`` arm's shafts stand in the same ear, turned so that they stand as far as can be from those.
    """
    if upper is not None:
        return tuple(_farthest(damper.bolt_circle, damper.bolt_count, upper))
    return tuple(_on_circle(damper.bolt_circle, damper.bolt_count, 90.0 + 180.0 / damper.bolt_count))


def _on_circle(diameter: float, count: int, start: float) -> list[Point]:
    corners = [unit(start + 360.0 * index / count) for index in range(count)]
    return [(diameter / 2 * x, diameter / 2 * y) for x, y in corners]


def _farthest(diameter: float, count: int, upper: ArmLayout) -> list[Point]:
    """``count`` points on a circle, turned so that they are as far as can be from the arm's shafts."""
    turned = (_on_circle(diameter, count, upper.direction + 10.0 * index / count) for index in range(36))
    return max(turned, key=lambda points: round(_nearest(points, upper), 6))


def _nearest(points: Sequence[Point], upper: ArmLayout) -> float:
    return min(math.dist(point, pin) for point in points for pin in (upper.bearing, upper.keeper))


def adapter_radius(dimensions: JointDimensions) -> float:
    """Outside of the damper's adapter, mm: a wall round the wider of the two bores."""
    adapter = dimensions.damper.adapter
    wider = max(dimensions.shaft_diameter, adapter.output_diameter if adapter is not None else 0.0)
    return wider / 2 + dimensions.fit + dimensions.wall


def mount_across(dimensions: JointDimensions, layout: JointLayout) -> float:
    """Smallest distance (mm) of the mount's screws across the ears, which spread below the flange.

    A head is twice as wide as its hole and as high as that is wide.
    """
    from cad.hinge import ear_outlines  # which itself needs the mount

    bolt = dimensions.mount.bolt_diameter if dimensions.mount is not None else 0.0
    ears = max(hull.half_width_above(layout.upper_bottom - bolt) for hull in ear_outlines(dimensions, layout))
    return 2 * (ears + bolt + dimensions.clearance)


def fitting_problems(dimensions: JointDimensions, layout: JointLayout) -> list[DimensionProblem]:
    """Fittings that do not fit, by the dimension that is to blame."""
    return [
        *_key(dimensions),
        *_encoder(dimensions, layout),
        *_damper(dimensions, layout),
        *_adapter(dimensions),
        *_mount(dimensions, layout),
    ]


def _key(dimensions: JointDimensions) -> list[DimensionProblem]:
    """A fit so loose that the D-shaft's flat, a tenth of its diameter deep, hardly holds."""
    most = LOOSEST_KEY * dimensions.shaft_diameter
    if dimensions.fit <= most:
        return []
    allowed = f"at most {most:.3g} mm with a shaft of {dimensions.shaft_diameter:g} mm"
    return [DimensionProblem(f"{dimensions.name}.fit", dimensions.fit, allowed, "the shaft would slip in its D bore")]


def _encoder(dimensions: JointDimensions, layout: JointLayout) -> list[DimensionProblem]:
    encoder, name, found = dimensions.encoder, dimensions.name, []
    if encoder is None:
        return []
    found += _crowded(dimensions, layout.upper, seat_screws(encoder, layout.upper), encoder, "encoder")
    if encoder.magnet_diameter > dimensions.shaft_diameter - 1.0:
        most = f"at most {dimensions.shaft_diameter - 1.0:.4g} mm in a shaft of {dimensions.shaft_diameter:g} mm"
        reason = "its pocket needs half a millimetre of steel around it"
        found.append(DimensionProblem(f"{name}.encoder.magnet_diameter", encoder.magnet_diameter, most, reason))
    bore = dimensions.shaft_diameter + 2 * dimensions.clearance
    if bore + 2.0 > encoder.body_diameter:
        text = f"at least {bore + 2.0:.4g} mm with a shaft of {dimensions.shaft_diameter:g} mm"
        reason = "it lies on a rim round the shaft's bore"
        found.append(DimensionProblem(f"{name}.encoder.body_diameter", encoder.body_diameter, text, reason))
    return found


def _damper(dimensions: JointDimensions, layout: JointLayout) -> list[DimensionProblem]:
    """Of a pair of springs the second one's arm stands in the ear that the damper is screwed to."""
    if not layout.mirrored:
        return []
    return _crowded(dimensions, layout.upper, layout.screws, dimensions.damper, "damper")


def _crowded(
    dimensions: JointDimensions,
    upper: ArmLayout,
    screws: Sequence[Point],
    part: DamperDimensions | EncoderDimensions,
    what: str,
) -> list[DimensionProblem]:
    """Screws too near to the arm's shafts in the same ear."""
    gap = _nearest(screws, upper)
    needed = dimensions.pin_diameter / 2 + dimensions.fit + part.bolt_diameter / 2 + LEAST_BRIDGE
    if gap >= needed:
        return []
    text = f"another one; its screws come within {gap:.3g} mm of the arm's shafts and need {needed:.3g} mm"
    name = f"{dimensions.name}.{what}.bolt_circle"
    return [DimensionProblem(name, part.bolt_circle, text, "both stand in the same ear")]


def _adapter(dimensions: JointDimensions) -> list[DimensionProblem]:
    if dimensions.damper.adapter is None:
        return []
    least = 2 * (adapter_radius(dimensions) + dimensions.clearance)
    if dimensions.damper.outer_diameter >= least:
        return []
    return [
        DimensionProblem(
            f"{dimensions.name}.damper.outer_diameter",
            dimensions.damper.outer_diameter,
            f"at least {least:.4g} mm",
            "the adapter turns in the bracket's sleeve",
        )
    ]


def _mount(dimensions: JointDimensions, layout: JointLayout) -> list[DimensionProblem]:
    mount = dimensions.mount
    if mount is None or mount.spacing_across is None:
        return []
    least = mount_across(dimensions, layout)
    if mount.spacing_across >= least:
        return []
    name = f"{dimensions.name}.mount.spacing_across"
    return [DimensionProblem(name, mount.spacing_across, f"at least {least:.4g} mm", "screw heads would meet the ears")]
