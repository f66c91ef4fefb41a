"""The least that a joint needs round its shaft, whatever spring it gets: the shortest links, and the damper's place.

Arithmetic on a joint with the thinnest spring that its shaft takes. Every other spring makes the joint larger.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from synth.cad.dimensions import JointDimensions, SpringDimensions
from synth.cad.fitting_problems import damper_problems, least_bolt_circle
from synth.cad.fittings import DamperDimensions
from synth.cad.layout import place
from synth.cad.limits import DimensionProblem, limit_of

WIDEST_INDEX = 24.0  # D/d of the thinnest spring, just under the 25 that a coil may have
COILS = 3.0 + 1.0 / 6.0  # whole coils and the sixth of a turn that puts straight arms at 120 deg
INCLUDED = 120.0  # deg, the commonest of the catalogues: any other gives the same lengths
STILL = 1.0  # deg, travel of a joint that hardly moves: nothing sweeps
FAR = 1500.0  # mm, a link that is long enough for any hinge


def thinnest_spring(shaft: float, clearance: float) -> SpringDimensions:
    """The spring of the thinnest wire that closes round a shaft of ``shaft`` mm with its clearance."""
    inside = shaft + 2.0 * clearance
    wire = max(limit_of(SpringDimensions, "wire_diameter").low, inside / (WIDEST_INDEX - 1.0))
    return SpringDimensions(wire, inside + wire, COILS, INCLUDED)


def least_joint(
    shaft: float, clearance: float, wall: float, tube: tuple[float, float], damper: DamperDimensions | None = None
) -> JointDimensions:
    """The smallest joint round a shaft, all in mm: of the thinnest spring and, without ``damper``, the least damper."""
    joint = JointDimensions(
        "joint",
        thinnest_spring(shaft, clearance),
        free_angle=INCLUDED,
        rest_angle=INCLUDED,
        range=(INCLUDED - STILL, INCLUDED + STILL),
        link_length=FAR,
        link_width=tube[0],
        tube_wall=tube[1],
        shaft_diameter=shaft,
        clearance=clearance,
        wall=wall,
    )
    if damper is not None:
        return replace(joint, damper=damper)
    hole = limit_of(DamperDimensions, "bolt_diameter").low
    body = max(2.0 * joint.hardware.radius, limit_of(DamperDimensions, "outer_diameter").low)
    joint = replace(joint, damper=DamperDimensions(outer_diameter=body, bolt_count=2, bolt_diameter=hole))
    circle = max(least_bolt_circle(joint), body + hole + 2.0)  # 2 mm: the screws pass outside the body
    return replace(joint, damper=replace(joint.damper, bolt_circle=circle))


def least_halves(joint: JointDimensions) -> tuple[float, float]:
    """Length (mm) that a joint takes of the link above and of the link below it, from axis to end of socket."""
    layout = place(joint)
    return layout.upper_bottom + layout.socket_depth, layout.lower_bottom + layout.socket_depth


def least_links(joints: Sequence[JointDimensions]) -> tuple[float, ...]:
    """Least length (mm) of each link of a chain of joints: the halves of its two hinges, of the last link one half."""
    halves = [least_halves(joint) for joint in joints]
    return tuple(lower + (halves[k + 1][0] if k + 1 < len(halves) else 0.0) for k, (_, lower) in enumerate(halves))


def damper_does_not_fit(joint: JointDimensions) -> list[DimensionProblem]:
    """Why a joint's damper cannot be mounted on its shaft, whatever spring the joint has."""
    found = joint.damper.problems(f"{joint.name}.damper.")
    if found or not math.isfinite(joint.damper.bolt_circle):
        return found
    return damper_problems(joint, place(joint))
