"""Backlash: the rotation of the hinge before the unloaded spring bends, from contacts between the solids.

The spring is a rigid body with small displacements and rotations along and about all axes. Rays are cast from points
on its wire to the parts of both halves. A face at the distance g from the wire allows the wire to approach by at most g
along the face's normal. The largest rotation of the hinge for which the spring still has an allowed position is the
solution of a linear programme with seven unknowns. No dimension of the layout is used: the lines of the arms come from
the spring's flat ends, the coil from its mesh, and the faces from the parts' meshes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from synth.cad.joint import BuiltJoint
from synth.cad.parts import Array, BuiltPart, Group
from synth.cad.results import CheckResult, check_at_most
from synth.cad.spring_solid import measured_arms
from synth.cad.torsion_spring import SIDES, STEPS_PER_TURN
from synth.cad.travel import Bodies, turn_solid

PLAY_LIMIT = 0.3  # deg, to either side: allowed angle error of a leg's response
MOST_PLAY = 10.0  # deg, end of the search; the small-angle approximation has an error of 1 % there
SPACING = 1.0  # mm, between points on an arm
AROUND = 16  # rays round the wire: 22.5 deg apart
COIL_POINTS = 24  # a turn: every second ring of the mesh
FACING = 0.9  # cosine between a ray and a face's normal; an oblique face would touch the wire at another point
NEAR_FACES = 4.0  # wire diameters, beyond which a face is ignored: more than the displacement of an arm at MOST
SUNK = 0.03  # mm, overlap by the chords of meshes; a deeper overlap is reported by other checks


@dataclass(frozen=True)
class Play:
    """Rotation (deg) of the lower half from the free angle before the spring bends, in the measured angle's sense."""

    low: float
    high: float

    @property
    def width(self) -> float:
        """The total backlash, deg."""
        return self.high - self.low


def wire_points(joint: BuiltJoint, spring: BuiltPart) -> tuple[Array, Array]:
    """Points (n, 3) mm on the unloaded wire's centre line and its directions there (n, 3)."""
    places, ways = [], []
    for arm in measured_arms(spring.solid):
        along = arm.direction / np.linalg.norm(arm.direction)
        free = arm.reach() / float(np.hypot(*along[:2]))
        steps = np.linspace(0.0, free, max(2, math.ceil(free / SPACING)))
        places.append(arm.point - steps[:, None] * along)
        ways.append(np.repeat(along[None], len(steps), axis=0))
    rings = spring.mesh.vertices[:-2].reshape(-1, SIDES, 3).mean(axis=1)
    tangents = np.gradient(rings, axis=0)
    chosen = slice(2, -2, max(1, STEPS_PER_TURN // COIL_POINTS))
    places.append(rings[chosen])
    ways.append(tangents[chosen] / np.linalg.norm(tangents[chosen], axis=1, keepdims=True))
    return np.vstack(places), np.vstack(ways)


def _limits(points: Array, ways: Array, body: Any, turn: float, wire: float) -> tuple[Array, Array, Array]:
    """Faces around the wire: possible contact points (m, 3), their normals towards it (m, 3) and gaps (m,) mm."""
    solid = turn_solid(body, turn)
    radius, far = wire / 2, NEAR_FACES * wire
    touching, normals, gaps = [], [], []
    around = [(math.cos(angle), math.sin(angle)) for angle in 2 * math.pi * np.arange(AROUND) / AROUND]
    for point, way in zip(points, ways, strict=True):
        first = np.cross(way, [0.0, 0.0, 1.0])
        first /= np.linalg.norm(first)
        second = np.cross(way, first)
        rays = [cos * first + sin * second for cos, sin in around]
        for ray in rays:
            hits = solid.ray_cast(point, point + far * ray)
            if not hits:
                continue
            normal = np.asarray(hits[0].normal, dtype=np.float64)
            facing = float(np.dot(normal, ray))
            if facing > -FACING:
                continue
            gap = -float(np.dot(np.asarray(hits[0].position) - point, normal)) - radius
            touching.append(point - radius * normal)
            normals.append(normal)
            gaps.append(gap)
    return np.array(touching).reshape(-1, 3), np.array(normals).reshape(-1, 3), np.array(gaps)


def _rows(points: Array, normals: Array) -> Array:
    """(m, 6): change of a normal's gap with shifts along x, y, z (mm) and rotations about them (rad) of the wire."""
    return -np.column_stack([normals, np.cross(points, normals)])


def find_play(bodies: Bodies, spring: BuiltPart) -> Play | None:
    """The play with one spring; None if spring and parts intersect."""
    from scipy.optimize import linprog

    joint = bodies.joint
    dimensions = joint.dimensions
    points, ways = wire_points(joint, spring)
    wire = dimensions.spring.wire_diameter
    rows, limits = [], []
    groups: tuple[tuple[Group, float], ...] = (("upper", 0.0), ("lower", 1.0))
    for group, moves in groups:
        turn = joint.turn("lower", dimensions.free_angle) if group == "lower" else 0.0
        touching, normals, gaps = _limits(points, ways, bodies.halves[group], turn, wire)
        if len(gaps) and gaps.min() < -SUNK:
            return None
        row = _rows(touching, normals)
        # In the frame of the lower half the spring rotates in the opposite direction.
        rows.append(np.column_stack([row, -moves * row[:, 5]]))
        limits.append(np.maximum(gaps, 0.0))
    found = []
    most = math.radians(MOST_PLAY)
    for way in (1.0, -1.0):
        cost = np.array([0.0] * 6 + [-way])
        bounds = [(-wire, wire)] * 3 + [(-most, most)] * 4
        solved = linprog(cost, A_ub=np.vstack(rows), b_ub=np.concatenate(limits), bounds=bounds, method="highs")
        if solved.x is None:
            return None
        found.append(math.degrees(float(solved.x[6])) * dimensions.sign)
    return Play(min(found), max(found))


def play_of(joint: BuiltJoint) -> Play | None:
    """The play of a joint, from the cache if its checks have computed it."""
    return joint.kept["play"] if "play" in joint.kept else joint_play(Bodies(joint))


def joint_play(bodies: Bodies) -> Play | None:
    """The play of a joint; for a pair of springs with both together. The joint keeps it."""
    found = bodies.joint.kept["play"] = _joint_play(bodies)
    return found


def _joint_play(bodies: Bodies) -> Play | None:
    plays = [find_play(bodies, spring) for spring in bodies.joint.springs]
    known = [play for play in plays if play is not None]
    if len(known) < len(plays):
        return None
    return Play(max(play.low for play in known), min(play.high for play in known))


def check_play(bodies: Bodies) -> list[CheckResult]:
    """With the unloaded spring the hinge has at most the allowed backlash in either direction."""
    found, name = joint_play(bodies), bodies.joint.part("spring").name
    if found is None:
        return [check_at_most("play", name, math.inf, PLAY_LIMIT, "deg", "spring and parts overlap")]
    worst = max(-found.low, found.high)
    text = f"the hinge turns freely from {found.low:+.3f} to {found.high:+.3f} deg about the free angle"
    return [check_at_most("play", name, worst, PLAY_LIMIT, "deg", text, angle=bodies.joint.dimensions.free_angle)]
