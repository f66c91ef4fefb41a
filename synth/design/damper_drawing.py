"""Drawn dimensions of a chosen damper: measured by the user, else from its catalogue row, else assumed.

Assumed dimensions are named on the drawn part and in the notes, with the project key for the measured value.
"""

from __future__ import annotations

from dataclasses import replace
from math import degrees
from typing import TYPE_CHECKING, Any

from synth.design.leg_design import LegDesign
from synth.files.project_options import DamperShape
from synth.remarks import decisive

if TYPE_CHECKING:
    from synth.cad import DamperDimensions

BESIDE = 10.0  # mm, bolt circle minus body diameter if unknown: the space of M3 screws in a flange
TO_MEASURE = (
    "Measure its hub before anything is made and write shaft_side, shaft_form and shaft_size (and for a round bore "
    "hub: set_screw or clamp) into"
)
# Keys of ``cad.dampers.JOINT``, which are also columns of the catalogue, as text.
ASKED = {
    "outer_diameter": "the body's diameter",
    "body_length": "the body's length from flange to end",
    "bolt_circle": "the circle of its screws",
    "bolts": "their number",
    "bolt_diameter": "their clearance hole",
    "shaft_side": "whether it has a shaft or a bore",
    "shaft_form": "round, d, square or hex",
    "shaft_size": "its diameter or width across flats",
}


def damper_of(design: LegDesign, j: int, shaft: float, notes: list[str]) -> DamperDimensions:
    """The damper of joint ``j`` as it is drawn on a shaft of ``shaft`` mm; assumptions are added to ``notes``."""
    option, name = design.dampers.chosen[j], design.built.joint_names[j]
    row, arrangement = option.row, option.arrangement
    if arrangement.pieces > 1 or arrangement.ratio != 1.0:
        notes.append(
            f"{name}: {option.label}; one damper on the joint's own shaft is drawn, its gear or partner is not"
        )
    own = design.project.cad.damper_shafts.get(name)
    given = design.project.cad.dampers.get(name, DamperShape())
    known: dict[str, Any] = {} if given.hub is None else {"hub": given.hub}
    for key in ASKED:
        value = getattr(given, key)
        if value is None and row is not None:
            value = getattr(row, key) or None
        if value is not None:
            known[key] = value
    if own is not None:
        known |= {"shaft_side": "shaft", "shaft_size": own, "shaft_form": known.get("shaft_form", "d")}
    drawn = drawn_damper(known, shaft, f"cad.dampers.{name}")
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


def drawn_damper(known: dict[str, Any], shaft: float, place: str) -> DamperDimensions:
    """A damper from its known dimensions (SI, keys of ``ASKED``, ``hub``); ``unknown`` names the others by key."""
    from synth import cad

    default = cad.DamperDimensions()
    lengths = {key: float(value) * 1e3 for key, value in known.items() if isinstance(value, float) and key != "bolts"}
    outer = lengths.get("outer_diameter", default.outer_diameter)
    circle = lengths.get("bolt_circle")
    if circle is None:
        circle = max(outer + BESIDE, _room(shaft))
    side, form = known.get("shaft_side"), known.get("shaft_form")
    size = lengths.get("shaft_size")
    adapter = None
    bore = cad.BoreDimensions()
    if side == "shaft":
        across = size if size is not None else shaft
        adapter = cad.AdapterDimensions(across, max(12.0, 2.0 * across), max(16.0, 2.0 * shaft), form=form or "d")
    elif side == "bore" or "hub" in known:
        unstated = "unknown" if form is None else "none"
        bore = cad.BoreDimensions(form or "round", size, known.get("hub", unstated))
    unknown = [f"{words} ({place}.{key})" for key, words in ASKED.items() if key not in known]
    return cad.DamperDimensions(
        outer_diameter=outer,
        body_length=lengths.get("body_length", default.body_length),
        bolt_circle=circle,
        bolt_count=round(known.get("bolts", default.bolt_count)),
        bolt_diameter=lengths.get("bolt_diameter", default.bolt_diameter),
        adapter=adapter,
        bore=bore,
        unknown=tuple(unknown),
    )


def _room(shaft: float) -> float:
    """Bolt circle (mm) outside the collar of the shaft, or of the next larger shaft in case it must grow."""
    from synth.cad.hardware import shaft_parts, shaft_sizes

    thicker = [size for size in shaft_sizes() if size >= shaft][:2]
    return max((2.0 * shaft_parts(size).radius for size in thicker), default=0.0) + BESIDE


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
