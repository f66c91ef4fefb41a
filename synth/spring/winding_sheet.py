"""The winding sheet of a spring and its request for quotation, as text."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from synth.files.shown_units import METRIC, ShownUnits
from synth.spring.codes import CodeCheck
from synth.spring.din_2194 import STANDARD
from synth.spring.hand_words import hand_words
from synth.spring.loose_test import HOW_HELD
from synth.spring.spring_result import SpringDesign
from synth.spring.unit_text import in_units
from synth.spring.winding import stress_relief


def winding_sheet(spring: SpringDesign, shown: ShownUnits = METRIC) -> str:
    """The winding sheet: all data to wind and check the spring."""
    sense = "clockwise" if spring.hand == "right" else "counter-clockwise"
    closing, opening = math.degrees(spring.travel), math.degrees(spring.opening_travel)
    lines = [
        "WINDING SHEET: helical torsion spring of round wire",
        "",
        f"Wire: {spring.material}, {shown.text(spring.wire_diameter, 'm')}; cut {_long(spring.cut_length, shown)}, "
        f"of which the spring takes {_long(spring.wire_length, shown)}",
        f"Coil: {spring.body_coils:.3f} coils, {spring.hand}-hand, {_coils_apart(spring, shown)}",
        f"      inside diameter {_size(spring.inside_diameter, shown)}, mean {_size(spring.mean_diameter, shown)}",
        f"      body {_size(spring.body_length, shown)} long",
        f"Legs: straight, {spring.convention}, {math.degrees(spring.included_angle):.1f} deg between them when free;",
        f"      each {shown.text(spring.arm_lengths[0], 'm')} from the coil to its end{_where_loaded(spring, shown)}",
        f"Turn: work must turn the far arm {sense} against the near one, seen from the near end: that closes the coil",
        f"Use:  winds up by at most {closing:.4g} deg" + (f", opens by at most {opening:.4g} deg" if opening else ""),
        "",
        *_workshop(spring, shown),
        "",
        *_codes(spring, shown),
        "",
        f"To check it: {test_words(spring, shown)}.",
        *_rates(spring, shown),
        *(
            f"T{number}: {shown.text(point.torque, 'N*m')} at {math.degrees(point.angle):.4g} deg, within "
            f"{shown.text(point.within, 'N*m', '.2g')}"
            for number, point in enumerate(spring.load_points, 1)
        ),
        "Torque against the angle from rest, in this test",
        f"angle [deg]  torque [{shown.unit('N*m')}]",
        *(f"{angle:<11}  {torque}" for angle, torque in _torques(spring, shown)),
        *_friction(spring, shown),
        "",
        f"Stress at full travel {_stress(spring.stress, spring.allowed_stress, shown)} allowed;",
        f"it yields at {math.degrees(spring.free_travel):.1f} deg.",
        *_in_bends(spring, shown),
        f"Strength {shown.text(spring.tensile_strength, 'Pa', '.0f')}: {spring.strength_source}",
        f"Yield {shown.text(spring.yield_stress, 'Pa', '.0f')}: {spring.yield_source}",
        *(f"NOT KEPT: {in_units(violation.text, shown)}" for violation in spring.violations),
        *(f"Note: {in_units(warning, shown)}" for warning in spring.warnings),
    ]
    return "\n".join(lines) + "\n"


def _in_bends(spring: SpringDesign, shown: ShownUnits) -> list[str]:
    if spring.bend_radius is None:
        return []
    return [f"In the bends of the arms {_stress(spring.arm_stress, spring.allowed_stress, shown)} allowed."]


@dataclass(frozen=True)
class JointTravel:
    """Travels of a spring in its joint from the free angle, rad: as it works, and to the joint's stops."""

    closing: float
    opening: float
    closing_stop: float
    opening_stop: float

    @property
    def words(self) -> str:
        """The line of a request for quotation."""
        works, stops = (
            f"{math.degrees(closed):.4g} deg closing, {math.degrees(opened):.4g} deg opening"
            for closed, opened in ((self.closing, self.opening), (self.closing_stop, self.opening_stop))
        )
        return f"Works {works}; at the joint's stops {stops}"


