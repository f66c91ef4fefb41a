"""The shapes from which every solid of a joint is built: exact ones (cadquery), or fine facets for masses alone.

The builders describe a part once. Within ``faceted()`` they build ``facets.Facets`` instead of cadquery's solids, which
have the same methods: ``fuse``, ``cut``, ``rotate``, ``translate``, ``mirror``, ``Solids``. Dimensions are read without
either kernel, so both are imported where they are used.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from functools import lru_cache
from typing import Any

from synth.cad.moments import Moments, Vector, exact_moments

_faceted: ContextVar[bool] = ContextVar("faceted", default=False)
UP: Vector = (0.0, 0.0, 1.0)  # along the hinge


@contextmanager
def faceted() -> Iterator[None]:
    """Within the block everything is built of facets."""
    token = _faceted.set(True)
    try:
        yield
    finally:
        _faceted.reset(token)


def in_facets() -> bool:
    """Whether facets are built."""
    return _faceted.get()


def cylinder(
    radius: float, height: float, base: Vector = (0.0, 0.0, 0.0), direction: Vector = UP, angle: float = 360.0
) -> Any:
    """A cylinder on its base's centre, mm; of less than 360 deg, which stands on z: a sector from the x axis on."""
    if in_facets():
        from synth.cad import facets

        return facets.cylinder(radius, height, base, direction, angle)
    import cadquery as cq

    return cq.Solid.makeCylinder(radius, height, cq.Vector(*base), cq.Vector(*direction), angle)


def block(size: Vector, corner: Vector) -> Any:
    """A cuboid along the axes, mm."""
    if in_facets():
        from synth.cad import facets

        x, y, z = corner
        points = [(x, y), (x + size[0], y), (x + size[0], y + size[1]), (x, y + size[1])]
        return facets.extrude_polygon(points, z, z + size[2])
    import cadquery as cq

    return cq.Solid.makeBox(*size, cq.Vector(*corner))


def prism(corners: Sequence[Vector], way: Vector) -> Any:
    """A flat convex polygon extruded along a vector, mm."""
    if in_facets():
        from synth.cad import facets

        return facets.prism(corners, way)
    import cadquery as cq

    face = cq.Face.makeFromWires(cq.Wire.makePolygon([cq.Vector(*corner) for corner in corners], close=True))
    return cq.Solid.extrudeLinear(face, cq.Vector(*way))


def placed(build: Callable[..., Any], arguments: tuple[Any, ...], shift: Vector) -> Any:
    """``build(*arguments)`` shifted by mm; the solid is built, and its mesh made, once for all its places.

    A joint has two dozen screws of a handful of sizes.
    """
    solid = _built_once(build, arguments, faceted=in_facets())
    if in_facets():
        return solid.translate(shift)
    import cadquery as cq

    return solid.moved(cq.Location(cq.Vector(*shift)))


@lru_cache(maxsize=256)  # some twenty a leg
def _built_once(build: Callable[..., Any], arguments: tuple[Any, ...], *, faceted: bool) -> Any:
    return build(*arguments)


def moments(solid: Any) -> Moments:
    """The moments of a solid of either kind."""
    return solid.moments() if is_faceted(solid) else exact_moments(solid)


def heights(solid: Any) -> tuple[float, float]:
    """Least and largest z of a solid of either kind, mm."""
    if is_faceted(solid):
        box = solid.body.bounding_box()
        return float(box[2]), float(box[5])
    box = solid.BoundingBox()
    return float(box.zmin), float(box.zmax)


def is_faceted(solid: Any) -> bool:
    """Whether a solid is one of facets."""
    from synth.cad.facets import Facets

    return isinstance(solid, Facets)
