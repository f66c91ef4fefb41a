"""Rings about the hinge axis that hold a turning body at every angle: what meets no ring, meets the body nowhere.

One boolean operation then decides on all angles. Where a ring does meet something, the poses are tested one by one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from synth.cad.parts import Array, Mesh

SIDES = 128  # of a ring's polygon round the circle: 3e-4 of its radius outside it, of a bore's play with a shaft 4e-3
SLICES = 24  # of the height that two bodies share
LEAST_HOLE = 0.5  # mm, radius below which a hole about the axis counts as filled
ROUNDED = 1e-4  # mm, by which a ring is larger: bodies are in single precision


@dataclass(frozen=True)
class Ring:
    """A ring between two radii and two heights, mm; without a hole where ``inner`` is not above 0."""

    inner: float
    outer: float
    low: float
    high: float

    def with_other(self, other: Ring) -> Ring:
        """The least ring that holds both."""
        return Ring(
            min(self.inner, other.inner),
            max(self.outer, other.outer),
            min(self.low, other.low),
            max(self.high, other.high),
        )


def body_of(rings: Sequence[Ring]) -> Any:
    """A manifold3d solid that holds every ring: polygons round their outer circles, within their inner ones."""
    import manifold3d

    if not rings:
        return manifold3d.Manifold()

    wider = 1.0 / math.cos(math.pi / SIDES)
    sections = []
    for ring in rings:
        inner, outer = max(0.0, ring.inner - ROUNDED), (ring.outer + ROUNDED) * wider
        low, high = ring.low - ROUNDED, ring.high + ROUNDED
        corners = np.array([(inner, low), (outer, low), (outer, high), (inner, high)])
        sections.append(manifold3d.CrossSection([corners]))
    return manifold3d.Manifold.revolve(
        manifold3d.CrossSection.batch_boolean(sections, manifold3d.OpType.Add), SIDES
    )  # about y, which becomes z


def rings_of(mesh: Mesh) -> list[Ring]:
    """Rings without holes that hold a body at every angle about the axis, one for each of its steps along it."""
    corners = mesh.vertices[mesh.faces]
    radius, heights = np.hypot(corners[..., 0], corners[..., 1]).max(axis=1), corners[..., 2]
    low, high = heights.min(axis=1), heights.max(axis=1)
    levels = np.unique(np.concatenate([low, high]))
    outer = _largest_between(levels, low, high, radius)
    rings = [Ring(0.0, r, a, b) for r, (a, b) in zip(outer, pairwise(levels), strict=True)]
    joined = rings[:1]
    for ring in rings[1:]:  # a cylinder with a hole through it has many levels
        alike = abs(ring.outer - joined[-1].outer) < ROUNDED
        joined[-1:] = [joined[-1].with_other(ring)] if alike else [joined[-1], ring]
    return joined


def _largest_between(levels: Array, low: Array, high: Array, radius: Array) -> Array:
    """The largest ``radius`` (n,) of the triangles from ``low`` to ``high`` between each two levels (m - 1,), mm."""
    first, last = np.searchsorted(levels, low), np.searchsorted(levels, high)
    outer = np.zeros(len(levels) - 1)
    for start, end, size in zip(first, last, radius, strict=True):
        part = outer[start:end]
        np.maximum(part, size, out=part)
    return outer


def meeting_place(some: Sequence[Mesh], others: Sequence[Mesh]) -> Any:
    """A manifold3d solid that holds what some bodies and others have in common at every angle that they are turned to.

    In each slice along the axis they lie between their least and their largest radius.
    """
    reaches = [_reach(meshes) for meshes in (some, others)]
    low, high = max(float(r[2].min()) for r in reaches), min(float(r[3].max()) for r in reaches)
    levels = np.linspace(low, high, SLICES + 1) if low < high else np.empty(0)
    found = []
    for bottom, top in pairwise(levels):
        rings = [_slice(*reach, bottom - ROUNDED, top + ROUNDED) for reach in reaches]
        inner, outer = max(ring[0] for ring in rings), min(ring[1] for ring in rings)
        if inner <= outer:
            found.append(Ring(inner, outer, float(bottom), float(top)))
    return body_of(found)


def _reach(meshes: Sequence[Mesh]) -> tuple[Array, Array, Array, Array]:
    """Least and largest radius (n,) and height (n,) mm of the bodies' triangles, and of what they have of the axis."""
    corners = np.concatenate([mesh.vertices[mesh.faces] for mesh in meshes])
    flat, heights = corners[..., :2], corners[..., 2]
    after = np.roll(flat, -1, axis=1)
    way = after - flat
    size = (way**2).sum(axis=-1)
    along = np.clip(-(flat * way).sum(axis=-1) / np.where(size > 0.0, size, 1.0), 0.0, 1.0)
    nearest = np.hypot(*np.moveaxis(flat + along[..., None] * way, -1, 0)).min(axis=1)
    side = flat[..., 0] * after[..., 1] - flat[..., 1] * after[..., 0]
    nearest[(side >= 0.0).all(axis=1) | (side <= 0.0).all(axis=1)] = 0.0  # the axis passes through the triangle
    filled = np.concatenate([_on_axis(mesh) for mesh in meshes])
    return (
        np.concatenate([nearest, np.zeros(len(filled))]),
        np.concatenate([np.hypot(flat[..., 0], flat[..., 1]).max(axis=1), np.zeros(len(filled))]),
        np.concatenate([heights.min(axis=1), filled[:, 0]]),
        np.concatenate([heights.max(axis=1), filled[:, 1]]),
    )


def _on_axis(mesh: Mesh) -> Array:
    """Heights (n, 2) mm from which to which a body has parts of the axis."""
    import manifold3d

    low, high = mesh.box
    if np.any(low[:2] > LEAST_HOLE) or np.any(high[:2] < -LEAST_HOLE):
        return np.empty((0, 2))
    size = (LEAST_HOLE, LEAST_HOLE, high[2] - low[2] + 2.0)
    core = manifold3d.Manifold.cube(size, center=True).translate((0.0, 0.0, (low[2] + high[2]) / 2))
    found = [piece.bounding_box() for piece in (mesh.manifold ^ core).decompose()]
    return np.array([(each[2], each[5]) for each in found], dtype=np.float64).reshape(-1, 2)


def _slice(nearest: Array, farthest: Array, low: Array, high: Array, bottom: float, top: float) -> tuple[float, float]:
    """Least and largest radius (mm) of what is between two heights; inf and 0 if that is nothing."""
    there = (low <= top) & (high >= bottom)
    if not there.any():
        return math.inf, 0.0
    inner = float(nearest[there].min())
    return (inner if inner >= LEAST_HOLE else 0.0), float(farthest[there].max())
