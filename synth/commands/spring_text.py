"""A torsion spring in words: the table on the screen and the sheet for the one who winds it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from synth.commands.table_text import table_text
from synth.parts.row_check import DISAGREEMENT
from synth.spring.calibration import WindingCalibration
from synth.spring.codes import CodeCheck
from synth.spring.design import SpringResult
from synth.spring.spring_result import DESIGN_LIFE, GRADE, SpringDesign
from synth.spring.winding import stress_relief

Row = tuple[str, Callable[[SpringDesign], str]]

ROWS: tuple[Row, ...] = (
    ("material", lambda s: s.material),
    ("springs side by side", lambda s: f"{s.count}"),
    ("wire diameter [mm]", lambda s: f"{s.wire_diameter * 1e3:.4g}"),
    ("mean coil diameter [mm]", lambda s: f"{s.mean_diameter * 1e3:.2f}"),
    ("outer diameter [mm]", lambda s: f"{s.outer_diameter * 1e3:.2f}"),
    ("inside diameter, free [mm]", lambda s: f"{s.inside_diameter * 1e3:.2f}"),
    ("inside diameter, at travel [mm]", lambda s: f"{s.wound_inside_diameter * 1e3:.2f}"),
    ("body coils", lambda s: f"{s.body_coils:.3f}"),
    ("active coils, with the legs", lambda s: f"{s.active_coils:.3f}"),
    ("included angle [deg]", lambda s: f"{math.degrees(s.included_angle):.1f}"),
    ("each leg, to its load [mm]", lambda s: f"{s.leg_lengths[0] * 1e3:.4g}"),
    ("body length, free [mm]", lambda s: f"{s.body_length * 1e3:.2f}"),
    ("body length, at travel [mm]", lambda s: f"{s.wound_body_length * 1e3:.2f}"),
    ("spring index D/d", lambda s: f"{s.index:.2f}"),
    ("rate [N*m/rad]", lambda s: f"{s.rate:.4g}"),
    ("rate, d^4 E/(64 D N) [N*m/rad]", lambda s: f"{s.rate_bending_form:.4g}"),
    ("rate, 10.8 per turn [N*m/rad]", lambda s: f"{s.rate_friction_form:.4g}"),
    ("travel [deg]", lambda s: f"{math.degrees(s.travel):.4g}"),
    ("torque at travel [N*m]", lambda s: f"{s.moment:.4g}"),
    ("stress at travel [MPa]", lambda s: f"{s.stress / 1e6:.0f}"),
    ("allowed stress [MPa]", lambda s: f"{s.allowed_stress / 1e6:.0f}"),
    ("strength over stress, 1e5 cycles", lambda s: "-" if s.life is None else f"{s.life.factor_1e5:.2f}"),
    ("strength over stress, 1e6 cycles", lambda s: "-" if s.life is None else f"{s.life.factor_1e6:.2f}"),
    ("stress, opening [MPa]", lambda s: f"{s.opening_stress / 1e6:.0f} of {s.allowed_opening_stress / 1e6:.0f}"),
    ("coils' own frequency [Hz]", lambda s: f"{s.surge_frequency:.0f}"),
    ("travel to yield [deg]", lambda s: f"{math.degrees(s.free_travel):.1f}"),
    ("rate within [%]", lambda s: f"{s.tolerance.rate * 100:.1f}"),
    ("mandrel to begin with [mm]", lambda s: f"{s.mandrel_diameter * 1e3:.2f}"),
    ("wire length [mm]", lambda s: f"{s.wire_length * 1e3:.0f}"),
    ("mass [g]", lambda s: f"{s.mass * 1e3:.1f}"),
)


def spring_table(springs: Sequence[SpringDesign], heads: Sequence[str]) -> str:
    """Springs beside each other, a property a line; one count a column is not shown."""
    several = any(spring.count > 1 for spring in springs)
    rows = [[label, *(show(spring) for spring in springs)] for label, show in ROWS if several or "side by" not in label]
    return table_text([["", *heads], *rows])


def design_text(result: SpringResult) -> str:
    """The spring to wind and the next best wires, or what stands in the way and the nearest that can be made."""
    if result.best is not None:
        heads = ["to wind", *(f"or {i + 1}" for i in range(len(result.alternatives)))]
        notes = [_code_line(check) for check in result.best.codes]
        notes += [f"note: {text}" for text in (*result.notes, *result.best.warnings)]
        if result.lasting:
            notes += [f"To last {DESIGN_LIFE:.0f} full turns:", *(f"  - {item.text}" for item in result.lasting)]
        return "\n".join([spring_table([result.best, *result.alternatives], heads), *notes])
    wish = result.wish
    asked = f"{wish.rate:.4g} N*m/rad over {math.degrees(wish.travel):.4g} deg"
    lines = [f"No single spring of {wish.material} gives {asked} within the limits.", "In the way:"]
    lines += [f"  - {text}" for text in result.binding]
    if not result.nearest:
        return "\n".join([*lines, "Nothing near it can be made either: widen the limits."])
    lines += ["The nearest that can be made:", *(f"  - {item.text}" for item in result.nearest), ""]
    heads = [item.kind.replace("_", " ") for item in result.nearest]
    return "\n".join([*lines, spring_table([item.design for item in result.nearest], heads)])


def _code_line(check: CodeCheck) -> str:
    return (
        f"{check.code}: {check.stress / 1e6:.0f} MPa of {check.allowed / 1e6:.0f} MPa allowed, "
        f"safety {check.safety:.2f}"
    )


def calibration_text(found: WindingCalibration, material: str) -> str:
    """What wound samples say, in words."""
    spread = "" if found.spread is None else f", plus or minus {found.spread:.1%} from sample to sample"
    back, rate = f"{found.spring_back:.3f}", f"{found.rate:.3f}"
    return "\n".join(
        [
            f"{material}: it flows at {back} times its least tensile strength ({found.n_back} samples): the mandrel",
            f"rate: {rate} times the formula's ({found.n_rate} samples{spread}): wire, coils and diameter",
            "Give it to the next design with --calibration.",
        ]
    )


def check_text(spring: SpringDesign) -> str:
    """A given spring and the limits that it does not keep."""
    notes = [f"note: {warning}" for warning in spring.warnings]
    apart = spring.rate / spring.rate_bending_form - 1.0
    if abs(apart) > DISAGREEMENT:
        text = f"the rate given is {apart:+.0%} from that of these sizes: measure the wire and count the coils"
        notes.insert(0, f"note: {text}")
    if spring.feasible:
        verdict = ["It keeps all limits."]
    else:
        verdict = ["It does not keep:", *(f"  - {violation.text}" for violation in spring.violations)]
    return "\n".join([spring_table([spring], ["checked"]), *verdict, *notes])


def winding_sheet(spring: SpringDesign) -> str:
    """What the one who winds the spring needs, as text."""
    sense = "clockwise" if spring.hand == "right" else "counter-clockwise"
    closing, opening = math.degrees(spring.travel), math.degrees(spring.opening_travel)
    lines = [
        "WINDING SHEET: helical torsion spring of round wire",
        "",
        f"Wire: {spring.material}, {spring.wire_diameter * 1e3:.4g} mm; cut {spring.wire_length * 1e3:.0f} mm or more",
        f"Coil: {spring.body_coils:.3f} coils, {spring.hand}-hand, touching",
        f"      inside diameter {spring.inside_diameter * 1e3:.2f} mm, mean {spring.mean_diameter * 1e3:.2f} mm",
        f"      body {spring.body_length * 1e3:.2f} mm long",
        f"Legs: straight, {spring.convention}, {math.degrees(spring.included_angle):.1f} deg between them when free;",
        f"      each {spring.leg_lengths[0] * 1e3:.4g} mm from the coil to where the load acts",
        f"Turn: work must turn the far arm {sense} against the near one, seen from the near end: that closes the coil",
        f"Use:  winds up by at most {closing:.4g} deg" + (f", opens by at most {opening:.4g} deg" if opening else ""),
        "",
        *_workshop(spring),
        "",
        *_codes(spring),
        "",
        *(
            f"T{number}: {point.torque:.4g} N*m at {math.degrees(point.angle):.4g} deg, within {point.within:.2g} N*m"
            for number, point in enumerate(spring.load_points, 1)
        ),
        "To check it: torque at the leg against the angle from rest",
        table_text([["angle [deg]", "torque [N*m]"], *_torques(spring)]),
        f"Where the coils rub on each other it may come out softer, {spring.rate_friction_form:.4g} N*m/rad instead of",
        f"{spring.rate_bending_form:.4g} N*m/rad.",
        "",
        f"Stress at full travel {spring.stress / 1e6:.0f} MPa of {spring.allowed_stress / 1e6:.0f} MPa allowed;",
        f"it yields at {math.degrees(spring.free_travel):.1f} deg.",
        f"Strength {spring.tensile_strength / 1e6:.0f} MPa: {spring.strength_source}",
        f"Yield {spring.yield_stress / 1e6:.0f} MPa: {spring.yield_source}",
        *(f"NOT KEPT: {violation.text}" for violation in spring.violations),
        *(f"Note: {warning}" for warning in spring.warnings),
    ]
    return "\n".join(lines) + "\n"


def request_lines(spring: SpringDesign) -> list[str]:
    """The words of a request for quotation: what to make, what to measure, and how far it may be off."""
    plus = spring.tolerance
    lines = [
        "REQUEST FOR QUOTATION: helical torsion spring of round wire",
        f"Quantity: {spring.count}",
        f"Wire: {spring.material}, {spring.wire_diameter * 1e3:.4g} mm, within {plus.wire_diameter * 1e3:.3g} mm",
        f"Body: {spring.body_coils:.3f} coils, {spring.hand}-hand, touching; mean diameter "
        f"{spring.mean_diameter * 1e3:.2f} mm, within {plus.mean_diameter * 1e3:.2g} mm",
        f"Arms: {spring.convention}, {spring.leg_lengths[0] * 1e3:.4g} and {spring.leg_lengths[1] * 1e3:.4g} mm",
        f"Free angle: {math.degrees(spring.included_angle):.1f} deg, within {math.degrees(plus.free_angle):.2g} deg",
        f"Rate: {spring.rate:.4g} N*m/rad = {spring.rate * 1e3 * math.radians(1.0):.4g} N*mm/deg, "
        f"within {plus.rate:.1%}",
        *(
            f"T{number}: {point.torque:.4g} N*m at {math.degrees(point.angle):.4g} deg of winding, within "
            f"{point.within:.2g} N*m"
            for number, point in enumerate(spring.load_points, 1)
        ),
        f"Works {math.degrees(spring.travel):.4g} deg closing, {math.degrees(spring.opening_travel):.4g} deg opening",
    ]
    if spring.arbor_diameter is not None:
        lines.append(f"Over an arbor of {spring.arbor_diameter * 1e3:.4g} mm, which it must not grip")
    return [
        *lines,
        f"Stress relief: {stress_relief(spring.material) or 'as the maker of the wire says'}",
        f"Quality: {GRADE['standard']}, grade {GRADE['torque']}, where the figures above do not say more",
        "Sizes in mm. Drawn free, seen from the near end and from the side.",
    ]


def _codes(spring: SpringDesign) -> list[str]:
    """The spring by each code, its stress where it opens, how it lasts and how fast its coils swing."""
    lines = [f"By {_code_line(check)}" for check in spring.codes]
    if spring.opening_travel > 0.0:
        opened, less = spring.opening_stress / 1e6, spring.allowed_opening_stress / 1e6
        lines.append(f"Opening: {opened:.0f} MPa of {less:.0f} MPa, less since winding's own stresses then hurt")
    lines.append(f"Stress range of EN 13906-3 over the whole travel: {spring.stress_range_en / 1e6:.0f} MPa")
    if spring.life is not None:
        one, ten = spring.life.factor_1e5, spring.life.factor_1e6
        lines.append(f"Strength over stress (Gerber): {one:.2f} for 100 000 full turns, {ten:.2f} for a million")
    lines.append(f"Coils swing by themselves at {spring.surge_frequency:.0f} Hz: keep the drive well below")
    lines.append(f"Quality: DIN 2194, grade {GRADE['torque']} for torque, legs, free angle and diameter")
    return lines


def _torques(spring: SpringDesign) -> list[list[str]]:
    angles = [spring.travel * part / 4.0 for part in range(1, 5)]
    return [[f"{math.degrees(angle):.4g}", f"{spring.rate * angle:.4g}"] for angle in angles]


def _workshop(spring: SpringDesign) -> list[str]:
    """Mandrel, heat and tolerances."""
    plus, angle = spring.tolerance, math.degrees(spring.tolerance.free_angle)
    return [
        f"Mandrel: begin with {spring.mandrel_diameter * 1e3:.2f} mm and {spring.mandrel_turns:.2f} turns. Wires",
        "differ in spring-back: wind a trial coil, measure its inside diameter when free and change the mandrel by as",
        "much as it is off.",
        f"Heat: {stress_relief(spring.material) or 'relieve stress as the maker of the wire says'}.",
        "",
        f"Within: wire {plus.wire_diameter * 1e3:.3g} mm, mean diameter {plus.mean_diameter * 1e3:.2g} mm, free angle "
        f"{angle:.2g} deg, plus or minus; the rate",
        f"then is within {plus.rate:.1%}. It changes by 1 % for each 1 % of the mean diameter or of the coils, and by",
        "4 % for each 1 % of the wire's diameter: measure the wire.",
    ]
