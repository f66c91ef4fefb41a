"""Vendors' and laboratories' words for a column, a unit or a value, translated to the catalogue's.

Only unambiguous words are translated; others are reported with the nearest known name.
"""

from __future__ import annotations

import re

from synth.errors import UserError
from synth.units import factor

# Header in lower case with _ for all but letters and digits -> the catalogue's column.
NAMES = {
    "part_number": "part", "part_no": "part", "part_nr": "part", "item_number": "part", "stock_number": "part",
    "catalog_number": "part", "catalogue_number": "part", "sku": "part", "model": "part", "model_number": "part",
    "part_num": "part", "pn": "part", "p_n": "part", "item_no": "part", "item_nr": "part", "article_number": "part",
    "article_no": "part", "catalog_no": "part", "catalogue_no": "part", "order_number": "part", "mpn": "part",
    "mfr": "vendor", "mfg": "vendor", "mfr_name": "vendor", "manufacturer_name": "vendor", "company": "vendor",
    "wire_material": "material", "spring_material": "material", "material_type": "material", "temper": "material",
    "wire_d": "wire_diameter", "wire_diam": "wire_diameter", "outer_diam": "outer_diameter",
    "num_coils": "body_coils", "num_of_coils": "body_coils", "no_coils": "body_coils", "coil_count": "body_coils",
    "spring_constant": "rate", "stiffness": "rate", "torsional_stiffness": "rate",
    "manufacturer": "vendor", "supplier": "vendor", "brand": "vendor", "maker": "vendor",
    "wire": "wire_diameter", "wire_dia": "wire_diameter", "wire_size": "wire_diameter",
    "od": "outer_diameter", "o_d": "outer_diameter", "outer_dia": "outer_diameter", "outside_dia": "outer_diameter",
    "outside_diameter": "outer_diameter", "coil_od": "outer_diameter",
    "id": "inner_diameter", "i_d": "inner_diameter", "inner_dia": "inner_diameter", "inside_dia": "inner_diameter",
    "inside_diameter": "inner_diameter", "coil_id": "inner_diameter",
    "coils": "body_coils", "number_of_coils": "body_coils", "no_of_coils": "body_coils", "turns": "body_coils",
    "spring_rate": "rate", "torque_rate": "rate", "angular_rate": "rate",
    "leg_angle": "included_angle", "free_angle": "included_angle", "free_position": "included_angle",
    "legs": "leg_convention", "leg_type": "leg_convention", "leg_style": "leg_convention",
    "leg": "leg_length", "arm_length": "leg_length", "free_length": "body_length", "body_width": "body_length",
    "torque": "max_torque", "maximum_torque": "max_torque", "rated_torque": "max_torque", "torque_max": "max_torque",
    "deflection": "max_deflection", "maximum_deflection": "max_deflection", "max_angle": "max_deflection",
    "wind": "hand", "winding": "hand", "wind_direction": "hand", "winding_direction": "hand",
    "direction_of_wind": "hand", "hand_of_wind": "hand",
    "rated_speed": "speed", "maximum_speed": "max_speed", "speed_max": "max_speed", "damping_direction": "direction",
    "tolerance": "rate_tolerance", "bolt_circle_diameter": "bolt_circle", "bcd": "bolt_circle", "pcd": "bolt_circle",
    "number_of_bolts": "bolts", "mounting_holes": "bolts", "hole_diameter": "bolt_diameter",
    "shaft_shape": "shaft_form", "shaft_type": "shaft_side", "shaft_diameter": "shaft_size",
    "body_diameter": "outer_diameter",
}  # fmt: skip
UNITS = {
    "in-lb": "lbf*in", "in-lbs": "lbf*in", "lb-in": "lbf*in", "in lb": "lbf*in", "in.-lb.": "lbf*in",
    "in-lb/deg": "lbf*in/deg", "in-lbs/deg": "lbf*in/deg", "lb-in/deg": "lbf*in/deg",
    "in-oz": "ozf*in", "oz-in": "ozf*in", "in-oz/deg": "ozf*in/deg", "oz-in/deg": "ozf*in/deg",
    "Nm": "N*m", "N-m": "N*m", "Nm/rad": "N*m/rad", "Nm/deg": "N*m/deg", "N-m/rad": "N*m/rad",
    "Nmm": "N*mm", "N-mm": "N*mm", "Nmm/deg": "N*mm/deg", "N-mm/deg": "N*mm/deg", "Ncm": "N*cm",
    "inch": "in", "inches": "in", "in.": "in", '"': "in", "degree": "deg", "degrees": "deg", "°": "deg",
    "RPM": "rpm", "r/min": "rpm", "min-1": "rpm", "percent": "%",
}  # fmt: skip
VALUES = {
    "hand": {"rh": "right", "lh": "left", "r": "right", "l": "left", "right hand": "right", "left hand": "left",
             "right-hand": "right", "left-hand": "left"},
    "direction": {"dual": "both", "two-way": "both", "bidirectional": "both", "bi-directional": "both",
                  "cw": "clockwise", "ccw": "counter-clockwise", "uni": "one-way", "unidirectional": "one-way",
                  "one way": "one-way"},
    "leg_convention": {"tangential": "tangent"},
    "shaft_form": {"flat": "d", "d-shaft": "d", "d shaft": "d", "hexagon": "hex", "hexagonal": "hex"},
    "shaft_side": {"male": "shaft", "female": "bore", "hollow": "bore", "through": "bore"},
    "continuous": {"true": "yes", "false": "no"},
}  # fmt: skip
COUNTS = ("body_coils", "bolts")  # counted quantities, without a unit
COUNTED = ("turns", "turn", "coils", "pcs", "")  # what vendors write as their unit
PLAIN_MATERIALS = ("music", "piano", "hard drawn", "oil tempered", "chrome", "stainless", "phosphor", "spring brass")
_TITLE = re.compile(r"\s*(?P<name>[^\[\]()]*?)\s*(?:[\[(](?P<unit>[^\[\]()]*)[\])])?\s*")


