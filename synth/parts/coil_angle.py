"""Included angle of the legs and fraction of the number of coils: each determines the other.

Angles in rad. Seen along the axis, in the winding sense, the second leg leaves the coil 2 pi N after the first.

``tangent``: both legs leave tangentially. With whole coils they point in opposite directions (180 degrees); a further
fraction of a coil closes the angle: 180 deg - 360 deg frac(N). ``radial`` and ``axial``: the angle between the
positions of the legs on the circle: 360 deg frac(N). Winding the spring closes tangent legs by the travel.
"""

from __future__ import annotations

import math
from typing import Literal, get_args

Convention = Literal["tangent", "radial", "axial"]
CONVENTIONS: tuple[Convention, ...] = get_args(Convention)

# Coils are published with two decimals at best: 0.01 coil is 3.6 degrees.
TOLERANCE = math.radians(4.0)


def included_angle(body_coils: float, convention: Convention = "tangent") -> float:
    """Angle between the legs of the free spring, in [0, 2 pi)."""
    turned = math.tau * math.fmod(body_coils, 1.0)
    angle = math.fmod(math.pi - turned + math.tau, math.tau) if convention == "tangent" else turned
    return 0.0 if math.isclose(angle, math.tau, abs_tol=1e-12) else angle


def coil_fraction(angle: float, convention: Convention = "tangent") -> float:
    """The fraction of a coil in [0, 1) for the included angle."""
    turned = math.pi - angle if convention == "tangent" else angle
    fraction = math.fmod(math.fmod(turned, math.tau) + math.tau, math.tau) / math.tau
    return 0.0 if fraction > 1.0 - 1e-12 else fraction


def angle_mismatch(body_coils: float, angle: float, convention: Convention = "tangent") -> float:
    """Deviation of a stated included angle from that of the coils, in (-pi, pi]."""
    difference = math.remainder(angle - included_angle(body_coils, convention), math.tau)
    return math.pi if difference == -math.pi else difference
