"""Drawn dimensions of a chosen damper: measured by the user, else from its catalogue row, else assumed.

Assumed dimensions are named on the drawn part and in the notes, with the project key for the measured value.
"""

from __future__ import annotations

from dataclasses import replace
from math import degrees
from typing import TYPE_CHECKING

from synth.design.damper_sizes import drawn_damper, known_sizes
from synth.design.leg_design import LegDesign
from synth.remarks import decisive

if TYPE_CHECKING:
    from synth.cad import DamperDimensions

TO_MEASURE = (
    "Measure its hub before anything is made and write shaft_side, shaft_form and shaft_size (and for a round bore "
    "hub: set_screw or clamp) into"
)


def damper_of(design: LegDesign, j: int, shaft: float, notes: list[str]) -> DamperDimensions:
    """The damper of joint ``j`` as it is drawn on a shaft of ``shaft`` mm; assumptions are added to ``notes``."""
    option, name = design.dampers.chosen[j], design.built.joint_names[j]
    row, arrangement = option.row, option.arrangement
    if arrangement.pieces > 1 or arrangement.ratio != 1.0:
        notes.append(
            f"{name}: {option.label}; one damper on the joint's own shaft is drawn, its gear or partner is not"
        )
    drawn = drawn_damper(known_sizes(row, name, design.project.cad), shaft, f"cad.dampers.{name}")
    if option.turns is not None and arrangement.ratio == 1.0:
        drawn = replace(drawn, travel=degrees(option.turns))
    if drawn.unknown:
        what = option.part or option.label
        notes.append(
            f"{name}: {what} is drawn {_as_drawn(drawn)}; measure and write into the project before printing: "
            + ", ".join(drawn.unknown)
        )
    if drawn.adapter is None and drawn.bore.slips:
        notes.append(decisive(_slips(name), f"{TO_MEASURE} cad.dampers.{name}"))
    return drawn


def _slips(name: str) -> str:
    return (
        f"{name}: what turns the damper with the shaft is unknown: it is drawn with a round bore on the round shaft, "
        "which would slip, so that the joint as drawn has no damping"
    )


def _as_drawn(damper: DamperDimensions) -> str:
    """The damper's drawn dimensions as text."""
    body = f"{damper.outer_diameter:g} mm across and {damper.body_length:g} mm long"
    screws = f"{damper.bolt_count} screws on {damper.bolt_circle:g} mm"
    if damper.adapter is not None:
        form = damper.adapter.form
        shaft = f"with a shaft of its own ({form}, {damper.adapter.output_diameter:g} mm)"
    elif damper.bore.size is None:
        shaft = f"with a {damper.bore.form} bore for the joint's shaft"
    else:
        shaft = f"with a {damper.bore.form} bore of {damper.bore.size:g} mm"
    return f"{body}, {screws}, {shaft}"
