"""Instructions for winding a spring: cutting, winding, heat treatment and measurement, with tolerances."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from synth.reports.quantities import in_si, number, percent, text, unit_text
from synth.reports.reading import Json, unit_of, value_of
from synth.reports.section import mapping, sequence
from synth.reports.sections.warnings import text_of

_MEASURED = (
    ("wire_diameter", "wire diameter", "wire_diameter"), ("mean_diameter", "mean coil diameter", "mean_diameter"),
    ("body_coils", "coils of the body", "body_coils"), ("included_angle", "angle between the free arms", "free_angle"),
)  # fmt: skip


def winding_of(make: Json, *, mirrored: bool = False) -> Json:
    """Steps, quantities to measure with tolerances, torque against angle; empty if the design has no mandrel.

    ``mirrored``: a second spring, the mirror image of this one, is to be wound too.
    """
    mandrel, plus = mapping(make, "mandrel"), mapping(make, "tolerance")
    if not mandrel or not plus:
        return {}
    hand, arms = str(make.get("hand") or "right"), str(make.get("leg_convention") or "tangent")
    closing = closing_words(hand, arms)
    if mirrored:
        other = "left" if hand == "right" else "right"
        closing = f"Two springs, one of each hand, mirror images. {closing}. The other, {closing_words(other, arms)}"
    return {
        "steps": _steps(make, mandrel, plus, mirrored=mirrored),
        "measured": [
            {"label": label, "value": make.get(key), "plus": plus.get(tolerance)} for key, label, tolerance in _MEASURED
        ],
        "torques": _torques(make, value_of(plus.get("rate")) or 0.0),
        "test": mapping(make, "test"),
        "pins": _distances(make),
        "in_joint": make.get("rate") if is_clamped(make) else None,
        "closing": closing,
        "hand": hand,
        "rate_plus": plus.get("rate"),
    }


def closing_words(hand: str, arms: str = "tangent") -> str:
    """The direction in which the load must turn the spring, so that its coil closes."""
    sense = "clockwise" if hand == "right" else "counter-clockwise"
    does = "closes the coil and the angle between the arms"
    if arms != "tangent":
        does = "closes the coil, while the angle between the arms opens"
    return (
        f"{hand}-hand: seen from either end the coil runs away from you {sense}. Let the load turn the far arm "
        f"{sense} against the near one, which {does}"
    )


def arms_of(make: Json) -> Sequence[object]:
    """Length of each arm to its end; in results of earlier versions the load acts there."""
    return sequence(make, "arm_lengths") or sequence(make, "leg_lengths")


def _steps(make: Json, mandrel: Json, plus: Json, *, mirrored: bool) -> list[str]:
    """What to do, in order."""
    wire, hand = str(make.get("material") or "wire"), f"{make.get('hand') or 'right'}-hand"
    if mirrored:
        hand = "the one right-hand, the other left-hand,"
    length = in_si(make.get("cut_length"))
    legs, loads = (" and ".join(text(leg) for leg in each) for each in (arms_of(make), sequence(make, "leg_lengths")))
    steps = []
    if length is not None:
        spring = f"the spring itself takes {text(make.get('wire_length'))}, the rest is to hold and trim"
        cut = f"{length * 1e3:.0f} mm" if in_millimetres(make) else text(make.get("cut_length"))
        steps.append(f"Cut {cut} of {wire}, {text(make.get('wire_diameter'))}; {spring}.")
    steps.append(
        f"Wind {text(mandrel.get('turns'))} turns, {hand} and {_coils_apart(make)}, on a mandrel of "
        f"{text(mandrel.get('diameter'))}: after spring-back that leaves {text(make.get('body_coils'))} coils of "
        f"{text(make.get('inside_diameter'))} inside. Spring-back differs from wire to wire: wind a trial coil first "
        "and correct the mandrel by the coil's error."
    )
    bend = mapping(make, "arms").get("bend_radius")
    where = "" if is_clamped(make) or legs == loads else f" (the load acts {loads} from it)"
    bent = "" if bend is None else f", bent with an inside radius of {text(bend)} or more"
    steps.append(
        f"Leave the arms straight, {make.get('leg_convention') or 'tangent'}{bent}, {legs or 'as needed'} from the "
        f"coil to their ends{where}, with {text(make.get('included_angle'))} between them (within "
        f"{text(plus.get('free_angle'))})."
    )
    relief = make.get("stress_relief")
    steps.append(f"Relieve stress: {relief}." if relief else f"Relieve stress as the maker of the {wire} specifies.")
    how = f", {mapping(make, 'test').get('held')}, {_distances(make)} from the coil" if mapping(make, "test") else ""
    told = f"Measure the angle between the free arms and the torque below{how}."
    if is_clamped(make):
        told += " Wind another if one is outside its tolerance. The joint's free angle is not this angle between the"
        told += " arms: it is measured in the assembled joint, and its seat is set by it."
    else:
        told += " Set the joint's arm to the measured angle."
    steps.append(told)
    return steps


def _coils_apart(make: Json) -> str:
    """How close the coils lie, by the length of the free body: d (1 + pitch coils)."""
    wire, body, coils = (value_of(make.get(key)) for key in ("wire_diameter", "body_length", "body_coils"))
    pitch = 1.0 if wire is None or body is None or coils is None else (body / wire - 1.0) / coils
    if pitch < 1.0 + 1e-6:  # 1e-6: rounding of the result's digits
        return "touching"
    assert wire is not None
    gap = {"value": float(f"{(pitch - 1.0) * wire:.2g}"), "unit": unit_of(make.get("wire_diameter"))}
    return f"{text(gap)} between coils (pitch {number(pitch, 4)} wire diameters)"


def in_millimetres(make: Json) -> bool:
    """Whether lengths are shown in mm, not in inches."""
    return unit_of(make.get("wire_diameter")) != "in"


def is_clamped(make: Json) -> bool:
    """Whether the spring's rate is that in a joint which clamps its arms, and the test's another."""
    rate, tested = in_si(make.get("rate")), in_si(mapping(make, "test").get("rate"))
    return rate is not None and tested is not None and rate != tested


def _distances(make: Json) -> str:
    """Where the pins press, as one length where both are equal."""
    found = [text(distance) for distance in sequence(mapping(make, "test"), "distances")]
    return " and ".join(dict.fromkeys(found))


def _torques(make: Json, rate_plus: float) -> list[Json]:
    """Torque of the loose spring at quarters of the travel, with its tolerance from that of the rate; in its unit."""
    tested = mapping(make, "test").get("rate") or make.get("rate")
    rate, travel = value_of(tested), in_si(make.get("travel"))
    if rate is None or travel is None:
        return []
    unit = unit_text(unit_of(tested).removesuffix("/rad"))
    return [
        {
            "angle": f"{number(math.degrees(travel * quarter / 4), 3)}°",
            "torque": f"{number(rate * travel * quarter / 4, 4)}\u00a0{unit}",
            "plus": f"{number(rate * travel * quarter / 4 * rate_plus / 100, 2)}\u00a0{unit}",
        }
        for quarter in (1, 2, 3, 4)
    ]


def sheet_content(content: Json, drawing: Any, groups: list[Json]) -> Json:
    """What the page of one spring shows."""
    make = mapping(content, "make") or mapping(content, "checked")
    return {
        "make": make,
        "drawing": drawing,
        "groups": groups,
        "winding": winding_of(make),
        "count": make.get("count") or 1,
        "notes": [*sequence(make, "violations"), *map(text_of, sequence(make, "warnings"))],
        "checked": not mapping(content, "make"),
        "off": percent(value_of(make.get("rate")), value_of(mapping(content, "wanted").get("rate"))),
    }
