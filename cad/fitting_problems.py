"""Whether a joint's fittings fit: encoder, damper's adapter, mount, shaft. Arithmetic only, no solids."""

from __future__ import annotations

from cad.dimensions import JointDimensions
from cad.layout import JointLayout
from cad.limits import DimensionProblem
from cad.outlines import mount_across

LOOSEST_KEY = 0.06  # of the shaft's diameter; its flat is 0.1 deep


def adapter_radius(dimensions: JointDimensions) -> float:
    """Outside of the damper's adapter, mm: a wall round the wider of the two bores."""
    adapter = dimensions.damper.adapter
    wider = max(dimensions.shaft_diameter, adapter.output_diameter if adapter is not None else 0.0)
    return wider / 2 + dimensions.fit + dimensions.wall


def fitting_problems(dimensions: JointDimensions, layout: JointLayout) -> list[DimensionProblem]:
    """Fittings that do not fit, by the dimension that is to blame."""
    return [
        *_key(dimensions),
        *_encoder(dimensions),
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


def _encoder(dimensions: JointDimensions) -> list[DimensionProblem]:
    encoder, name, found = dimensions.encoder, dimensions.name, []
    if encoder is None:
        return []
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
