"""DXF files with reproducible bytes, and the flat brackets of a joint in them."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from synth.cad.encoder_seat import collar_room, floor_bore, seat_bore, seat_step
from synth.cad.joint import BuiltJoint
from synth.cad.layout import seat_screws
from synth.cad.outline import Point
from synth.cad.outlines import flange_size, mount_screws
from synth.cad.parts import file_name

Circle = tuple[Point, float]


@contextmanager
def drawing(path: Path) -> Iterator[tuple[Any, Any]]:
    """An ezdxf document in millimetres and its model space, saved to ``path`` at the end without time stamps."""
    ezdxf: Any = importlib.import_module("ezdxf")  # its types do not cover its documented names
    fixed = ezdxf.options.write_fixed_meta_data_for_testing
    ezdxf.options.write_fixed_meta_data_for_testing = True  # no time stamps, no random identifiers
    try:
        document = ezdxf.new("R2010", units=ezdxf.units.MM)
        document.layers.add("CUT", color=1)
        yield document, document.modelspace()
        for name in sorted(document.entitydb.dxf_types_in_use()):  # ezdxf would iterate over a set, in any order
            document.classes.add_class(name)
        document.saveas(path)
    finally:
        ezdxf.options.write_fixed_meta_data_for_testing = fixed


@dataclass(frozen=True)
class FlatBracket:
    """One sheet of a bracket of constant cross-section: outline and holes, mm, seen from its outer face.

    ``outline``: a radius about the origin, or the width and height of a rectangle about it.
    """

    name: str
    outline: float | tuple[float, float]
    holes: tuple[Circle, ...]
    thickness: float


def flat_brackets(joint: BuiltJoint) -> tuple[FlatBracket, ...]:
    """The sheets of damper bracket, encoder seat and mount, for cutting instead of printing.

    A stack of sheets has no inserts but through holes, for longer screws with nuts.
    """
    d, layout = joint.dimensions, joint.layout
    name, damper = file_name(d.name), d.damper
    screws = tuple((at, damper.bolt_diameter / 2) for at in layout.screws)
    middle = (0.0, 0.0)
    found = [
        FlatBracket(f"{name}_damper_bracket_sheet", layout.bracket_radius, ((middle, layout.bracket_bore), *screws),
                    layout.bracket_height),
    ]  # fmt: skip
    if d.encoder is not None:
        small = tuple((at, d.encoder.bolt_diameter / 2) for at in seat_screws(d.encoder, layout.upper.direction))
        room = collar_room(d)
        layers = [("base", seat_bore(d), room)]
        if room < seat_step(d):  # the sensor lies on a floor above the collar
            layers.append(("floor", floor_bore(d), seat_step(d) - room))
        layers.append(("ring", d.encoder.body_diameter / 2 + d.fit, d.encoder.body_depth))
        found += [
            FlatBracket(f"{name}_encoder_seat_{layer}", layout.seat_radius, ((middle, hole), *small), thick)
            for layer, hole, thick in layers
        ]
    if d.mount is not None:
        bolts = tuple((at, d.mount.bolt_diameter / 2) for at in mount_screws(d, layout))
        found.append(FlatBracket(f"{name}_mount", flange_size(d, layout), bolts, d.mount.thickness))
    return tuple(found)


def write_flat(bracket: FlatBracket, path: Path) -> None:
    """Write a flat bracket: cuts on layer CUT, name and thickness on layer TEXT."""
    with drawing(path) as (document, space):
        document.layers.add("TEXT", color=3)
        cut = {"layer": "CUT"}
        if isinstance(bracket.outline, tuple):
            x, y = bracket.outline[0] / 2, bracket.outline[1] / 2
            space.add_lwpolyline([(-x, -y), (x, -y), (x, y), (-x, y)], close=True, dxfattribs=cut)
            low = -y
        else:
            space.add_circle((0.0, 0.0), bracket.outline, dxfattribs=cut)
            low = -bracket.outline
        for at, radius in bracket.holes:
            space.add_circle(at, radius, dxfattribs=cut)
        label = f"{bracket.name}, {bracket.thickness:.2f} mm thick"
        space.add_text(label, height=3.0, dxfattribs={"layer": "TEXT"}).set_placement((0.0, low - 6.0))
