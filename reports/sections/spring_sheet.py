"""The sheet of a spring to make, or the limits that prevent it and the nearest possible ones."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from markupsafe import Markup

from synth.reports.figures.spring_drawing import DrawnSpring, spring_drawing
from synth.reports.quantities import in_si, text
from synth.reports.reading import Json, Result, value_of
from synth.reports.section import AbsentResult, ReportSection, mapping, sequence
from synth.reports.sections.warnings import text_of
from synth.reports.sections.winding_plan import arms_of, in_millimetres, is_clamped, winding_of

# Key of ``make`` -> its label and its equation. In the order of the sheet: dimensions, function, strength.
WIND = (
    ("wire_diameter", "wire diameter d", ""), ("mean_diameter", "mean coil diameter D", "E12"),
    ("outer_diameter", "outside diameter, free", "E16"), ("widest_outer_diameter", "outside diameter, widest", "E16"),
    ("inside_diameter", "inside diameter, free", "E16"),
    ("body_coils", "coils of the body", "E17"), ("included_angle", "included angle of the free arms", "E17"),
    ("body_length", "body length, free", "E16"), ("wound_body_length", "body length at full travel", "E16"),
    ("mandrel_diameter", "first mandrel to try", "E18"), ("mandrel_turns", "turns on it", "E18"),
    ("wire_length", "wire length", "E16"), ("cut_length", "wire to cut, with ends to hold and trim", ""),
    ("mass", "mass", "E16"),
)  # fmt: skip
ACT = (
    ("rate", "spring rate", "E12"), ("rate_bending_form", "rate, bending form", "E12"),
    ("rate_friction_form", "rate, friction form", "E12"), ("rate_factor", "rate over its form, from wound samples", ""),
    ("test_rate", "rate in the loose test", "E12"),
    ("test_active_coils", "active coils in the loose test", "E13"),
    ("test_force", "force of a pin in the loose test, full travel", ""),
    ("active_coils", "active coils, arms included", "E13"),
    ("elastic_modulus", "elastic modulus E", ""), ("travel", "travel, winding", ""),
    ("opening_travel", "travel, opening", ""), ("moment", "torque at full travel", "E2"),
    ("opening_moment", "torque at the opening travel", "E2"),
    ("peak_moment", "largest bending moment in the wire", "E20"),
    ("energy", "energy at full travel", "E12"), ("arms_force", "force at the end of an arm", ""),
    ("arms_axis_force", "force on the joint's axis, at most", "E20"),
    ("arms_share_of_angle", "share of the angle that the arms bend", "E13"),
)  # fmt: skip
LAST = (
    ("stress", "bending stress at full travel", "E14"), ("allowed_stress", "allowed stress", "E15"),
    ("yield_stress", "yield stress in bending", "E15"), ("tensile_strength", "tensile strength", "E15"),
    ("safety", "yield over stress, least", "E15"), ("free_travel", "travel to yield", "E15"),
    ("free_opening_travel", "travel to yield, opening", "E15"),
    ("safety_1e5", "strength over stress, 10⁵ cycles", "E19"),
    ("safety_1e6", "strength over stress, 10⁶ cycles", "E19"),
    ("stress_amplitude", "stress amplitude", "E19"), ("stress_mean", "mean stress", "E19"),
    ("arms_stress", "stress in the arms", "E14"), ("arms_bend_radius", "bend radius of the arms", ""),
    ("index", "spring index D/d", "E14"), ("curvature_factor", "curvature factor", "E14"),
    ("arbor_diameter", "arbor diameter", ""), ("wound_inside_diameter", "inside diameter at full travel", "E16"),
    ("arbor_clearance", "clearance on the arbor at full travel", "E16"),
)  # fmt: skip
_COMPARED = ("wire_diameter", "mean_diameter", "widest_outer_diameter", "active_coils", "rate", "stress",
             "allowed_stress", "travel", "free_travel", "body_length", "wound_body_length", "mass")  # fmt: skip
_AS_HELD = ("rate", "rate_bending_form", "rate_friction_form", "active_coils")  # a joint's clamped arms change them
_KINDS = {"more_room": "more room", "parallel": "several in parallel", "smaller_travel": "a smaller travel"}
_KINDS |= {"other_material": "another wire"}


def content(result: Result) -> dict[str, Any] | AbsentResult:
    """A sheet for each joint whose spring is to be made."""
    sheets = []
    for name, joint in mapping(result.content, "joints").items():
        spring = mapping(joint, "spring")
        if "make" in spring or "binding" in spring or "nearest" in spring:
            sheets.append(_sheet(name, spring, mapping(joint, "wanted")))
    return {"sheets": sheets} if sheets else AbsentResult("no joint's spring is to be made: all are bought")


def _sheet(name: str, spring: Json, wanted: Json) -> Json:
    make = mapping(spring, "make")
    nearest = [item for item in sequence(spring, "nearest") if isinstance(item, Mapping)]
    options: list[Json] = []
    for index, item in enumerate(nearest):
        design = mapping(item, "make")
        kind = _KINDS.get(str(item.get("kind")), str(item.get("kind")).replace("_", " "))
        drawing = drawing_of(f"{name}, {kind}: the spring", design)
        key = f"joints.{name}.spring.nearest[{index}].make"
        options.append({"kind": kind, "text": item.get("text"), "make": design, "drawing": drawing, "key": key})
    return {
        "name": name,
        "wanted": wanted.get("spring_rate"),
        "make": make,
        "groups": groups_of(make),
        "winding": winding_of(make, mirrored=len(set(map(str, sequence(spring, "hands")))) > 1),
        "notes": [*sequence(make, "violations"), *map(text_of, sequence(make, "warnings"))],
        "count": make.get("count") or 1,
        "hands": [str(hand) for hand in sequence(spring, "hands")],
        "drawing": drawing_of(f"{name}: the spring to make", make),
        "binding": sequence(spring, "binding"),
        "nearest": options,
        "compared": [
            {"label": label, "values": [text(mapping(option, "make").get(key)) for option in options]}
            for key, label, _ in (*WIND, *ACT, *LAST)
            if key in _COMPARED and any(key in option["make"] for option in options)
        ],
    }


def groups_of(make: Json) -> list[Json]:
    """The sheet's rows in three groups; quantities without a label come last, under their key."""
    if not make:
        return []
    make = {**make, **_flattened_keys(make)}
    held = ", in the joint" if is_clamped(make) else ""
    known = {key for key, _, _ in (*WIND, *ACT, *LAST)}
    others = tuple(
        (key, key.replace("_", " "), "")
        for key, value in make.items()
        if key not in known and value_of(value) is not None
    )
    groups = []
    for title, keys in (("To wind", WIND), ("Function", ACT), ("Strength", LAST), ("More", others)):
        rows = [
            {"label": label + held * (key in _AS_HELD), "key": key, "quantity": make[key], "equation": equation}
            for key, label, equation in keys
            if value_of(make.get(key)) is not None
        ]
        if title == "To wind":
            rows += _arm_rows(make)
        if rows:
            groups.append({"title": title, "rows": rows})
    return groups


