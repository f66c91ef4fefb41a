"""Where the last link of a robot's chain ends: its shapes and fixed frames show it, if they pass its centre of mass."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synth.arrays import Array
from synth.errors import UserError
from synth.files.robots.leg_plane import LegPlane
from synth.files.robots.robot_tree import Robot

NOTHING = 1e-12  # m, that counts as none
NO_DIRECTION = 1e-6  # m: nearer than a micrometre has none
ROUNDING = 1e-6  # relative: single precision of a mesh's file
FARTHER = 0.01  # of the shapes' reach: a frame this much beyond them is worth a note


def last_link(
    robot: Robot,
    bodies: Sequence[int],
    anchor: Array,
    com: Array,
    seen: LegPlane,
    tip: float | None,
    messages: list[str],
) -> tuple[Array, float]:
    """Direction and length of the last link: through its centre of mass, as far as its farthest point along that.

    Its direction is free because nothing is attached to it; through the centre of mass, no part of its motion is lost.
    A link ends beyond its centre of mass: what ends before, such as a sensor's frame, shows no end.

    Parameters
    ----------
    anchor, com
        (2,) m in the plane, of the last joint and of the bodies' common centre of mass.
    tip
        m, the length as given; None: from the file.

    Raises
    ------
    UserError
        If nothing shows a length and the centre of mass is on the joint.
    """
    along, distance = _direction(robot, bodies, anchor, com, seen)
    if tip is not None:
        return along, tip
    shapes = [shape for index in bodies for shape in robot.bodies[index].shapes]
    way, from_ = seen.lifted(along), seen.lifted(anchor)
    drawn = max((shape.reach(from_, way) for shape in shapes), default=0.0)
    reaches = {robot.bodies[index].name: float((robot.bodies[index].position - from_) @ way) for index in bodies}
    farthest = max(reaches, key=lambda name: reaches[name])
    length = max(drawn, reaches[farthest], 0.0)
    unread = sorted({shape.unread for shape in shapes if shape.unread})
    messages += [f"the last link may end farther out, --tip gives its length: only the centre is known of {text}"
                 for text in unread]  # fmt: skip
    if length <= NOTHING and distance <= NO_DIRECTION:
        raise UserError("the last link has neither a shape nor a centre of mass off its joint; give its length: --tip")
    if length < distance * (1.0 - ROUNDING):
        nearer = ""
        if length > NOTHING:
            what = "its shapes" if drawn >= reaches[farthest] else f"the frame {farthest}"
            nearer = f" ({what}: {1e3 * length:.3g} mm, its centre of mass: {1e3 * distance:.3g} mm)"
        messages.append(
            f"the file shows no end of the last link{nearer}: {2e3 * distance:.0f} mm is that of a rod with this "
            "centre of mass; --tip gives another"
        )
        return along, 2.0 * distance
    if length > max(drawn, NOTHING) * (1.0 + FARTHER):
        shape = f"no shape beyond {1e3 * drawn:.3g} mm" if drawn > NOTHING else "no shape"
        messages.append(
            f"the last link has {shape} and ends at the frame {farthest}, {1e3 * length:.4g} mm from its joint; --tip "
            "gives another length"
        )
    return along, length


def _direction(robot: Robot, bodies: Sequence[int], anchor: Array, com: Array, seen: LegPlane) -> tuple[Array, float]:
    """Unit vector (2,) from the joint along the link, and distance of the centre of mass along it, m.

    That is below 0 of a counterweight, where the limb is on the joint's other side.
    """
    to_com = com - anchor
    distance = float(np.hypot(*to_com))
    lines = [shape.line for index in bodies for shape in robot.bodies[index].shapes]
    frames = [robot.bodies[index].position[None] for index in bodies]
    offsets = [seen.flat(points) - anchor for points in (*lines, *frames)]
    # A frame nearer than the centre of mass does not tell where the limb is.
    ends = [*offsets[: len(lines)], *(each for each in offsets[len(lines) :] if np.hypot(*each[0]) > distance)]
    if not ends:
        return to_com / max(distance, NOTHING), distance
    points = np.concatenate(ends)
    farthest = points[int(np.argmax(np.hypot(*points.T)))]
    if distance <= NO_DIRECTION:
        return farthest / max(float(np.hypot(*farthest)), NOTHING), 0.0
    along = to_com / distance
    return (-along, -distance) if float(farthest @ along) < 0.0 else (along, distance)
