"""Meaning of each column of the built-in catalogues, by file; a test compares them with the files and their classes."""

from __future__ import annotations

_PART = {"part": "As the vendor writes it.", "vendor": "Who sells it."}
_STATUS = {
    "price": "Of one, with one currency, such as 12.50 EUR; the built-in tables state none.",
    "status": "`complete`, or what is missing or wrong; if your own table omits it, it is determined.",
    "source": "Where the row comes from.",
    "as_published": "The original figures and units.",
    "note": "Points to note.",
}
_STANDARD = {
    "standard": "The standard of its sizes.",
    "source": "Where the row comes from; `memory`: measure the part.",
}
_BODY = {
    "bore": "Of the shaft that it sits on.",
    "outer_diameter": "Its outer diameter.",
    "width": "Along the shaft.",
    "thickness": "Along the shaft or screw.",
    "size": "Nominal diameter.",
    "lengths": "Sold lengths, separated by semicolons.",
    "hole": "Hole that it goes through or into.",
    "head_diameter": "Of the head.",
    "head_height": "Of the head.",
}


def _standard(*names: str, **others: str) -> dict[str, str]:
    """A standard part's columns."""
    return {"standard": _STANDARD["standard"], **{n: _BODY[n] for n in names}, **others, "source": _STANDARD["source"]}


_BEARING = {"designation": "The maker's number.", "sold_as": "As shops write it."}
_BEARING |= {"static_load": "Static load rating.", "mass": "Of one."}
_NUT = {"across_flats": "Width over two flats.", "height": "Along the screw."}
_INSERT = {"maker": "Whose insert.", "length": "Along the screw."}