def _arm_rows(make: Json) -> list[Json]:
    """The arms' lengths to their ends and, where the load acts before these, to it."""
    ends, loads = (" and ".join(text(leg) for leg in each) for each in (arms_of(make), sequence(make, "leg_lengths")))
    shown = [("straight arms", "arm_lengths", ends)]
    if loads != ends:
        shown.append(("from the coil to where the load acts", "leg_lengths", loads))
    return [{"label": label, "key": key, "text": found, "equation": ""} for label, key, found in shown if found]


def _flattened_keys(make: Json) -> Json:
    """Nested quantities, flattened to keys of one word."""
    arms, fatigue, mandrel = (mapping(make, key) for key in ("arms", "fatigue", "mandrel"))
    found = {f"arms_{key}": value for key, value in arms.items()}
    found |= {f"test_{key}": value for key, value in mapping(make, "test").items()}
    found |= {f"mandrel_{key}": value for key, value in mandrel.items()}
    return {**found, **{key: value for key, value in fatigue.items() if key != "source"}}


def drawing_of(title: str, make: Json) -> Markup | None:
    """The drawing, or None if a dimension for it is missing."""
    wire, mean, angle = (in_si(make.get(key)) for key in ("wire_diameter", "mean_diameter", "included_angle"))
    body = in_si(make.get("body_length"))
    if not wire or not mean or angle is None or not body:
        return None
    coils = value_of(make.get("body_coils"))
    legs = _legs(arms_of(make))
    arbor = in_si(make.get("arbor_diameter"))
    spring = DrawnSpring(
        wire * 1e3,
        mean * 1e3,
        coils if coils is not None else max(1.0, body / wire - 1.0),
        angle % math.tau,
        legs if legs is not None else (mean * 1e3, mean * 1e3),
        body * 1e3,
        str(make.get("leg_convention") or "tangent"),
        None if arbor is None else arbor * 1e3,
        str(make.get("hand") or "right"),
        in_si(make.get("travel")),
        not in_millimetres(make),
    )
    return spring_drawing(title, spring)


def _legs(lengths: Sequence[object]) -> tuple[float, float] | None:
    found = [length for quantity in lengths if (length := in_si(quantity)) is not None]
    return (found[0] * 1e3, found[1] * 1e3) if len(found) == 2 else None


SECTION = ReportSection("spring-sheet", "Springs to make", content)
