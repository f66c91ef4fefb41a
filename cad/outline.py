"""Points and flat outlines: the convex hull of discs, as exact arcs and lines, with its area in closed form."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from synth.cad import kernel

Point = tuple[float, float]
_TINY = 1e-9  # mm, below the modeller's own tolerance of 1e-7
_SHORTEST = 2e-7  # mm: twice the modeller's tolerance, below which it builds no edge


def unit(angle: float) -> Point:
    """Unit vector at ``angle`` deg from +x, counter-clockwise."""
    return math.cos(math.radians(angle)), math.sin(math.radians(angle))


@dataclass(frozen=True)
class Disc:
    """A disc in the plane, mm."""

    x: float
    y: float
    radius: float


@dataclass(frozen=True)
class _Tangent:
    """A straight hull edge from disc ``start`` to disc ``end`` with its outward normal at ``angle`` rad."""

    start: int
    end: int
    angle: float


@dataclass(frozen=True)
class Hull:
    """Convex hull of discs: arcs on discs between straight tangents, counter-clockwise."""

    discs: tuple[Disc, ...]
    tangents: tuple[_Tangent, ...]

    @property
    def arcs(self) -> list[tuple[Disc, float, float]]:
        """(disc, from, to) rad for each arc; with a single disc the whole circle."""
        if not self.tangents:
            return [(self.discs[0], 0.0, 2 * math.pi)]
        result = []
        for tangent, following in zip(self.tangents, self.tangents[1:] + self.tangents[:1], strict=True):
            sweep = (following.angle - tangent.angle) % (2 * math.pi)
            result.append((self.discs[tangent.end], tangent.angle, tangent.angle + sweep))
        return result

    def reach(self, direction: float) -> float:
        """Support function: how far (mm) the hull reaches from the origin in a ``direction``, deg."""
        return _reach([(disc.x, disc.y, disc.radius) for disc in self.discs], direction)

    def half_width_above(self, height: float) -> float:
        """Largest distance (mm) from x = 0 of the outline where y is at least ``height``; arcs in steps of 3 deg."""
        points = []
        for disc, start, end in self.arcs:
            steps = max(1, math.ceil((end - start) / math.radians(3.0)))
            points += [_on(disc, start + (end - start) * index / steps) for index in range(steps + 1)]
        found = [abs(x) for x, y in points if y >= height]
        for (x0, y0), (x1, y1) in zip(points, points[1:] + points[:1], strict=True):
            if (y0 - height) * (y1 - height) < 0.0:
                found.append(abs(x0 + (x1 - x0) * (height - y0) / (y1 - y0)))
        return max(found, default=0.0)

    def gap(self, other: Hull) -> float:
        """Distance (mm) of two hulls; negative where they overlap.

        The width of the widest separating strip. Its direction is perpendicular to an edge of one hull, or from a disc
        of one to a disc of the other (separating axes).
        """
        return max(self._strips(other))

    def clear_of(self, other: Hull, distance: float) -> bool:
        """Whether the gap is at least ``distance`` mm; stops at the first strip of this width."""
        return any(strip >= distance for strip in self._strips(other))

    def _strips(self, other: Hull) -> Iterator[float]:
        """Width (mm) of the strip between the hulls in each direction that may have the widest."""
        ways = [math.atan2(b.y - a.y, b.x - a.x) for a in self.discs for b in other.discs]
        ways += [tangent.angle for tangent in self.tangents]
        ways += [tangent.angle + math.pi for tangent in other.tangents]
        mine = [(disc.x, disc.y, disc.radius) for disc in self.discs]
        theirs = [(disc.x, disc.y, disc.radius) for disc in other.discs]
        for way in ways:
            yield -_reach(mine, math.degrees(way)) - _reach(theirs, math.degrees(way) + 180.0)

    def turned(self, angle: float) -> Hull:
        """The hull turned by ``angle`` deg about the origin."""
        c, s, turn = math.cos(math.radians(angle)), math.sin(math.radians(angle)), math.radians(angle)
        discs = tuple(Disc(c * disc.x - s * disc.y, s * disc.x + c * disc.y, disc.radius) for disc in self.discs)
        return Hull(discs, tuple(_Tangent(t.start, t.end, t.angle + turn) for t in self.tangents))

    @property
    def area(self) -> float:
        """Enclosed area, mm^2, by Green's theorem over arcs and lines."""
        double, points = 0.0, []
        for disc, start, end in self.arcs:
            double += disc.radius**2 * (end - start) + disc.radius * (
                disc.x * (math.sin(end) - math.sin(start)) - disc.y * (math.cos(end) - math.cos(start))
            )
            points.append((_on(disc, start), _on(disc, end)))
        for (_, (x0, y0)), ((x1, y1), _) in zip(points, points[1:] + points[:1], strict=True):
            double += x0 * y1 - x1 * y0
        return double / 2

    def extrude(self, bottom: float, top: float) -> Any:
        """A solid between two heights, mm."""
        if not self.tangents:
            disc = self.discs[0]
            return kernel.cylinder(disc.radius, top - bottom, (disc.x, disc.y, bottom))
        if kernel.in_facets():
            from synth.cad import facets

            points = [at for disc, *sweep in self.arcs for at in facets.arc_points(disc.x, disc.y, disc.radius, *sweep)]
            return facets.extrude_polygon(points, bottom, top)
        import cadquery as cq

        edges, last = [], _on(self.arcs[-1][0], self.arcs[-1][2])
        for disc, start, end in self.arcs:
            first, middle, final = (_on(disc, angle) for angle in (start, (start + end) / 2, end))
            edges.append(cq.Edge.makeLine(cq.Vector(*last, bottom), cq.Vector(*first, bottom)))
            edges.append(cq.Edge.makeThreePointArc(*(cq.Vector(*point, bottom) for point in (first, middle, final))))
            last = final
        face = cq.Face.makeFromWires(cq.Wire.assembleEdges(edges))
        return cq.Solid.extrudeLinear(face, cq.Vector(0, 0, top - bottom))


