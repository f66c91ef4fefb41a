"""A wrong number stated in its tolerances, "three of your tolerances", rather than as a mechanism."""

from __future__ import annotations

from synth.diagnosis.diagnosis_result import Cause
from synth.diagnosis.plants.swinging_chain.drive_numbers import drive_words
from synth.diagnosis.plants.swinging_chain.replaced_effects import absent_words
from synth.diagnosis.plants.swinging_chain.stated_numbers import NUMBERS_CHANGED, RATES, nominal_rate
from synth.diagnosis.sentences import stated_parameters
from synth.swing.effects import effect_named
from synth.swing.leg_model import Leg
from synth.swing.tolerances import QUANTITIES, Tolerances
from synth.units import significant

# Effect -> the part, and the words for more and for less of its number.
NUMBER_WORDS = {
    "link_mass": ("link", "heavier", "lighter"),
    "spring_rate": ("spring", "stiffer", "softer"),
    "viscous_damping": ("damper", "stronger", "weaker"),
}
MOST_TOLERANCES = 12.0  # tolerances; beyond it the number was never measured, and a count of tolerances is meaningless
LEAST_TOLERANCES = 1.5  # tolerances; a smaller deviation is expected
NUMBERS = ("two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven", "twelve")


def cause_words(cause: Cause, leg: Leg, tolerances: Tolerances) -> str:
    """The knee has dry friction (torque 0.052 N·m)."""
    if cause.absent:
        return absent_words(cause, leg)
    effect = effect_named(cause.effect)
    values = drive_words(cause, leg) or stated_parameters(cause, effect)
    phrase = effect.phrase or f"shows {effect.meaning}"
    plain = f"the {cause.joint} {phrase}" + (f" ({values})" if values else "")
    return number_words(cause, plain, leg, tolerances)


def count_of_tolerances(cause: Cause, leg: Leg, tolerances: Tolerances) -> str:
    """``three of your tolerances``; empty if the cause is not a wrong number, or is far larger."""
    if cause.effect not in NUMBERS_CHANGED or cause.joint not in leg.joint_names:
        return ""
    joint = leg.joint_names.index(cause.joint)
    most = 0.0
    for parameter, quantity in NUMBERS_CHANGED[cause.effect]:
        if cause.effect == "spring_rate" and quantity == "rest":
            continue  # of a spring where there should be none: no number that was off
        width = float(tolerances.width[QUANTITIES.index(quantity), joint])
        size = nominal_rate(leg, joint, quantity) if quantity in RATES else 1.0
        if parameter in cause.parameters and width * size > 0.0:
            most = max(most, abs(cause.parameters[parameter].value) / (width * size))
    if not LEAST_TOLERANCES <= most <= MOST_TOLERANCES + 0.5:
        return ""
    return f"{NUMBERS[max(round(most), 2) - 2]} of your tolerances"


def number_words(cause: Cause, plain: str, leg: Leg, tolerances: Tolerances) -> str:
    """``the knee's link is 3.1 % heavier than designed, three of your tolerances``; ``plain`` without a nominal."""
    share = _relative_change(cause, leg)
    if share:
        part, more, less = NUMBER_WORDS[cause.effect]
        sense = more if share > 0.0 else less
        plain = f"the {cause.joint}'s {part} is {significant(abs(100.0 * share), 2)} % {sense} than designed"
    counted = count_of_tolerances(cause, leg, tolerances)
    return f"{plain}, {counted}" if counted else plain


def _relative_change(cause: Cause, leg: Leg) -> float:
    """The change of a number as a share of the design's; 0 if it is no such number, or the design has none."""
    if cause.effect not in NUMBER_WORDS or cause.joint not in leg.joint_names:
        return 0.0
    parameter, quantity = NUMBERS_CHANGED[cause.effect][0]
    nominal = nominal_rate(leg, leg.joint_names.index(cause.joint), quantity) if quantity in RATES else 1.0
    return cause.parameters[parameter].value / nominal if parameter in cause.parameters and nominal > 0.0 else 0.0
