"""Warnings on a joint's damper: an assumed law, speeds beyond its data, a falling table, travel, unstated sizes."""

from __future__ import annotations

from math import degrees

import numpy as np

from synth.design.choose_dampers import DamperOption
from synth.design.reached_speeds import ReachedSpeeds
from synth.files.project_options import DamperChoice
from synth.parts.damper_law import CONCAVE, CONCAVE_EXPONENT, TABLE
from synth.parts.part_candidates import damper_limits
from synth.parts.rows import RPM, DamperRow
from synth.remarks import Remark, decisive, noted, unlike
from synth.swing.damper_curves import thinning_error, torque_at
from synth.swing.leg_model import DamperCurve

SLOWER = "Ask the vendor whether it bears that speed, turn it slower (ratios below 1), or choose a damper sold for it."
DROPS = "Record drops with that damper alone and name them under `dampers:`."
TURN_IT_LESS = "Choose a damper that turns further, turn it less (ratios below 1), or give the joint a smaller range."
MEASURE_FASTER = "Measure the damper up to that speed, turn it slower (ratios below 1), or choose another."
MEASURE_SLOWER = (
    "Measure the damper down to a tenth of that speed or less, or name drops with it alone under `dampers:`."
)
MEASURE_AGAIN = "The torque of a rotary damper rises with speed: measure these points again."
# Of the motion's time below a table's lowest speed: from there on its law there could change a decision.
MUCH_SLOWER = 0.1
NO_TIME = 0.005  # of it: rounds to none
LITTLE = 1.1  # a tenth beyond the data: little extrapolation
MUCH_ABOVE = 0.15  # of the assumed law: a damper's own tolerance
FALLEN = 0.01  # of the highest torque: more than the rounding of its digits


def curve_warnings(joint: str, option: DamperOption, speeds: ReachedSpeeds) -> list[str]:
    """Warnings on a chosen damper: an assumed law, a thinned or falling table, speeds beyond the known ones.

    ``speeds``: of the joint as built.
    """
    warnings, reached, measured = [], speeds.fastest * option.arrangement.ratio, option.measured
    if option.row is not None and option.row.derived and option.law != "curve":
        warnings.append(f"{joint}: {option.row.order} is {option.row.status}")
    if option.law == "concave":
        text = f"{joint}: the torque-speed law of {option.part} is {option.why}: its rate at low speed may be off by a "
        warnings.append(decisive(f"{text}factor of two", DROPS))
    if measured is not None and measured.at:
        text = f"{joint}: the curve of {option.part} was measured at the {measured.at}, on another specimen of the part"
        warnings.append(noted(text))
    if measured is not None and measured.table:
        warnings += _table_warnings(joint, option.part, measured.curve, reached)
    elif measured is not None and reached > LITTLE * measured.upto:
        speed, most = unlike(reached, measured.upto, ".2g")
        warnings.append(
            f"{joint}: {option.part} is turned at up to {speed} rad/s; it was measured up to {most} rad/s, and its law "
            "is extrapolated beyond"
        )
    if option.law == TABLE and option.row is not None and option.row.default_law == TABLE:
        table = option.row.torque_speed(TABLE)
        warnings += _table_warnings(joint, option.part, table, reached)
    warnings += _slower_warnings(joint, option, speeds)
    if option.row is not None:
        warnings += _speed_warnings(joint, option.row, reached)
    if option.damper.curve is not None:
        error = thinning_error(option.damper.curve)
        if error > 0.005:  # a smaller one is far below a damper's tolerance of 15 %
            warnings.append(
                noted(f"{joint}: the damper's table was reduced to 12 points; the error is at most {error:.1%}")
            )
    return warnings


def _slower_warnings(joint: str, option: DamperOption, speeds: ReachedSpeeds) -> list[str]:
    """A warning on a table whose damper is turned more slowly than its lowest point for some of the time."""
    below, known = option.below, option.known_from
    share = 0.0 if known is None else speeds.share_below(known)
    if below is None or share < NO_TIME:
        return []
    of = "of its lowest points" if below.found else "assumed: they give no likely one"
    text = (
        f"{joint}: {option.part} is measured from {below.speed / RPM:.3g} rpm upwards, and turned more slowly for "
        f"{share:.0%} of the time. Its torque there is that of a power law, exponent {below.exponent:.2f} ({of}), and "
        "may be off by a factor of two"
    )
    return [decisive(text, MEASURE_SLOWER) if share >= MUCH_SLOWER else Remark(text, "check", MEASURE_SLOWER)]


