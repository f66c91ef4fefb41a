"""Whether a bought spring can be drawn in its joint, before the joint is laid out.

A spring to wind is designed for the same shaft, clearance and travel, so both kinds are judged by the same numbers.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import degrees, inf, radians

from synth.cad.dimensions import CLOSE_WOUND_PITCH, SpringDimensions
from synth.cad.limits import limit_of
from synth.design.clamped_arms import free_arm, seat_length, seats_would_meet
from synth.design.coil_room import arbor_of, fits_round_shaft
from synth.files.project_options import CadOptions, SpringChoice
from synth.parts.rows import TorsionSpringRow
from synth.spring.space import wound_inside_diameter
from synth.spring.spring_task import SpringLimits

STOP_ROOM = radians(3.5)  # beyond the travel; the joint's hard stops are there, and the spring must bear it
ROUNDING = 1.0 - 1e-6  # of converted units
ESTIMATED = 1e-3  # m, error of the estimated reach of an arm: what is shorter by less is judged as drawn


def drawable_sizes(choice: SpringChoice) -> SpringChoice:
    """The choice of a spring to wind, held to the wires and diameters that are drawn, where its own limits allow it."""
    wire, coil = (limit_of(SpringDimensions, name) for name in ("wire_diameter", "mean_diameter"))
    thinnest, thickest, widest = wire.low * 1e-3, wire.high * 1e-3, coil.high * 1e-3
    wires = (max(choice.min_wire_diameter or 0.0, thinnest), min(choice.max_wire_diameter or inf, thickest))
    if wires[0] > wires[1]:  # of another size by the user's own wish, which the drawing then refuses
        return replace(choice, max_outer_diameter=min(choice.max_outer_diameter or widest, widest))
    return replace(
        choice,
        min_wire_diameter=wires[0],
        max_wire_diameter=wires[1],
        max_outer_diameter=min(choice.max_outer_diameter or widest, widest),
    )


def drawn_pitch(row: TorsionSpringRow) -> float | None:
    """Axial advance (mm) of each turn of a body as long as stated; None: close wound, or its length is not stated."""
    if row.body_length is None or row.wire_diameter is None or row.body_coils is None:
        return None
    pitch = (row.body_length - row.wire_diameter) / row.body_coils
    return pitch * 1e3 if pitch > CLOSE_WOUND_PITCH * row.wire_diameter else None


def least_leg(row: TorsionSpringRow, travel: float, opening: float, cad: CadOptions) -> float | None:
    """Length (m) of a leg that reaches through its cap, estimated before the joint is drawn; None: sizes are unknown.

    ``travel``, ``opening`` : rad from the free angle that wind it and that open it.
    """
    if row.wire_diameter is None or row.mean_diameter is None or row.body_coils is None or row.rate is None:
        return None
    free = free_arm(row.wire_diameter, row.mean_diameter, row.body_coils, opening, cad)
    return free + seat_length(row.wire_diameter, row.rate * (travel + STOP_ROOM))


def reasons_not_drawn(row: TorsionSpringRow, travel: float, cad: CadOptions, opening: float = 0.0) -> Iterator[str]:
    """Why the joint cannot be drawn with a bought spring that it winds by ``travel`` rad from its free angle.

    The same text for all springs of a joint, so that they can be counted. ``opening`` : rad, by which it opens it.
    """
    if row.leg_convention not in ("", "tangent"):
        yield f"{row.leg_convention} legs, which are not drawn"
        return
    if row.wire_diameter is None or row.mean_diameter is None or row.body_coils is None or row.included_angle is None:
        yield "cannot be drawn: wire, diameter, coils or included angle is unknown"
        return
    shaft = f"the shaft of {cad.shaft_diameter * 1e3:.4g} mm (cad.shaft_diameter)"
    least = SpringLimits(arbor_diameter=arbor_of(cad)).least_wound_inside()
    assert least is not None
    wound = wound_inside_diameter(row.wire_diameter, row.mean_diameter, row.body_coils, travel + STOP_ROOM)
    sizes = row.wire_diameter, row.mean_diameter, row.body_coils
    if wound < least * ROUNDING or not fits_round_shaft(*sizes, travel, opening, cad):
        yield f"the coil would close on {shaft}"
    if row.max_arbor_diameter is not None and row.max_arbor_diameter < cad.shaft_diameter * ROUNDING:
        yield f"its vendor's max_arbor_diameter is below {shaft}"
    needed = least_leg(row, travel, opening, cad)
    if row.leg_length is not None and needed is not None and row.leg_length < needed - ESTIMATED:
        yield "its legs end before the caps that would clamp them"
    drawn = SpringDimensions(
        row.wire_diameter * 1e3, row.mean_diameter * 1e3, row.body_coils, degrees(row.included_angle), drawn_pitch(row)
    )
    for problem in drawn.problems():
        yield f"cannot be drawn: {problem.dimension.replace('_', ' ')} out of range"
        return
    if seats_would_meet(drawn, row.rate or 0.0, (travel, opening), cad):
        yield "the seats of its arms would meet"
