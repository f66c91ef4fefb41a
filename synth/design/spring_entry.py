"""The chosen spring of a joint as its entry ``spring`` in ``design.json``."""

from __future__ import annotations

from typing import Any

from synth.design.choose_springs import SpringOption
from synth.design.spring_hands import hands_of, is_pair
from synth.design.wound_warnings import nearest_as_made
from synth.parts.rows import TorsionSpringRow
from synth.units import quantity


def spring_entry(option: SpringOption) -> dict[str, Any]:
    """The entry without the free angle."""
    hands = list(hands_of(option))
    if option.row is not None:
        return {**_bought(option, option.row), "hands": hands}
    assert option.design is not None
    wanted = quantity(option.asked, "N*m/rad")
    written: dict[str, Any] = {"make": option.design.as_json(), "hands": hands, "wanted_rate": wanted}
    if option.result is not None:
        written["binding"] = list(option.result.binding)
        written["nearest"] = [item.as_json() for item in nearest_as_made(option.result, option.design)]
        written["lasting"] = [item.as_json() for item in option.result.lasting]
        written["notes"] = list(option.result.notes)
    return written


def _bought(option: SpringOption, row: TorsionSpringRow) -> dict[str, Any]:
    written: dict[str, Any] = {
        "part": row.part,
        "vendor": row.vendor,
        "count": option.count,
        "rate": quantity(option.rate, "N*m/rad"),
        "rate_as_sold": quantity(option.as_sold, "N*m/rad"),
        "wanted_rate": quantity(option.asked, "N*m/rad"),
        "included_angle": quantity(option.included_angle, "deg"),
        "material": row.material,
        "hand": row.hand or None,
        "source": row.source,
    }
    if is_pair(option):
        written["other_hand"] = None if option.mirror is None else option.mirror.part
    if row.derived:
        written["derived"] = list(row.derived)
    if row.derived or row.measure:
        written["measure_before_printing"] = list(row.measure)
    for name, value, unit in (
        ("wire_diameter", row.wire_diameter, "mm"),
        ("outer_diameter", row.outer_diameter, "mm"),
        ("body_coils", row.body_coils, "1"),
        ("body_length", row.body_length, "mm"),
        ("leg_length", row.leg_length, "mm"),
    ):
        if value is not None:
            written[name] = quantity(value, unit)
    if option.loose is not None:
        written["test"] = option.loose.as_json()
    if option.check is not None:
        written["free_travel"] = quantity(option.check.free_travel, "deg")
        written["travel"] = quantity(option.check.travel, "deg")
        written["rate_bending_form"] = quantity(option.check.rate_bending_form, "N*m/rad")
    return written
