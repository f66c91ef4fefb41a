"""A damper's drawn sizes: stated in the project, else of its catalogue row, else assumed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from synth.files.project_options import CadOptions, DamperShape
from synth.parts.rows import DamperRow

if TYPE_CHECKING:
    from synth.cad import DamperDimensions

BESIDE = 10.0  # mm, bolt circle minus body diameter if unknown: the space of M3 screws in a flange
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


def known_sizes(row: DamperRow | None, name: str, cad: CadOptions) -> dict[str, Any]:
    """What is known of the damper of joint ``name`` (SI, by key): stated in the project, else of its catalogue row."""
    own, given = cad.damper_shafts.get(name), cad.dampers.get(name, DamperShape())
    known: dict[str, Any] = {} if given.hub is None else {"hub": given.hub}
    for key in ASKED:
        value = getattr(given, key)
        if value is None and row is not None:
            value = getattr(row, key) or None
        if value is not None:
            known[key] = value
    if own is not None:
        known |= {"shaft_side": "shaft", "shaft_size": own, "shaft_form": known.get("shaft_form", "d")}
    return known


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
