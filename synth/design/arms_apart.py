"""The angle between the arms of a spring to wind: one at which their seats do not meet in the joint as drawn."""

from __future__ import annotations

from dataclasses import replace
from math import degrees, radians

from synth.cad.dimensions import SpringDimensions
from synth.design.clamped_arms import seats_would_meet
from synth.design.drawable_springs import STOP_ROOM
from synth.files.project_options import CadOptions
from synth.parts.catalogs import Catalogue
from synth.spring.design import SpringResult, design_spring
from synth.spring.spring_requirements import SpringRequirements
from synth.spring.spring_result import SpringDesign

INCLUDED_ANGLE = radians(120.0)  # that of the thesis' springs
# Where the travel closes arms at 120 deg until their seats meet. At 180 deg a spring can be closed and opened equally
# far; what closes it much farther than it opens it, or the reverse, asks for more or for less.
OTHERS = tuple(radians(angle) for angle in (150.0, 180.0, 210.0, 240.0, 90.0))


def first_found(
    wish: SpringRequirements, catalogue: Catalogue, cad: CadOptions | None
) -> tuple[SpringRequirements, SpringDesign | None]:
    """The requirements with an angle at which the seats stay apart, and the first spring that is found for them.

    ``cad``: None where the angle is not free, or nothing is drawn. If no angle keeps them apart, it stays.
    """
    first = _first(design_spring(wish, catalogue, 0, lasting=False, n_nearest=1))  # only its size is needed
    if cad is None or first is None or not _meet(first, wish, cad):
        return wish, first
    for angle in OTHERS:
        wider = replace(wish, included_angle=angle)
        found = _first(design_spring(wider, catalogue, 0, lasting=False, n_nearest=1))
        if found is not None and not _meet(found, wider, cad):
            return wider, found
    return wish, first


def _first(result: SpringResult) -> SpringDesign | None:
    return result.best or (result.nearest[0].design if result.nearest else None)


def _meet(found: SpringDesign, wish: SpringRequirements, cad: CadOptions) -> bool:
    coil = SpringDimensions(
        found.wire_diameter * 1e3, found.mean_diameter * 1e3, found.body_coils, degrees(found.included_angle)
    )
    travel = (wish.travel - STOP_ROOM, wish.opening_travel - STOP_ROOM)
    return seats_would_meet(coil, found.rate, travel, cad)
