"""A spring to wind as its joint can be drawn: its arms' seats do not meet, and its bent coil clears the shaft."""

from __future__ import annotations

from dataclasses import replace
from math import degrees, radians

from synth.cad.dimensions import SpringDimensions
from synth.design.clamped_arms import seats_would_meet
from synth.design.coil_room import fits_round_shaft, with_room
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

MOST_ROUNDS = 3  # searches for a coil with more room: the next coil is wider and so is bent a little farther


def first_found(
    wish: SpringRequirements, catalogue: Catalogue, cad: CadOptions, *, drawn: bool, free: bool
) -> tuple[SpringRequirements, SpringDesign | None]:
    """The requirements so that the joint can be drawn, and the first spring that is found for them.

    ``drawn``: whether it is. ``free``: whether the angle between the arms is, which then is one at which the seats stay
    apart; if no angle keeps them apart, it stays.
    """
    wish, first = _roomy(wish, catalogue, cad, drawn=drawn)
    if not (drawn and free) or first is None or not _meet(first, wish, cad):
        return wish, first
    for angle in OTHERS:
        wider, found = _roomy(replace(wish, included_angle=angle), catalogue, cad, drawn=drawn)
        if found is not None and not _meet(found, wider, cad):
            return wider, found
    return wish, first


def with_room_on_shaft(
    wish: SpringRequirements,
    catalogue: Catalogue,
    cad: CadOptions,
    *,
    drawn: bool,
    lasting: bool,
    n_nearest: int | None = None,
) -> SpringResult:
    """What is found with the room on the arbor that the coil takes as its joint holds it, if that is ``drawn``.

    ``lasting``, ``n_nearest`` : as of ``design_spring``.
    """
    result = design_spring(wish, catalogue, 0, lasting=lasting, n_nearest=n_nearest)
    for _ in range(MOST_ROUNDS):
        best = result.best
        if not drawn or best is None or fits_round_shaft(*_sizes(best), *_moved(wish), cad):
            break
        wish = with_room(wish, best, _moved(wish), cad)
        result = design_spring(wish, catalogue, 0, lasting=lasting, n_nearest=n_nearest)
    return result


def _roomy(
    wish: SpringRequirements, catalogue: Catalogue, cad: CadOptions, *, drawn: bool
) -> tuple[SpringRequirements, SpringDesign | None]:
    """The first that is found, and its requirements; only its size is needed."""
    result = with_room_on_shaft(wish, catalogue, cad, drawn=drawn, lasting=False, n_nearest=1)
    return result.wish, _first(result)


def _sizes(found: SpringDesign) -> tuple[float, float, float]:
    return found.wire_diameter, found.mean_diameter, found.body_coils


def _moved(wish: SpringRequirements) -> tuple[float, float]:
    """Travel (rad) of the motion that winds and that opens the spring, which is made for a little more."""
    return wish.travel - STOP_ROOM, wish.opening_travel - STOP_ROOM


def _first(result: SpringResult) -> SpringDesign | None:
    return result.best or (result.nearest[0].design if result.nearest else None)


def _meet(found: SpringDesign, wish: SpringRequirements, cad: CadOptions) -> bool:
    coil = SpringDimensions(
        found.wire_diameter * 1e3, found.mean_diameter * 1e3, found.body_coils, degrees(found.included_angle)
    )
    return seats_would_meet(coil, found.rate, _moved(wish), cad)
