"""A torsion spring as text: the answer in one line, its table, notes."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from synth.commands.table_text import table_text
from synth.files.shown_units import METRIC, ShownUnits
from synth.parts.row_check import DISAGREEMENT
from synth.spring.calibration import WindingCalibration
from synth.spring.design import SpringResult
from synth.spring.spring_result import DESIGN_LIFE, SpringDesign
from synth.spring.unit_text import in_units
from synth.spring.winding_sheet import code_line


@dataclass(frozen=True)
class Row:
    """A line of the table: heading, and the value in SI with its unit ``si``, or text without a unit."""

    head: str
    value: Callable[[SpringDesign], float | str]
    si: str | None = None
    digits: str = ".4g"
    inch_digits: str = ".4g"

    def label(self, shown: ShownUnits) -> str:
        """The heading with the displayed unit."""
        return self.head if self.si is None else f"{self.head} [{shown.unit(self.si)}]"

    def cell(self, spring: SpringDesign, shown: ShownUnits) -> str:
        """The value in the displayed unit."""
        value = self.value(spring)
        if isinstance(value, str) or self.si is None:
            return value if isinstance(value, str) else f"{value:{self.digits}}"
        return f"{shown.value(value, self.si):{self.inch_digits if shown.system == 'inch' else self.digits}}"


def _life(spring: SpringDesign, which: str) -> str:
    return "-" if spring.life is None else f"{getattr(spring.life, which):.2f}"


PARALLEL = "springs in parallel"  # a row of several
CALIBRATED = "rate over the formula's, samples"  # a row of springs with a calibration alone
BENDS = "stress in the arms' bends"
ROWS: tuple[Row, ...] = (
    Row("material", lambda s: s.material),
    Row(PARALLEL, lambda s: f"{s.count}"),
    Row("wire diameter", lambda s: s.wire_diameter, "m"),
    Row("mean coil diameter", lambda s: s.mean_diameter, "m", ".2f", ".4f"),
    Row("outer diameter, free", lambda s: s.outer_diameter, "m", ".2f", ".4f"),
    Row("outer diameter, widest", lambda s: s.widest_outer_diameter, "m", ".2f", ".4f"),
    Row("inside diameter, free", lambda s: s.inside_diameter, "m", ".2f", ".4f"),
    Row("inside diameter, at travel", lambda s: s.wound_inside_diameter, "m", ".2f", ".4f"),
    Row("body coils", lambda s: f"{s.body_coils:.3f}"),
    Row("active coils, legs included", lambda s: f"{s.active_coils:.3f}"),
    Row("included angle", lambda s: s.included_angle, "rad", ".1f", ".1f"),
    Row("each leg, to its load", lambda s: s.leg_lengths[0], "m"),
    Row("body length, free", lambda s: s.body_length, "m", ".2f", ".4f"),
    Row("body length, at travel", lambda s: s.wound_body_length, "m", ".2f", ".4f"),
    Row("spring index D/d", lambda s: f"{s.index:.2f}"),
    Row("rate", lambda s: s.rate, "N*m/rad"),
    Row("rate, d^4 E/(64 D N)", lambda s: s.rate_bending_form, "N*m/rad"),
    Row("rate, 10.8 per turn", lambda s: s.rate_friction_form, "N*m/rad"),
    Row(CALIBRATED, lambda s: f"{s.rate_factor:.3f}"),
    Row("travel", lambda s: s.travel, "rad"),
    Row("torque at travel", lambda s: s.moment, "N*m"),
    Row("stress at travel", lambda s: s.stress, "Pa", ".0f", ".1f"),
    Row("allowed stress", lambda s: s.allowed_stress, "Pa", ".0f", ".1f"),
    Row("strength over stress, 1e5 cycles", lambda s: _life(s, "factor_1e5")),
    Row("strength over stress, 1e6 cycles", lambda s: _life(s, "factor_1e6")),
    Row("torque, opening", lambda s: s.opening_moment, "N*m"),
    Row("stress, opening", lambda s: s.opening_stress, "Pa", ".0f", ".1f"),
    Row("allowed stress, opening", lambda s: s.allowed_opening_stress, "Pa", ".0f", ".1f"),
    Row(BENDS, lambda s: s.arm_stress, "Pa", ".0f", ".1f"),
    Row("least yield over stress", lambda s: f"{s.safety:.2f}"),
    Row("surge frequency [Hz]", lambda s: f"{s.surge_frequency:.0f}"),
    Row("travel to yield", lambda s: s.free_travel, "rad", ".1f", ".1f"),
    Row("rate tolerance [%]", lambda s: f"{s.tolerance.rate * 100:.1f}"),
    Row("first mandrel to try", lambda s: s.mandrel_diameter, "m", ".2f", ".4f"),
    Row("wire length", lambda s: s.wire_length, "m", ".0f", ".1f"),
    Row("mass", lambda s: s.mass, "kg", ".1f", ".3f"),
)


def spring_table(springs: Sequence[SpringDesign], heads: Sequence[str], shown: ShownUnits) -> str:
    """Springs side by side, one property per line; a count of one everywhere is left out."""
    several = any(spring.count > 1 for spring in springs)
    bent = any(spring.bend_radius is not None for spring in springs)
    calibrated = any(spring.rate_factor != 1.0 for spring in springs)
    idle = {head for head, used in ((PARALLEL, several), (BENDS, bent), (CALIBRATED, calibrated)) if not used}
    kept = [row for row in ROWS if row.head not in idle]
    rows = [[row.label(shown), *(row.cell(spring, shown) for spring in springs)] for row in kept]
    return table_text([["", *heads], *rows])


def in_one_line(spring: SpringDesign, shown: ShownUnits) -> str:
    """The spring in words: dimensions, rate, stress, and how it lasts."""
    count = f"{spring.count} springs, each " if spring.count > 1 else ""
    wire, mean = shown.text(spring.wire_diameter, "m"), shown.text(spring.mean_diameter, "m")
    return (
        f"{count}{spring.body_coils:.4g} coils of {wire} {spring.material}, mean diameter {mean}: "
        f"{shown.text(spring.rate, 'N*m/rad')} over {math.degrees(spring.travel):.4g} deg, "
        f"at {spring.use:.0%} of the allowed stress{_how_it_lasts(spring)}"
    )


def _how_it_lasts(spring: SpringDesign) -> str:
    """What the allowed stress, a limit against yield, does not tell: strength against fatigue. Empty if unknown."""
    if spring.life is None:
        return ""
    each = f"{_life(spring, 'factor_1e5')} for 1e5 full turns, {_life(spring, 'factor_1e6')} for 1e6"
    return f", and against fatigue strength over stress {each}"


def design_text(result: SpringResult, shown: ShownUnits = METRIC) -> str:
    """The answer in one line; then the spring and the next best wires, or the nearest that can be made."""
    if result.best is not None:
        heads = ["to wind", *(f"or {i + 1}" for i in range(len(result.alternatives)))]
        notes = [code_line(check, shown) for check in result.best.codes]
        notes += [f"note: {in_units(text, shown)}" for text in (*result.notes, *result.best.warnings)]
        if result.lasting:
            texts = [in_units(item.text, shown) for item in result.lasting]
            notes += [f"To last {DESIGN_LIFE:.0f} full turns:", *(f"  - {text}" for text in texts)]
        table = spring_table([result.best, *result.alternatives], heads, shown)
        return "\n".join([f"Wind {in_one_line(result.best, shown)}.", "", table, *notes])
    wish = result.wish
    asked = f"{shown.text(wish.rate, 'N*m/rad')} over {math.degrees(wish.travel):.4g} deg"
    lines = [f"No single spring of {wish.material} gives {asked} within the limits.", "Limits not met:"]
    lines += [f"  - {in_units(text, shown)}" for text in result.binding]
    if not result.nearest:
        return "\n".join([*lines, "No similar spring can be made either: widen the limits."])
    texts = [in_units(item.text, shown) for item in result.nearest]
    lines += ["The nearest that can be made:", *(f"  - {text}" for text in texts), ""]
    heads = [item.kind.replace("_", " ") for item in result.nearest]
    return "\n".join([*lines, spring_table([item.design for item in result.nearest], heads, shown)])


def calibration_text(found: WindingCalibration) -> str:
    """The calibration in words."""
    spread = "" if found.spread is None else f", plus or minus {found.spread:.1%} from sample to sample"
    rate = (
        f"rate {found.rate:.3f} times the formula's ({_samples(found.n_rate)}{spread}); sets wire, coils and diameter"
    )
    lines = [
        f"{found.material}: yield stress {found.spring_back:.3f} times the minimum strength "
        f"({_samples(found.n_back)}); sets the mandrel",
        rate if found.n_rate else "rate: no sample has one, so that of the formula stays",
        "Use it in the next design with --calibration.",
    ]
    if abs(found.rate - 1.0) > DISAGREEMENT:
        lines.append("note: the rate is far from the formula's: measure the wire and count the coils again")
    return "\n".join(lines)


def _samples(number: int) -> str:
    return "1 sample" if number == 1 else f"{number} samples"


def check_text(spring: SpringDesign, shown: ShownUnits = METRIC) -> str:
    """The answer in one line, the spring, and the limits it breaks."""
    notes = [f"note: {in_units(warning, shown)}" for warning in spring.warnings]
    apart = spring.rate / spring.calculated_rate - 1.0
    if abs(apart) > DISAGREEMENT:
        text = (
            f"the given rate differs by {apart:+.0%} from the rate of these sizes: measure the wire and count the coils"
        )
        notes.insert(0, f"note: {text}")
    if spring.feasible:
        answer, broken = "It meets all limits", []
    else:
        number = len(spring.violations)
        answer = f"It breaks {number} limit{'' if number == 1 else 's'}"
        broken = ["Limits not met:", *(f"  - {in_units(each.text, shown)}" for each in spring.violations)]
    line = f"{answer}: {in_one_line(spring, shown)}."
    return "\n".join([line, "", spring_table([spring], ["checked"], shown), *broken, *notes])
