"""The flange that attaches the first upper half to the body, instead of a tube's socket.

A plate across the end of ears and web, perpendicular to the link's line, with two screws on either side of the ears.
"""

from __future__ import annotations

import math
from typing import Any

from synth.cad import kernel
from synth.cad.dimensions import JointDimensions
from synth.cad.layout import JointLayout
from synth.cad.outlines import flange_size, mount_screws


def build_flange(dimensions: JointDimensions, layout: JointLayout) -> tuple[Any, list[Any]]:
    """The flange (cadquery Solid) in the joint's frame, and the screws' holes to cut from it."""
    mount = dimensions.mount
    assert mount is not None
    across, along = flange_size(dimensions, layout)
    start = layout.upper_bottom
    plate = kernel.block((across, mount.thickness, along), (-across / 2, start, -along / 2))
    holes = [
        kernel.cylinder(mount.bolt_diameter / 2, mount.thickness + 2, (x, start - 1, z), (0.0, 1.0, 0.0))
        for x, z in mount_screws(dimensions, layout)
    ]
    return plate, holes


def flange_volume(dimensions: JointDimensions, layout: JointLayout) -> float:
    """Volume of the flange less its screw holes, mm^3."""
    mount = dimensions.mount
    assert mount is not None
    across, along = flange_size(dimensions, layout)
    return (across * along - 4 * math.pi * mount.bolt_diameter**2 / 4) * mount.thickness
