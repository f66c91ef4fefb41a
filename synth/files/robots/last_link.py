"""Where the last link of a robot's chain ends: its shapes and fixed frames show it, if they pass its centre of mass."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from synth.arrays import Array
from synth.errors import UserError
from synth.files.robots.leg_plane import LegPlane
from synth.files.robots.robot_shapes import RobotShape
from synth.files.robots.robot_tree import Robot

NOTHING = 1e-12  # m, that counts as none
NO_DIRECTION = 1e-6  # m: nearer than a micrometre has none
ROUNDING = 1e-6  # relative: single precision of a mesh's file
FARTHER = 0.01  # of the shapes' reach: a frame this much beyond them is worth a note
# Times what the rest shows, from which a shape is in another unit. An inch gives 39 and more; a thin rod on a heavy
# hub, which alone reaches far beyond its radius of gyration, some 20.
OTHER_UNIT = 30.0
UNITS = {"mm": 0.001, "cm": 0.01, "inches": 0.0254}  # m
LIKELY = 3.0  # times, either way: how near a shape in that unit comes to what the rest shows


def last_link(
    robot: Robot,
    bodies: Sequence[int],
    anchor: Array,
    com: Array,
    seen: LegPlane,
    size: float,
    tip: float | None,
    messages: list[str],
) -> tuple[Array, float]:
    """Direction and length of the last link: through its centre of mass, as far as its farthest point along that.

    Its direction is free because nothing is attached to it; through the centre of mass, no part of its motion is lost.
    A link ends beyond its centre of mass: what ends before, such as a sensor's frame, shows no end. Nor does a shape
    that reaches so far beyond all else that it must be in another unit: a note names it.

    Parameters
    ----------
    anchor, com
        (2,) m in the plane, of the last joint and of the bodies' common centre of mass.
    size
        m, that the chain's other links and the bodies' inertia show.
    tip
        m, the length as given; None: from the file.

    Raises
    ------
    UserError
        If nothing shows a length and the centre of mass is on the joint.
    """
    shapes, in_other_unit = _to_scale(robot, bodies, anchor, com, seen, size)
    along, distance = _direction(robot, bodies, shapes, anchor, com, seen)
    if tip is not None:
        return along, tip
    messages += in_other_unit
    way, from_ = seen.lifted(along), seen.lifted(anchor)
    drawn = max((shape.reach(from_, way) for shape in shapes), default=0.0)
    reaches = {robot.bodies[index].name: float((robot.bodies[index].position - from_) @ way) for index in bodies}
    farthest = max(reaches, key=lambda name: reaches[name])
    length = max(drawn, reaches[farthest], 0.0)
    unread = sorted({shape.unread for shape in shapes if shape.unread})
    messages += [f"the last link may end farther out, --tip gives its length: only the centre is known of {text}"
                 for text in unread]  # fmt: skip
    if length <= NOTHING and distance <= NO_DIRECTION:
        text = "the last link has neither a shape nor a centre of mass off its joint; give its length: --tip"
        raise UserError("; ".join([text, *in_other_unit]))
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


def _to_scale(
    robot: Robot, bodies: Sequence[int], anchor: Array, com: Array, seen: LegPlane, size: float
) -> tuple[list[RobotShape], list[str]]:
    """The bodies' shapes but those in another unit, and a sentence on each of these.

    A mesh has no unit: of one in mm, read as m, the link would be a thousand times too long. It is not scaled here: the
    file's author knows the unit.
    """
    frames = [float(np.hypot(*(seen.flat(robot.bodies[index].position) - anchor))) for index in bodies]
    shown = max(float(np.hypot(*(com - anchor))), *frames)
    known = max(size, shown)
    kept, said = [], []
    for body in (robot.bodies[index] for index in bodies):
        for shape in body.shapes:
            far = float(np.hypot(*(seen.flat(shape.corners) - anchor).T).max())
            far += float(np.linalg.norm(shape.half_axes, axis=1).max())
            if known <= NO_DIRECTION or far <= OTHER_UNIT * known:
                kept.append(shape)
                continue
            # An inertia in another unit may hide what frames and centre of mass show.
            near = shown if shown > NO_DIRECTION else known
            said.append(
                f"the {shape.title} of {body.name} reaches {far:.4g} m, {far / near:.3g} times as far as the rest of "
                f"the link ({1e3 * near:.3g} mm): {_unit_asked(shape, far / near)}. Its length is taken without it; "
                "--tip gives another"
            )
    return kept, said


def _unit_asked(shape: RobotShape, ratio: float) -> str:
    """The question for the unit that would bring a shape nearest to what the rest shows."""
    unit = min(UNITS, key=lambda name: abs(np.log(UNITS[name] * ratio)))
    if not 1.0 / LIKELY < UNITS[unit] * ratio < LIKELY:
        return "check its size"
    scale = " ".join([f"{UNITS[unit]:g}"] * 3)
    how = f'write scale="{scale}" there' if shape.title.startswith("mesh") else "write its size in m"
    return f"is it in {unit}? Then {how}"


def _direction(
    robot: Robot, bodies: Sequence[int], shapes: Sequence[RobotShape], anchor: Array, com: Array, seen: LegPlane
) -> tuple[Array, float]:
    """Unit vector (2,) from the joint along the link, and distance of the centre of mass along it, m.

    That is below 0 of a counterweight, where the limb is on the joint's other side.
    """
    to_com = com - anchor
    distance = float(np.hypot(*to_com))
    lines = [shape.line for shape in shapes]
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
