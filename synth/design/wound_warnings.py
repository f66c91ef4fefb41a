"""What is told of a spring to wind, from the spring itself: a drawn joint gives it other arms and another diameter."""

from __future__ import annotations

from dataclasses import replace
from math import degrees

from synth.design.drawable_springs import STOP_ROOM
from synth.remarks import about, decisive
from synth.spring.design import SpringResult
from synth.spring.nearest_springs import NearestSpring
from synth.spring.spring_result import DESIGN_LIFE, SpringDesign

TAKEN_FIRST = ("parallel", "smaller_travel", "other_material", "more_room")  # kinds of the nearest springs


def nearest_taken(result: SpringResult) -> NearestSpring:
    """The one of the nearest springs that is wound, where no spring meets the requirements."""
    return min(result.nearest, key=lambda item: TAKEN_FIRST.index(item.kind))


def nearest_as_made(result: SpringResult, made: SpringDesign) -> tuple[NearestSpring, ...]:
    """The nearest springs, the one that is wound as it is made: ``made``, with the arms of its joint."""
    if result.best is not None or not result.nearest:
        return result.nearest
    taken = nearest_taken(result)
    return tuple(replace(item, design=made) if item is taken else item for item in result.nearest)


def wound_warnings(joint: str, rate: float, result: SpringResult, made: SpringDesign) -> list[str]:
    """Why a spring to wind differs from what was asked, or what to note of it.

    Parameters
    ----------
    rate
        N m/rad, which was asked of all springs of the joint together.
    result
        the search in which the spring was found.
    made
        the spring as it is to be wound.
    """
    if result.best is not None:
        warnings = [about(joint, text) for text in (*result.notes, *made.warnings)]
        return [*warnings, *(f"{joint}: to last {DESIGN_LIFE:.0f} full turns: {it.text}" for it in result.lasting[:1])]
    nearest = nearest_taken(result)
    text = (
        f"{joint}: no single spring can have {rate:.4g} N*m/rad over {degrees(result.wish.travel - STOP_ROOM):.1f} deg"
        f": {'; '.join(result.binding)}. The nearest that can be made is taken, with room for the stops wound by up to "
        f"{degrees(made.travel):.1f} deg and opened by {degrees(made.opening_travel):.1f} deg: "
        f"{replace(nearest, design=made).text}"
    )
    return [decisive(text)]