def standard(title: str, known: frozenset[str]) -> str:
    """A header in the catalogue's form, ``wire_diameter [mm]`` for ``Wire Dia. (mm)``; others unchanged.

    ``known``: the catalogue's own columns, which are never renamed. ``d`` or ``torque`` alone are unchanged
    if the catalogue knows them.
    """
    match = _TITLE.fullmatch(title)
    if match is None:
        return title
    name = match["name"].strip()
    plain = re.sub(r"[^a-z0-9]+", "_", name.casefold()).strip("_")
    if plain in known:
        name = plain
    elif plain in NAMES:
        name = NAMES[plain]
    else:
        return title
    unit = match["unit"]
    if name in COUNTS and (unit is None or unit.strip().casefold() in COUNTED):
        unit = "1"
    return name if unit is None else f"{name} [{UNITS.get(unit.strip(), unit.strip())}]"


def unit_in(title: str, canonical: str) -> str | None:
    """The unit in a header, as ``N*mm/deg`` of ``Rate [Nmm/deg]``; None where there is none of ``canonical``'s kind."""
    match = _TITLE.fullmatch(title)
    written = "" if match is None else (match["unit"] or "").strip()
    unit = UNITS.get(written, written)
    try:
        factor(unit, canonical)
    except UserError:
        return None  # a remark: Diameter (outside)
    return unit


def quantity_unit(title: str) -> str:
    """The unit in a header that is a quantity's, ``mm`` of ``Mandrel (mm)``; empty where there is none.

    A currency and a remark, as in ``Diameter (outside)``, are no units.
    """
    match = _TITLE.fullmatch(title)
    written = "" if match is None else (match["unit"] or "").strip()
    unit = UNITS.get(written, written)
    try:
        factor(unit, unit)
    except UserError:
        return ""  # it says nothing of a quantity: no unit is the answer
    return unit


def standard_value(column: str, text: str) -> str:
    """A word of a column with choices as the catalogue writes it."""
    folded = " ".join(text.casefold().split())
    if column == "material":
        return folded if folded.startswith(PLAIN_MATERIALS) else text  # numbers of standards stay as written
    return VALUES.get(column, {}).get(folded, folded if column in VALUES else text)