CATALOGUES: dict[str, dict[str, str]] = {
    "torsion_springs.csv": {
        **_PART,
        "material": "A material of `wire_materials.csv`, by name or usual spelling (`ASTM A228`, `302`, `17-7PH`); "
        "stainless and 304 use the values of 302.",
        "hand": "`left` or `right` wound.",
        "included_angle": "Between the two legs of the free spring; at most 360°.",
        "leg_convention": "`tangent`: included angle = 180° - 360° frac(body_coils); `radial`, `axial`: "
        "360° frac(body_coils).",
        "rate": "Torque per angle.",
        "rate_basis": "`published`, by whom, or how it was derived (maximum torque over the deflection at it).",
        "wire_diameter": "Of the wire.",
        "outer_diameter": "Of the coil: inner diameter plus two wire diameters, within 3 %.",
        "inner_diameter": "Of the coil.",
        "body_coils": "Coils of the body.",
        "leg_length": "Of each leg, from the coil's axis. In a drawn joint it must reach through its cap; "
        "a longer one is cut.",
        "body_length": "Of the free spring's coil along its axis. If it is longer than touching coils, their "
        "gaps are drawn.",
        "body_length_at_max_torque": "The same at maximum torque: winding adds coils.",
        "max_arbor_diameter": "Thickest shaft that the vendor allows inside; that of a drawn joint is no thicker.",
        "max_torque": "The vendor's limit: springs that a joint would load more are not chosen.",
        "max_deflection": "At the maximum torque: springs that a joint would turn further are not chosen.",
        "rate_tolerance": "Plus or minus, at most 90 %, where the vendor states it; else 10 %.",
        "free_angle_tolerance": "Plus or minus, where the vendor states it; else 10° to 10 coils, 15° beyond (Lee).",
        **_STATUS,
    },
    "dampers.csv": {
        **_PART,
        "product_line": "As the vendor writes it.",
        "direction": "`both`, `clockwise`, `counter-clockwise`, or `one-way` where it is not known which.",
        "continuous": "`yes`: unlimited rotation; `no`: internal stops.",
        "travel": "Largest angle where it is not continuous.",
        "min_torque": "Differs from the greatest where the vendor gives a range over variants.",
        "max_torque": "Torque at the speed; a complete row has one torque.",
        "speed": "At which the torque holds; empty: the maximum speed.",
        "max_speed": "Highest speed that the vendor allows.",
        "temperature": "At which the torque holds.",
        "reverse_torque": "In the free direction of a one-way damper.",
        "outer_diameter": "Of the body.",
        "body_length": "From the flange to the end.",
        "bolt_circle": "Circle of the screws' centres.",
        "bolts": "How many screws.",
        "bolt_diameter": "Of their clearance holes.",
        "shaft_side": "`shaft`: the damper has one; `bore`: it takes the joint's.",
        "shaft_form": "`round`, `d`, `square` or `hex`.",
        "shaft_size": "Its diameter, or its width across the flats.",
        "min_temperature": "Of use.",
        "max_temperature": "Of use.",
        "torque_tolerance": "Plus or minus, at most 90 %, where the vendor states it; else 15 % is assumed.",
        "torque_per_kelvin": "Change with temperature; else -0.49 %/K (TOK TD14).",
        **_STATUS,
    },
    "damper_curves.csv": {
        "part": "Of the damper.",
        "vendor": "Of the damper; empty: any.",
        "speed": "Above 0, a row a point.",
        "torque": "At that speed; with two or more points the curve is used, and below the lowest the power law of the "
        "lowest points.",
        **_STATUS,
    },
    "wire_diameters.csv": {
        "series": "The list that contains the size.",
        "material": "Material of the list; empty: sizes for any material.",
        "grade": "Of the material.",
        "system": "`inch` or `metric`.",
        "gauge": "The trade's number.",
        "nominal_size": "As listed.",
        "diameter": "Of the wire.",
        "min_tensile_strength": "As delivered; designs use it.",
        "max_tensile_strength": "As delivered.",
        "diameter_tolerance": "Plus or minus.",
        **_STATUS,
    },
    "wire_materials.csv": {
        "material": "Material of the record.",
        "record": "`strength power law`: S = strength_at_1_mm / d^strength_exponent; `strength logarithmic law`: "
        "S = log_law_strength_at_1_mm - log_law_drop_per_decade log10(d/mm), at most strength_cap; `modulus`; "
        "`static bending limit`; `repeated bending limit`.",
        "name_as_published": "Name in the source.",
        "standard": "Standard named by the source.",
        "min_diameter": "Of wire for which it holds.",
        "max_diameter": "Of wire for which it holds.",
        "strength_at_1_mm": "Of the power law.",
        "strength_exponent": "Of the power law.",
        "log_law_strength_at_1_mm": "Of the logarithmic law.",
        "log_law_drop_per_decade": "Of the logarithmic law.",
        "strength_cap": "Of the logarithmic law.",
        "elastic_modulus": "In tension.",
        "shear_modulus": "In torsion.",
        "density": "Of the material.",
        "elastic_limit_tension_low": "Least elastic limit in tension, as a share of the tensile strength.",
        "elastic_limit_tension_high": "Greatest elastic limit in tension, as a share of the tensile strength.",
        "elastic_limit_torsion_low": "Least elastic limit in torsion, as a share of the tensile strength.",
        "elastic_limit_torsion_high": "Greatest elastic limit in torsion, as a share of the tensile strength.",
        "static_bending_limit": "Bending stress at yield as a share of the tensile strength, when stress relieved.",
        "static_bending_limit_not_relieved": "The same without stress relief.",
        "repeated_bending_limit_1e5": "Stress range from zero for 100 000 cycles, as a share of the tensile strength.",
        "repeated_bending_limit_1e6": "The same for a million cycles.",
        "relative_cost": "Relative to hard drawn wire.",
        **_STATUS,
    },
    "gearmotors.csv": {
        "part": "Our name: motor size, winding, voltage and nominal ratio.",
        "vendor": "Who sells it.",
        "product_line": "As the maker writes it.",
        "variant": "Winding.",
        "items": "The maker's numbers, where they are known.",
        "gear_ratio": "Exact.",
        "voltage": "Voltage of all other values; speed and torque are proportional to it.",
        "no_load_speed": "At the output shaft.",
        "stall_torque": "At the output shaft; the maker extrapolates it from lighter loads.",
        "stall_current": "Of the motor.",
        "no_load_current": "Of the motor.",
        "mass": "Of motor and gearbox; the mean if the maker gives a range.",
        "torque_limit": "Permissible momentary torque of the gearbox; empty: not known, none is held against it.",
        "speed_tolerance": "Plus or minus, of the no-load speed.",
        "current_tolerance": "Plus or minus, of the no-load current.",
        "resistance": "Of the winding; only in your own rows, if known.",
        "inductance": "Of the winding; only in your own rows, if known.",
        "rotor_inertia": "Of the rotor; only in your own rows, if known.",
        "speed_at_best_efficiency": "The maker's point of best efficiency.",
        "torque_at_best_efficiency": "The maker's point of best efficiency.",
        "current_at_best_efficiency": "The maker's point of best efficiency.",
        "size": "Of the body, `10x12x25 mm` or `diameter 20 mm`.",
        "shaft_size": "Diameter of the output shaft; empty: not known.",
        "basis": "`found`; `found; ...`: what was taken from another row; `derived`: between found rows.",
        **_STATUS,
    },
    "machine_screws.csv": _standard("size", "head_diameter", "head_height", "hole", "lengths"),
    "socket_screws.csv": _standard("size", "head_diameter", "head_height", "hole", "lengths"),
    "plain_washers.csv": _standard("size", "outer_diameter", "thickness"),
    "hexagon_nuts.csv": _standard("size", **_NUT),
    "heat_set_inserts.csv": _standard("size", "hole", **_INSERT),
    "ball_bearings.csv": _standard("bore", "outer_diameter", "width", **_BEARING),
    "shaft_collars.csv": _standard("bore", "outer_diameter", "width", set_screw="Its screw."),
    "shim_rings.csv": _standard("bore", "outer_diameter", "thickness"),
    "dowel_pins.csv": _standard("size", "lengths"),
}