def _table_warnings(joint: str, part: str, table: DamperCurve, reached: float) -> list[str]:
    """Warnings on a table of points whose damper is turned at ``reached`` rad/s: beyond its end, and where it falls."""
    warnings: list[str] = []
    if reached > LITTLE * table.speed[-1]:
        speed, most = unlike(reached / RPM, table.speed[-1] / RPM, ".0f")
        text = f"{joint}: {part} is turned at up to {speed} rpm; its torque-speed table ends at {most} rpm, and beyond "
        warnings.append(Remark(f"{text}it {table.beyond_words}", "check", MEASURE_FASTER))
    highest = max(table.torque)
    lowest = min(table.torque[table.torque.index(highest) :])
    if lowest < (1.0 - FALLEN) * highest:
        text = f"{joint}: the torque-speed table of {part} falls from {highest:.4g} N*m at "
        text += f"{table.speed[table.torque.index(highest)] / RPM:.4g} rpm to {lowest:.4g} N*m at "
        at = len(table.torque) - 1 - table.torque[::-1].index(lowest)
        warnings.append(Remark(f"{text}{table.speed[at] / RPM:.4g} rpm", "check", MEASURE_AGAIN))
    return warnings


def _speed_warnings(joint: str, row: DamperRow, reached: float) -> list[str]:
    """Warnings on a damper turned at ``reached`` rad/s: beyond its maximum speed, else beyond its one point."""
    turned = f"{joint}: {row.part} is turned at up to"
    if row.max_speed is not None and reached > row.max_speed:
        speed, most = unlike(reached / RPM, row.max_speed / RPM, ".0f")
        text = f"{turned} {speed} rpm; its vendor's maximum speed is {most} rpm{_above_law(row, reached)}"
        return [decisive(text, SLOWER)]
    if row.default_law != TABLE and row.speed is not None and reached > LITTLE * row.speed:
        speed, stated = unlike(reached / RPM, row.speed / RPM, ".0f")
        text = f"{turned} {speed} rpm; its vendor states torque at {stated} rpm and gives no data beyond it"
        return [text + _above_law(row, reached)]
    return []


def _above_law(row: DamperRow, reached: float) -> str:
    """How far the simulated torque at ``reached`` rad/s, straight on from the one point, is above the assumed law."""
    if row.default_law != CONCAVE or row.speed is None or row.max_torque is None or reached <= row.speed:
        return ""
    law = row.max_torque * (reached / row.speed) ** CONCAVE_EXPONENT
    above = float(torque_at(row.torque_speed(CONCAVE), np.array([reached]))[0]) / law - 1.0
    return "" if above < MUCH_ABOVE else f"; the simulated torque there is {above:.0%} above the assumed law"


def travel_warnings(joint: str, option: DamperOption, choice: DamperChoice, travel: float) -> list[str]:
    """A warning on a damper that does not turn as far as the joint's stops let it (``travel`` rad), or may not.

    Parts that are not named are chosen among those that turn between the closest stops; the built leg's motion may ask
    for wider ones.
    """
    if option.row is None:
        return []
    asks = choice.travel is not None and choice.travel >= travel
    wanted = max(choice.travel or 0.0, travel) * option.arrangement.ratio
    allowed = option.row.allows_travel(wanted)
    if allowed is None:
        text = f"{joint}: the catalogue does not state how far {option.part} turns; that it turns "
        return [f"{text}{degrees(wanted):.0f} deg was not checked"]
    if allowed:
        return []
    assert option.row.travel is not None
    most, turned = unlike(degrees(option.row.travel), degrees(wanted), ".0f")
    asked = f"travel asks for {turned} deg" if asks else f"the joint turns it by {turned} deg from stop to stop"
    text = f"{joint}: {option.part} turns by {most} deg only, and {asked}"
    return [decisive(text, TURN_IT_LESS)]


def size_warnings(joint: str, option: DamperOption, choice: DamperChoice) -> list[str]:
    """A warning for each limit of the choice on a size that the catalogue does not state for the chosen damper."""
    if option.row is None or choice.part is not None:
        return []
    return [
        f"{joint}: the catalogue does not state the {what} of {option.part}; the limit of {most * 1e3:.4g} mm was not "
        "checked"
        for what, size, most in damper_limits(option.row, choice)
        if size is None
    ]