def _reach(discs: Sequence[tuple[float, float, float]], direction: float) -> float:
    """Support function (mm) of discs (x, y, radius) in a ``direction``, deg; plain code, because it runs often."""
    angle = math.radians(direction)
    x, y = math.cos(angle), math.sin(angle)
    return max([x * a + y * b + radius for a, b, radius in discs])


def _on(disc: Disc, angle: float) -> Point:
    return disc.x + disc.radius * math.cos(angle), disc.y + disc.radius * math.sin(angle)


def hull_of(discs: list[Disc]) -> Hull:
    """Convex hull of one or more discs.

    A directed tangent between two discs is an edge when no disc reaches beyond it; discs are few, so each
    pair is tried against all.
    """
    kept = _outermost(discs)
    tangents: list[_Tangent] = []
    for i, a in enumerate(kept):
        for j, b in enumerate(kept):
            if i == j:
                continue
            distance = math.hypot(b.x - a.x, b.y - a.y)
            along = math.atan2(b.y - a.y, b.x - a.x)
            # The normal n of a common tangent keeps n . (b - a) = ra - rb; on the right of the way from a to b.
            angle = along - math.acos((a.radius - b.radius) / distance)
            normal = (math.cos(angle), math.sin(angle))
            height = normal[0] * a.x + normal[1] * a.y + a.radius
            if all(normal[0] * c.x + normal[1] * c.y + c.radius <= height + _TINY for c in kept):
                tangents.append(_Tangent(i, j, angle % (2 * math.pi)))
    return Hull(tuple(kept), tuple(_without_short_cuts(kept, tangents)))


def _outermost(discs: list[Disc]) -> list[Disc]:
    """The discs without duplicates and without those inside another one, by as much as an edge must have."""
    kept: list[Disc] = []
    for disc in sorted(discs, key=lambda item: -item.radius):
        inside = any(math.hypot(disc.x - o.x, disc.y - o.y) <= o.radius - disc.radius + _SHORTEST for o in kept)
        if not inside:
            kept.append(disc)
    return kept


def _without_short_cuts(discs: list[Disc], tangents: list[_Tangent]) -> list[_Tangent]:
    """Sorted by normal; of several edges on one line (three discs touch it) the longest."""
    result: list[_Tangent] = []

    def length(item: _Tangent) -> float:
        a, b = discs[item.start], discs[item.end]
        return math.hypot(a.x - b.x, a.y - b.y)

    for tangent in sorted(tangents, key=lambda item: item.angle):
        gap = (tangent.angle - result[-1].angle) if result else 1.0
        if gap < 1e-7:
            result[-1] = max(result[-1], tangent, key=length)
        else:
            result.append(tangent)
    if len(result) > 1 and 2 * math.pi - result[-1].angle + result[0].angle < 1e-7:
        longest = max(result[0], result[-1], key=length)
        result = [longest, *result[1:-1]]
    return sorted(result, key=lambda item: item.angle)