def request_lines(
    spring: SpringDesign, shown: ShownUnits = METRIC, joint: JointTravel | None = None, hands: Sequence[str] = ()
) -> list[str]:
    """The text of a request for quotation: dimensions, quantities to measure, tolerances.

    ``joint``: travels of a joint's spring, as drawn; ``hands``: of each of its springs, the drawn one first, default
    all of the spring's own.
    """
    own = f"{spring.hand}-hand"
    pair = len(set(hands)) > 1
    plus = spring.tolerance
    rate = spring.test.rate
    a_degree = f"{rate * 1e3 * math.radians(1.0):.4g} N*mm/deg"
    if shown.system == "inch":
        a_degree = f"{shown.value(rate, 'N*m/rad') * math.radians(1.0):.4g} in*lbf/deg"
    arms = [f"{shown.value(length, 'm'):.4g}" for length in spring.arm_lengths]
    lines = [
        "REQUEST FOR QUOTATION: helical torsion spring of round wire",
        f"Quantity: {spring.count}" + (f": {hand_words(hands)}, each the other's mirror image" if pair else ""),
        f"Wire: {spring.material}, {shown.text(spring.wire_diameter, 'm')}, within "
        f"{shown.text(plus.wire_diameter, 'm', '.3g')}",
        f"Body: {spring.body_coils:.3f} coils, {hand_words(hands) if pair else own}, {_coils_apart(spring, shown)}; "
        f"mean diameter {_size(spring.mean_diameter, shown)}, within {shown.text(plus.mean_diameter, 'm', '.2g')}",
        f"Arms: {spring.convention}, {arms[0]} and {arms[1]} {shown.unit('m')} from the coil to the "
        f"end{_where_loaded(spring, shown)}",
        f"Free angle: {math.degrees(spring.included_angle):.1f} deg, within {math.degrees(plus.free_angle):.2g} deg",
        f"Test: {test_words(spring, shown)}",
        f"Rate in this test: {shown.text(rate, 'N*m/rad')} = {a_degree}, within {plus.rate:.1%}",
        *(
            f"T{number}: {shown.text(point.torque, 'N*m')} at {math.degrees(point.angle):.4g} deg of winding, within "
            f"{shown.text(point.within, 'N*m', '.2g')}"
            for number, point in enumerate(spring.load_points, 1)
        ),
        f"Works {math.degrees(spring.travel):.4g} deg closing, {math.degrees(spring.opening_travel):.4g} deg opening"
        if joint is None
        else joint.words,
    ]
    if spring.loose is not None:
        lines.append(f"For information: {shown.text(spring.rate, 'N*m/rad')} in the joint, which clamps both arms")
    if spring.arbor_diameter is not None:
        lines.append(f"Arbor: {shown.text(spring.arbor_diameter, 'm')}; the coil must not bind on it")
    return [
        *lines,
        f"Stress relief: {stress_relief(spring.material) or 'as the wire manufacturer specifies'}",
        *_quality(spring, shown),
        "      Where a figure above is tighter, it applies.",
        f"Drawn in mm, free, seen from the near end and from the side{f': the {own} one' if pair else ''}.",
    ]


def test_words(spring: SpringDesign, shown: ShownUnits) -> str:
    """How the spring is held to measure it."""
    near, far = (shown.text(distance, "m") for distance in spring.test.distances)
    return f"{HOW_HELD}, {near if near == far else f'{near} and {far}'} from the coil"


def _where_loaded(spring: SpringDesign, shown: ShownUnits) -> str:
    """Where the load acts on the arms, which end beyond it; empty of a joint's, which clamps them to their ends."""
    if spring.arm_lengths == spring.leg_lengths:
        return ""
    return f"; the load acts {shown.text(spring.leg_lengths[0], 'm')} from the coil"


def _rates(spring: SpringDesign, shown: ShownUnits) -> list[str]:
    """The rate in the test, and for a joint's spring the one in the joint."""
    lines = [f"Rate in this test {shown.text(spring.test.rate, 'N*m/rad')}, within {spring.tolerance.rate:.1%}"]
    if spring.loose is not None:
        lines.append(f"Rate in the joint {shown.text(spring.rate, 'N*m/rad')}: it clamps both arms. Not to be tested.")
    return lines


def _friction(spring: SpringDesign, shown: ShownUnits) -> list[str]:
    """How far friction between the coils may change the rate; wound samples had it."""
    if spring.rate_factor != 1.0:
        return [f"The rates are {spring.rate_factor:.3f} times the formula's, as measured on wound samples."]
    in_test = spring.test.rate / spring.rate
    return [
        "Friction between the coils may make the rate softer: "
        f"{shown.text(in_test * spring.rate_friction_form, 'N*m/rad')} instead of",
        f"{shown.text(in_test * spring.rate_bending_form, 'N*m/rad')}.",
    ]


def _coils_apart(spring: SpringDesign, shown: ShownUnits) -> str:
    """How close the free coils lie: the body's length holds the gaps between them."""
    if spring.pitch == 1.0:
        return "touching"
    gap = (spring.pitch - 1.0) * spring.wire_diameter
    return f"pitch {spring.pitch:.4g} x wire, coils {shown.text(gap, 'm', '.2g')} apart"


