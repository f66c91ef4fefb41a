"""The bracket that holds a rotary damper coaxial with the joint, and the bought damper's envelope.

A sleeve open at both ends. One end is on ear A, around the shaft's collar, and is screwed to it from between the ears.
The damper's body is inside the sleeve; its flange is screwed to the other end. Both sets of screws are on the damper's
bolt circle and end in inserts. Own frame, mm: the face on the ear is z = 0, the bracket extends along -z.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from synth.cad import kernel
from synth.cad.arm_shaft import cross_hole, cross_volume
from synth.cad.fittings import DamperDimensions
from synth.cad.outline import Point
from synth.cad.screw_places import FLANGE_THICKNESS

ACCESS_TURN = 90.0  # deg: between two of the damper's screws, however many there are
ROTOR_GRIP = 0.8  # of the body's length: engagement of the shaft in the rotor


@dataclass(frozen=True)
class Access:
    """A hole in the sleeve for the key or pin of what is inside: height, radius (mm) and direction (deg)."""

    height: float
    radius: float
    turn: float


@dataclass(frozen=True)
class Sleeve:
    """Dimensions of the bracket: radii, height, inserts' holes (radius, depths from ear and open end); mm.

    A thin sleeve with a boss around each screw or, if bosses would overlap, a sleeve as thick as the bosses.
    """

    radius: float  # of the damper's flange, round all bosses
    bore: float
    wall: float
    height: float
    hole: float
    depths: tuple[float, float]
    access: tuple[Access, ...] = ()

    @property
    def boss(self) -> float:
        """Radius of a boss: a wall around the insert."""
        return self.hole + self.wall

    def thin(self, screws: Sequence[Point]) -> bool:
        """Whether bosses are separate because the sleeve does not reach them."""
        circle = math.hypot(*screws[0])
        apart = 2 * circle * math.sin(math.pi / len(screws))
        return apart > 2 * self.boss and circle + self.boss > self.bore + self.wall > circle - self.boss


def key_turn(bolt_count: int) -> float:
    """Direction (deg) of the hole for a collar's key: between two screws, away from the upper link.

    A mount's flange, or a wide tube, would leave no room there for the key.
    """
    return ACCESS_TURN + 360.0 / bolt_count * (bolt_count // 2)


def _cylinder(radius: float, bottom: float, top: float, at: Point = (0.0, 0.0)) -> Any:
    return kernel.cylinder(radius, top - bottom, (at[0], at[1], bottom))


def build_bracket(sleeve: Sleeve, screws: Sequence[Point]) -> Any:
    """The bracket as one cadquery Solid."""
    above, below = sleeve.depths
    cuts = [_cylinder(sleeve.bore, -sleeve.height - 1.0, 1.0)]
    cuts += [cross_hole(hole.height, hole.radius, sleeve.radius + 1.0, hole.turn, 0.0) for hole in sleeve.access]
    for at in screws:
        cuts.append(_cylinder(sleeve.hole, -above, 1.0, at))
        cuts.append(_cylinder(sleeve.hole, -sleeve.height - 1.0, -sleeve.height + below, at))
    if not sleeve.thin(screws):
        return _cylinder(sleeve.radius, -sleeve.height, 0.0).cut(*cuts)
    body = _cylinder(sleeve.bore + sleeve.wall, -sleeve.height, 0.0)
    body = body.fuse(*(_cylinder(sleeve.boss, -sleeve.height, 0.0, at) for at in screws))
    return body.cut(*cuts)


def bracket_volume(sleeve: Sleeve, screws: Sequence[Point]) -> float | None:
    """Volume of :func:`build_bracket`, mm^3, in closed form; None if a hole for keys and pins meets a boss."""
    if sleeve.thin(screws) and not all(_beside(hole, at, sleeve.boss) for hole in sleeve.access for at in screws):
        return None
    holes = len(screws) * math.pi * sleeve.hole**2 * sum(sleeve.depths)
    outer = sleeve.bore + sleeve.wall if sleeve.thin(screws) else sleeve.radius
    holes += sum(cross_volume(outer, sleeve.bore, hole.radius) / 2 for hole in sleeve.access)
    bore = math.pi * sleeve.bore**2
    if not sleeve.thin(screws):
        return (math.pi * sleeve.radius**2 - bore) * sleeve.height - holes
    wide, boss = sleeve.bore + sleeve.wall, sleeve.boss
    beside = math.pi * boss**2 - _lens(wide, boss, math.hypot(*screws[0]))
    return (math.pi * wide**2 - bore + len(screws) * beside) * sleeve.height - holes


def _beside(hole: Access, at: Point, boss: float) -> bool:
    """Whether a hole from the axis outwards passes a boss of radius ``boss`` (mm) at a screw."""
    x, y = math.cos(math.radians(hole.turn)), math.sin(math.radians(hole.turn))
    return x * at[0] + y * at[1] < 0.0 or abs(x * at[1] - y * at[0]) >= boss + hole.radius


def _lens(first: float, second: float, apart: float) -> float:
    """Area (mm^2) that two discs ``apart`` mm share."""
    a = math.acos((apart**2 + first**2 - second**2) / (2 * apart * first))
    b = math.acos((apart**2 + second**2 - first**2) / (2 * apart * second))
    return first**2 * (a - math.sin(a) * math.cos(a)) + second**2 * (b - math.sin(b) * math.cos(b))


def build_damper(damper: DamperDimensions, screws: Sequence[Point], radius: float, height: float, bore: float) -> Any:
    """Envelope of the bought damper seated on the bracket: body and flange round a bore of radius ``bore``, mm.

    The rotor, which is driven by the shaft and turns with it, is not drawn.
    """
    top = -height + damper.body_length
    flange = _cylinder(radius, -height - FLANGE_THICKNESS, -height)
    body = _cylinder(damper.outer_diameter / 2, -height, top)
    holes = [_cylinder(damper.bolt_diameter / 2, -height - FLANGE_THICKNESS - 1.0, -height + 0.5, at) for at in screws]
    return flange.fuse(body).cut(*holes, _cylinder(bore, -height - FLANGE_THICKNESS - 1.0, top + 1.0))


def rotor_bottom(damper: DamperDimensions, height: float) -> float:
    """Z (mm) of the shaft's end in the damper."""
    return -height + (1.0 - ROTOR_GRIP) * damper.body_length


def damper_volume(damper: DamperDimensions, radius: float, bore: float) -> float:
    """Volume of :func:`build_damper`, mm^3, in closed form."""
    flange = radius**2 - damper.bolt_count * (damper.bolt_diameter / 2) ** 2 - bore**2
    body = (damper.outer_diameter / 2) ** 2 - bore**2
    return math.pi * (flange * FLANGE_THICKNESS + body * damper.body_length)
