"""Where a joint's fittings lie and whether they fit: encoder, damper's adapter, mount. Arithmetic only, no solids."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from cad.dimensions import JointDimensions
from cad.fittings import EncoderDimensions
from cad.limits import DimensionProblem
from cad.outline import Point

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
    step = 360.0 / encoder.bolt_count

    def turned(start: float) -> list[Point]:
        angles = [math.radians(start + index * step) for index in range(encoder.bolt_count)]
        return [(encoder.bolt_circle / 2 * math.cos(a), encoder.bolt_circle / 2 * math.sin(a)) for a in angles]

    starts = [upper.direction + step * index / 36 for index in range(36)]
    return max((turned(start) for start in starts), key=lambda points: round(_nearest(points, upper), 6))


def _nearest(points: list[Point], upper: ArmLayout) -> float:
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
    return [*_key(dimensions), *_encoder(dimensions, layout), *_adapter(dimensions), *_mount(dimensions, layout)]


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
    gap = _nearest(seat_screws(encoder, layout.upper), layout.upper)
    needed = dimensions.pin_diameter / 2 + dimensions.fit + encoder.bolt_diameter / 2 + LEAST_BRIDGE
    if gap < needed:
        text = f"another one; its screws come within {gap:.3g} mm of the arm's shafts and need {needed:.3g} mm"
        found.append(
            DimensionProblem(f"{name}.encoder.bolt_circle", encoder.bolt_circle, text, "both stand in the same ear")
        )
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