def _size(length: float, shown: ShownUnits) -> str:
    """A length with the resolution of a calliper."""
    return shown.text(length, "m", ".4f" if shown.system == "inch" else ".2f")


def _long(length: float, shown: ShownUnits) -> str:
    return shown.text(length, "m", ".1f" if shown.system == "inch" else ".0f")


def _codes(spring: SpringDesign, shown: ShownUnits) -> list[str]:
    """Stress by each code, stress at the opening travel, fatigue life and natural frequency of the coils."""
    lines = [f"By {code_line(check, shown)}" for check in spring.codes]
    if spring.opening_travel > 0.0:
        opened = _stress(spring.opening_stress, spring.allowed_opening_stress, shown)
        lines.append(f"Opening: {opened}; less than for closing, because residual winding stresses add to the load")
    span = shown.text(spring.stress_range_en, "Pa", ".0f")
    lines.append(f"Stress range of EN 13906-3 over the whole travel: {span}")
    if spring.life is not None:
        one, ten = spring.life.factor_1e5, spring.life.factor_1e6
        lines.append(f"Strength over stress (Gerber): {one:.2f} for 100 000 full turns, {ten:.2f} for a million")
    lines.append(f"Natural frequency of the coils {spring.surge_frequency:.0f} Hz: keep the drive well below it")
    return [*lines, *_grades(spring, shown)]


def _quality(spring: SpringDesign, shown: ShownUnits) -> list[str]:
    """The quality grade to order, with its tolerances."""
    chosen = spring.grade
    if chosen is None:
        return [f"Quality: as agreed; the spring is outside the scope of {STANDARD}"]
    legs = " and ".join(f"{shown.value(length, 'm'):.2g}" for length in chosen.leg_lengths)
    angle, torque = math.degrees(chosen.free_angle), shown.text(chosen.torque, "N*m", ".2g")
    diameter = shown.text(chosen.mean_diameter, "m", ".2g")
    return [
        f"Quality: {STANDARD}, grade {chosen.grade}: free angle within {angle:.2g} deg, torque within {torque},",
        f"      mean diameter within {diameter}, legs within {legs} {shown.unit('m')}",
    ]


def _grades(spring: SpringDesign, shown: ShownUnits) -> list[str]:
    """The quality grade to order, and the others beside it."""
    others = [
        f"grade {each.grade}: {math.degrees(each.free_angle):.2g} deg, {shown.text(each.torque, 'N*m', '.2g')}"
        for each in spring.grades
        if each != spring.grade
    ]
    return [*_quality(spring, shown), *([f"      ({'; '.join(others)})"] if others else [])]


def _torques(spring: SpringDesign, shown: ShownUnits) -> list[list[str]]:
    angles = [spring.travel * part / 4.0 for part in range(1, 5)]
    return [[f"{math.degrees(angle):.4g}", f"{shown.value(spring.test.rate * angle, 'N*m'):.4g}"] for angle in angles]


def _workshop(spring: SpringDesign, shown: ShownUnits) -> list[str]:
    """Mandrel, heat and tolerances."""
    plus, angle = spring.tolerance, math.degrees(spring.tolerance.free_angle)
    return [
        f"Mandrel: begin with {_size(spring.mandrel_diameter, shown)} and {spring.mandrel_turns:.2f} turns. Wires",
        "differ in spring-back: wind a trial coil, measure its inside diameter when free and correct the mandrel by",
        "the error.",
        f"Heat: {stress_relief(spring.material) or 'relieve stress as the wire manufacturer specifies'}.",
        "",
        f"Tolerances: wire {shown.text(plus.wire_diameter, 'm', '.3g')}, mean diameter "
        f"{shown.text(plus.mean_diameter, 'm', '.2g')}, free angle {angle:.2g} deg, plus or minus; the rate",
        f"then is within {plus.rate:.1%}. It changes by 1 % for each 1 % of the mean diameter or of the coils, and by",
        "4 % for each 1 % of the wire's diameter: measure the wire.",
    ]


def code_line(check: CodeCheck, shown: ShownUnits) -> str:
    """The stress by one code and its allowable stress."""
    return f"{check.code}: {_stress(check.stress, check.allowed, shown)} allowed, safety {check.safety:.2f}"


def _stress(stress: float, allowed: float, shown: ShownUnits) -> str:
    return f"{shown.text(stress, 'Pa', '.0f')} of {shown.text(allowed, 'Pa', '.0f')}"
