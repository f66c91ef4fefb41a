"""Whether parts of different joints meet as the leg folds: a shank's hardware on the hip, a link on the link before it.

A joint's own checks have its two halves and its link (``cad.travel``). What is on the links beyond it is tested here in
two steps: shadows of all parts along the hinge axes, over a grid of joint angles; then the meshes of the parts whose
shadows overlap.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from synth.cad.dimensions import JointDimensions, LegDimensions
from synth.cad.joint import BuiltJoint
from synth.cad.leg_joints import BuiltLeg, link_name
from synth.cad.parts import Array, BuiltPart
from synth.cad.results import CheckResult, check_at_most
from synth.cad.travel import OVERLAP_LIMIT

# Angles per joint of the grid, by the number of joints between two parts: some hundred poses a pair of halves. A fold
# meets first at an end of the ranges, which are in every grid.
GRID = {1: 19, 2: 7, 3: 5}
COARSE_GRID = 3
MOST_CONFIRMED = 6  # poses of a pair of halves whose meshes are tested: those with the most overlapping shadows first

Half = tuple[int, str]  # a joint's number and ``upper`` or ``lower``; the lower half has the joint's link
Poses = tuple[Mapping[int, float], list[tuple[str, str]]]  # angles, deg, by joint; pairs of parts


@dataclass(frozen=True)
class Shadow:
    """A part seen along the hinge axes, in its half's frame: the convex hull ``corners`` (n, 2) mm, and its z, mm."""

    part: str
    half: Half
    corners: Array
    low: float
    high: float


@dataclass(frozen=True)
class Meeting:
    """Parts of two joints that overlap, with the common volume, mm^3, and the angles (deg) of the joints between."""

    first: str
    second: str
    volume: float
    angles: tuple[tuple[str, float], ...]

    def __str__(self) -> str:
        at = " and ".join(f"{name} at {angle:.4g} deg" for name, angle in self.angles)
        return f"{self.first} meets {self.second} with {at}"


def shadows_of(index: int, joint: BuiltJoint, link: BuiltPart) -> list[Shadow]:
    """The shadows of a joint's parts and of its link; the spring is inside its pocket."""
    from scipy.spatial import ConvexHull

    found = []
    for part in (*joint.parts, link):
        if part.group != "spring":
            flat, heights = part.mesh.vertices[:, :2], part.mesh.vertices[:, 2]
            corners = flat[ConvexHull(flat).vertices]
            found.append(Shadow(part.name, (index, part.group), corners, float(heights.min()), float(heights.max())))
    return found


def near_meetings(dimensions: LegDimensions, shadows: Sequence[Shadow]) -> dict[tuple[Half, Half], list[Poses]]:
    """Poses, by pair of halves on different bodies, in which shadows of both overlap, most of them first.

    Each with its pairs of parts. Halves of one joint are left out, and those on one link: they do not move.
    """
    halves: dict[Half, list[Shadow]] = {}
    for shadow in shadows:
        halves.setdefault(shadow.half, []).append(shadow)
    found: dict[tuple[Half, Half], list[Poses]] = {}
    for first, second in itertools.combinations(sorted(halves, key=_body), 2):
        if first[0] == second[0] or _body(first) == _body(second):
            continue
        poses: list[Poses] = []
        for angles in _grid(dimensions.joints, _body(first), _body(second)):
            turn, shift = _placed(dimensions.joints, first, second, angles)
            pairs = _overlapping(halves[first], halves[second], turn, shift)
            if pairs:
                poses.append((angles, pairs))
        if poses:
            found[first, second] = sorted(poses, key=lambda pose: -len(pose[1]))[:MOST_CONFIRMED]
    return found


def _body(half: Half) -> int:
    """The number of the link that a half moves with; 0: the base."""
    return half[0] + (half[1] == "lower")


def _grid(joints: Sequence[JointDimensions], first: int, last: int) -> Iterator[dict[int, float]]:
    """Measured angles (deg) of the joints between two bodies, over their ranges."""
    between = range(first, last)
    count = GRID.get(len(between), COARSE_GRID)
    angles = [np.linspace(*joints[k].range, count).tolist() for k in between]
    for values in itertools.product(*angles):
        yield dict(zip(between, values, strict=True))


def _placed(
    joints: Sequence[JointDimensions], first: Half, second: Half, angles: Mapping[int, float]
) -> tuple[float, tuple[float, float]]:
    """Turn (deg) and shift (mm) that bring the second half's frame into the first's."""
    x = y = turn = 0.0
    for k in range(first[0], second[0]):
        # From a lower half on, its own joint's turn is not passed: its frame turns with it.
        if k >= _body(first):
            turn += joints[k].rotation(angles[k])
        x += joints[k].link_length * math.sin(math.radians(turn))
        y -= joints[k].link_length * math.cos(math.radians(turn))
    if second[1] == "lower":
        turn += joints[second[0]].rotation(angles[second[0]])
    return turn, (x, y)


