"""The chosen jumping leg as parts: a study's numbers as dimensions, and what was drawn as JSON."""

from __future__ import annotations

import re
from math import degrees
from pathlib import Path
from typing import TYPE_CHECKING, Any

from synth.compiling.solid_kernel import load_cadquery
from synth.remarks import decisive

if TYPE_CHECKING:
    from synth.cad.hopper_joint import HopperDimensions
    from synth.hopper.study import Study
    from synth.jump.hopper_leg import Laminate
    from synth.parts.rows import GearMotorRow

FOLDER = "parts"
SAME_SHAFT = 5e-6  # m: half of the hundredth of a millimetre that the notes would show


def draw_parts(found: Study, folder: Path) -> dict[str, Any]:
    """Write the parts of the chosen leg into ``folder/parts``.

    ``notes`` states what cannot be drawn, or differs from the simulated leg; ``missing``, in a few words, what keeps
    the parts from being that leg.
    """
    load_cadquery()
    from synth.cad.hopper_joint import export_hopper, hip_note
    from synth.cad.limits import DimensionError
    from synth.hopper.leg_as_drawn import JOINTS, leg_as_drawn, links_differ
    from synth.units import quantity

    if found.best is None:
        return {}
    row = found.rows[int(found.sweep.motor[found.best])]
    dimensions = dimensions_of(found, row)
    if isinstance(dimensions, str):
        return {"layers": [], "dimensions": {}, "notes": [decisive(f"no parts are drawn: {dimensions}")]}
    try:
        made = export_hopper(dimensions, folder / FOLDER)
    except DimensionError as error:
        notes = [decisive(f"no parts are drawn: {text}") for text in error.problems]
        return {"layers": [], "dimensions": {}, "notes": notes}
    laminate, leg = found.best_leg.laminate, found.best_leg
    incomplete = hip_note(dimensions)
    notes = [*shaft_notes(found, row), *(decisive(note) if note == incomplete else note for note in made.notes)]
    missing = ["the hip is not complete"]
    hinges = {name: made.gaps[f"{name}_hinge_gap"] for name in JOINTS}
    drawn = leg_as_drawn(found, hinges, dimensions.gap)
    if drawn is not None:
        notes.append(decisive(drawn.note))
    if links_differ(laminate):
        missing.append("flat links as drawn are not those simulated")
        notes.append(decisive(links_note(laminate)))
    return {
        "layers": [
            {"name": layer.name, "material": layer.material, "file": f"{FOLDER}/{layer.name}.dxf",
             "thickness": quantity(layer.thickness * 1e-3, "mm"), "cut_length": quantity(layer.cut_length * 1e-3, "mm"),
             "outlines": len(layer.plates), "width_mm": layer.width,
             "plates_mm": [list(plate) for plate in layer.plates],
             "folds_mm": list(layer.folds), "holes_mm": [list(hole) for hole in layer.holes]}
            for layer in made.layers
        ],
        "files": [f"{FOLDER}/{name}" for name in made.files],
        "dimensions": {
            "hinge_gap": quantity(dimensions.gap * 1e-3, "mm"),
            "flexure_width": quantity(laminate.width, "mm"),
            "film_thickness": quantity(laminate.flexure_thickness, "mm"),
            "flexure_rate": quantity(leg.flexures.rate, "N*m/rad"),
            **{name: quantity(value * 1e-3, "mm") for name, value in made.gaps.items()},
            "film_strain": quantity(max(map(dimensions.film_strain, dimensions.folds)), "1"),
            "kerf": quantity(dimensions.kerf * 1e-3, "mm"),
        },
        **({} if drawn is None else {"as_drawn": drawn.as_json()}),
        "missing": missing,
        "notes": notes,
    }  # fmt: skip


def links_note(laminate: Laminate) -> str:
    """How the drawn links differ from those simulated, and what to do."""
    return (
        f"the links as simulated weigh {1e3 * laminate.mass_per_length:.3g} g/m and bend like E I = "
        f"{laminate.bending_stiffness:.3g} N*m^2, a flat strip of this laminate weighs "
        f"{1e3 * laminate.strip_mass_per_length:.3g} g/m and bends like {laminate.strip_bending_stiffness:.3g} N*m^2: "
        "flat links as drawn are not those; simulate the strip (laminate: {links: strip}), or write thickness, modulus "
        "and density of a laminate that has both. Fold links to stiffen them at the same mass; doubled ones are heavier"
    )


def _shaft_written(found: Study) -> bool:
    return all(default.key != "parts.motor_shaft" for default in found.project.defaults)


def shaft_notes(found: Study, row: GearMotorRow) -> list[str]:
    """That the hub's bore is a guess, or other than the catalogue's shaft."""
    stated, used = row.shaft_size, found.project.parts.motor_shaft
    if stated is None and not _shaft_written(found):
        return [
            f"the catalogue does not state the output shaft of {found.best_motor.name}: the hub's bore is drawn for a "
            f"D shaft of {used * 1e3:g} mm, that of micro metal motors. Measure the shaft and write it as parts: "
            "{motor_shaft: 4 mm}"
        ]
    if stated is not None and _shaft_written(found) and abs(stated - used) > SAME_SHAFT:
        return [
            f"the hub's bore is drawn for a motor_shaft of {used * 1e3:g} mm; the catalogue states a shaft of "
            f"{stated * 1e3:g} mm"
        ]
    return []


def dimensions_of(found: Study, row: GearMotorRow) -> HopperDimensions | str:
    """Millimetres and degrees for the chosen leg; in words why not, where something is not known."""
    from synth.cad.hopper_joint import HopperDimensions

    leg, parts = found.best_leg, found.project.parts
    laminate = leg.laminate
    box = re.match(r"([\d.]+)x([\d.]+)", row.size)
    round_one = re.match(r"diameter ([\d.]+)", row.size)
    if box is None and round_one is None:
        return 'the motor\'s size is not in its catalogue row; write it as "10x12x25 mm" or "diameter 20 mm"'
    if leg.flexures.rate <= 0.0:
        return "a flexure without stiffness has no hinge gap"
    motor = (float(box[2]), float(box[1])) if box else (float(round_one[1]),) * 2 if round_one else (0.0, 0.0)
    return HopperDimensions(
        upper=leg.length * 1e3,
        lower=leg.lower_length * 1e3,
        hip_spacing=leg.hip_spacing * 1e3,
        width=laminate.width * 1e3,
        thickness=laminate.thickness * 1e3,
        film=laminate.flexure_thickness * 1e3,
        adhesive=parts.adhesive * 1e3,
        gap=laminate.hinge_gap(leg.flexures.rate) * 1e3,
        adhesive_gap=parts.adhesive_gap * 1e3,
        crouch=degrees(leg.start),
        extended=degrees(leg.extended),
        shaft=(parts.motor_shaft if row.shaft_size is None or _shaft_written(found) else row.shaft_size) * 1e3,
        motor=motor,
        round_motor=round_one is not None,
        sheet=parts.sheet * 1e3,
        kerf=parts.kerf * 1e3,
        strain=parts.film_strain,
    )