def _overlapping(
    first: Sequence[Shadow], second: Sequence[Shadow], turn: float, shift: tuple[float, float]
) -> list[tuple[str, str]]:
    """The pairs of parts whose shadows, and heights along the hinge axes, overlap."""
    c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
    rotation = np.array([[c, s], [-s, c]])
    moved = [shadow.corners @ rotation + np.array(shift) for shadow in second]
    boxes = [np.array([(*p.min(0), *p.max(0)) for p in group]) for group in ([a.corners for a in first], moved)]
    heights = [np.array([(a.low, a.high) for a in group]) for group in (first, second)]
    near = np.all(boxes[0][:, None, :2] < boxes[1][None, :, 2:], axis=2)
    near &= np.all(boxes[1][None, :, :2] < boxes[0][:, None, 2:], axis=2)
    near &= heights[0][:, None, 0] < heights[1][None, :, 1]
    near &= heights[1][None, :, 0] < heights[0][:, None, 1]
    return [(first[i].part, second[k].part) for i, k in np.argwhere(near) if _hulls_meet(first[i].corners, moved[k])]


def _hulls_meet(one: Array, other: Array) -> bool:
    """Whether two convex polygons overlap: no edge of either separates them."""
    for hull in (one, other):
        edges = np.roll(hull, -1, axis=0) - hull
        across = np.column_stack([edges[:, 1], -edges[:, 0]])
        a, b = across @ one.T, across @ other.T
        if np.any((a.max(axis=1) <= b.min(axis=1)) | (b.max(axis=1) <= a.min(axis=1))):
            return False
    return True


def confirmed(leg: BuiltLeg, near: Mapping[tuple[Half, Half], Sequence[Poses]]) -> list[Meeting]:
    """Of each pair of halves, the parts that overlap most in any of these poses, on their meshes."""
    parts = {part.name: part for part in leg.parts}
    joints, found = leg.dimensions.joints, []
    for (first, second), poses in near.items():
        worst: Meeting | None = None
        for angles, pairs in poses:
            turn, shift = _placed(joints, first, second, angles)
            for one, other in pairs:
                moved = parts[other].mesh.turned(turn, (*shift, 0.0))
                volume = float((parts[one].mesh.manifold ^ moved.manifold).volume())
                if volume > max(OVERLAP_LIMIT, worst.volume if worst else 0.0):
                    worst = Meeting(one, other, volume, tuple((joints[k].name, angles[k]) for k in angles))
        found += [worst] if worst else []
    return found


def chain_results(dimensions: LegDimensions, meetings: Sequence[Meeting]) -> list[CheckResult]:
    """A check for each joint that others precede or follow: over its range, what it moves meets nothing.

    Where several joints must stand so at once, the motion may never come there: see ``chain_notes``.
    """
    results = []
    for joint in dimensions.joints if len(dimensions.joints) > 1 else ():
        own = [each for each in meetings if [name for name, _ in each.angles] == [joint.name]]
        worst = max(own, key=lambda each: each.volume, default=None)
        low, high = joint.range
        text = f"with the parts of other joints, {joint.name} over {low:g} to {high:g} deg"
        text += f": {worst}; a smaller range or a longer link keeps them apart" if worst else ""
        volume = worst.volume if worst else 0.0
        results.append(check_at_most("overlap in the leg", link_name(joint), volume, OVERLAP_LIMIT, "mm^3", text))
    return results


def chain_notes(meetings: Sequence[Meeting]) -> list[str]:
    """A sentence for each meeting for which several joints must stand in the stated angles."""
    return [
        f"{each}: keep the leg out of there, or give these joints smaller ranges"
        for each in meetings
        if len(each.angles) > 1
    ]


def find_meetings(leg: BuiltLeg) -> list[Meeting]:
    """All meetings of a leg's parts."""
    if len(leg.joints) < 2:
        return []
    pairs = enumerate(zip(leg.joints, leg.links, strict=True))
    shadows = [shadow for index, (joint, link) in pairs for shadow in shadows_of(index, joint, link)]
    return confirmed(leg, near_meetings(leg.dimensions, shadows))


def check_chain(leg: BuiltLeg) -> list[CheckResult]:
    """No part of one joint meets a part of another while a single joint turns through its range."""
    return chain_results(leg.dimensions, find_meetings(leg))
