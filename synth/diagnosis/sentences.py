"""The diagnosis in a sentence; the plant-specific words are given."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from synth.diagnosis.diagnosis_result import Cause, Verdict
from synth.diagnosis.prediction_error import AT_NOISE
from synth.diagnosis.remainder import Remainder
from synth.estimation.intervals import Estimate
from synth.estimation.parameters import Parameter, PlantEffect
from synth.units import significant

LEAST_MENTIONED = 0.5  # noise floors; a smaller remainder is a form error and is not mentioned
MOST_PARAMETERS = 3  # parameters of a cause; the table has all
MOST_LEADING, LEAST_LEADING_SHARE = 3, 0.05  # causes named if nothing explains the gap, and least share of each
LEAST_SHOWN_SHARE = 0.005  # of the gap; less rounds to 0 %
ROUGH_INTERVAL = 0.1  # of a value, half its interval: its third digit then says nothing
MOST_OF_GAP = 0.5  # of the gap: what takes more takes most of it, though it may be too unsure to be named
# Probability that no effect is missing from which the trials show that; below, they cannot show whether. The one from
# which the page calls a cause identified.
SURE_OF_NONE = 0.8
FIRST_TO_SHOW = "in this one the most probable causes would show first"
RELATIVE_CHANGE = "relative change"
IN_PERCENT = ("share", RELATIVE_CHANGE)  # forms of a parameter without unit, see ``Parameter``
TYPOGRAPHIC_UNITS = {"*": "·", "deg": "°", "percent": "%"}  # typographic units


@dataclass(frozen=True)
class ErrorWording:
    """The words of the sentence for the errors.

    ``nominal`` : the compared model, "the nominal leg"; ``error`` : "the error"; ``on`` : the
    trials, see ``scored_on``; ``falls_from`` : the error that a cause reduces, "2.1°". ``takes`` : share of the
    gap that the explanation removes there; ``left`` : the remainder; ``accuracy`` rad, below which a gap does
    not matter, 0 if not given; ``leading`` : single causes in a few words, with the share that each removes;
    ``nearest`` : the explanation that comes nearest, in a few words. ``common`` : the causes that all tied explanations
    contain, in words; ``each`` : the errors with each tied explanation but the accepted one. ``moved`` : the error of
    the explanation where it follows held-out trials within its uncertainty, if only that keeps them from contradicting
    it; ``parted`` : the errors of these trials and of the others, if there are both. ``none`` : probability that no
    effect is missing. ``takes_fitted`` : the share that the explanation removes from the trials that it is fitted to;
    ``asked`` the one in the odds of an unknown cause. ``further`` : what takes the remainder, if anything does;
    ``tried`` : whether further causes were tried at all. ``released`` : each trial is a release; phases of
    others say nothing.
    """

    nominal: str
    error: str
    on: str
    falls_from: str
    before: Estimate
    after: Estimate
    floor: Estimate
    takes: float = 0.0
    takes_fitted: float = 0.0
    asked: float = 0.0
    left: Remainder | None = None
    accuracy: float = 0.0
    leading: Sequence[tuple[str, float]] = ()
    nearest: str = ""
    common: Sequence[str] = ()
    each: Sequence[Estimate] = ()
    moved: Estimate | None = None
    parted: PartedErrors | None = None
    none: float = 1.0
    further: FurtherCauseWords | None = None
    tried: bool = True
    released: bool = True

    @property
    def shows_no_share(self) -> bool:
        """Whether the error within tolerances is at the noise already: then it falls by nothing, whatever is missing.

        The tolerances alone follow the angle; that they would have to, or another channel, shows a cause.
        """
        return self.takes < LEAST_SHOWN_SHARE and self.before.value <= AT_NOISE * self.floor.value


@dataclass(frozen=True)
class FurtherCauseWords:
    """Causes beside the explanation, in words, that are not named; the ``named`` ones as they are beside these.

    ``left`` : RMS that they leave together, above the noise. ``little`` : what these take is too little of the gap.
    """

    further: Sequence[str]
    named: Sequence[str]
    left: Estimate
    little: bool


@dataclass(frozen=True)
class PartedErrors:
    """Errors (before, after) of the scored trials that the explanation predicts as it is, and of those that it follows
    only where moved within its uncertainty; the number of each; ``takes`` : share of the gap removed on the first.
    """

    as_is: tuple[Estimate, Estimate]
    if_moved: tuple[Estimate, Estimate]
    counts: tuple[int, int]
    takes: float


def scored_on(trials: str, *, held_out: bool) -> str:
    """Unseen releases, if ``trials`` are releases."""
    return f"unseen {trials}" if held_out else "each trial, predicted by the others,"


def angle_text(value: Estimate) -> str:
    """An angle in degrees to two digits."""
    return f"{significant(math.degrees(value.value), 2)}°"


def stated_parameters(cause: Cause, effect: PlantEffect) -> str:
    """Torque 0.06 N·m, fall 60 %, speed 114 deg/s: the first few that carry the effect, see ``PlantEffect.stated``."""
    found = cause.parameters
    matter = [name for name in effect.stated or effect.stated_by_default if name in found]
    matter = [name for name in matter if not _may_have_value(found, *effect.idle.get(name, ("", 0.0)))]
    return parameters_text(cause, matter[:MOST_PARAMETERS], effect)


def _may_have_value(found: Mapping[str, Estimate], name: str, value: float) -> bool:
    """Whether a parameter is found, and may have this value."""
    if name not in found:
        return False
    estimate = found[name]
    low, high = (estimate.value if end is None else end for end in (estimate.low, estimate.high))
    return low <= value <= high


def parameters_text(cause: Cause, names: Sequence[str], effect: PlantEffect) -> str:
    """Torque 0.052 N·m, speed 0.3 rad/s: these parameters of the cause."""
    known = {parameter.name: parameter for parameter in effect.parameters}
    return ", ".join(f"{known[name].words} {_parameter_text(known[name], cause.parameters[name])}" for name in names)


def _parameter_text(parameter: Parameter, found: Estimate) -> str:
    """Its value in words, if it has only such, or with its unit."""
    return parameter.choices[round(found.value)] if parameter.choices else _value_text(found, parameter.form)


def _digits(estimate: Estimate, value: float) -> int:
    """Significant digits of the ``value`` as it is written: three, or two where the third says nothing.

    A tenth of the value is uncertain, or two digits are nearer to it than a tenth of what is: 10 ms for 9.99 +- 0.16.
    """
    low, high = (estimate.value if end is None else end for end in (estimate.low, estimate.high))
    if not math.isfinite(high - low) or estimate.value == 0.0:
        return 2 if high > low else 3
    uncertain = 0.5 * (high - low) / abs(estimate.value)
    rounded = abs(float(significant(value, 2)) / value - 1.0)
    return 2 if uncertain > ROUGH_INTERVAL or rounded < ROUGH_INTERVAL * uncertain else 3


def estimate_text(estimate: Estimate) -> str:
    """A value with its unit, to as many digits as its interval is worth."""
    return _value_text(estimate, "value")


def _value_text(estimate: Estimate, form: str) -> str:
    """A value with its unit; a share in per cent and a relative change with its sign, as on the page."""
    written = estimate.as_json()
    value, unit = float(written["value"]), str(written["unit"])
    if form in IN_PERCENT and unit == "1":
        value, unit = 100.0 * value, "percent"
    if unit == "s" and abs(value) < 1.0:
        value, unit = 1000.0 * value, "ms"
    sign = "+" if form == RELATIVE_CHANGE and value > 0.0 else ""
    for plain, better in TYPOGRAPHIC_UNITS.items():
        unit = unit.replace(plain, better)
    shown = sign + significant(value, _digits(estimate, value))
    return shown + ("" if unit == "1" else f" {unit}").replace(" °", "°")


def sentence(
    verdict: Verdict, causes: Sequence[str], tied: Sequence[Sequence[str]], probability: float, wording: ErrorWording
) -> str:
    """The whole diagnosis in two or three sentences; ``causes`` and those of each ``tied`` explanation in words.

    Of tied explanations without the causes that they have in common, see ``ErrorWording.common``.
    """
    error, floor = f"{wording.error} on {wording.on}", angle_text(wording.floor)
    rest = _remainder_sentence(verdict, wording)
    if verdict == "none":
        return _no_effect_sentence(wording, error, floor) + rest
    if verdict == "unknown":
        unsure, none = "No explanation is sure enough to be named", "No effect in the library explains most of the gap"
        return (
            f"{unsure if wording.takes > MOST_OF_GAP else none}: {error} is {angle_text(wording.before)}, "
            f"{_nearest_words(wording)}, the noise is {floor}.{rest}"
        )
    text = " and ".join(causes)
    if wording.parted is not None and wording.moved is not None:
        if verdict == "tie":
            named = (
                f"{_either_or(wording, causes, tied[:2])}: these trials cannot distinguish them. With the first of them"
            )
            return f"{named}, on {_errors_of_parts(wording, wording.parted, wording.moved)}"
        named = f"{text[0].upper()}{text[1:]}, {100 * probability:.0f} %"
        return f"{named}. On {_errors_of_parts(wording, wording.parted, wording.moved)}"
    if verdict == "tie":
        return (
            f"{_either_or(wording, causes, tied[:2])}: these trials cannot distinguish them. With any of them {error} "
            f"{_change_range_words(wording, wording.after, *wording.each)}, noise {floor}.{rest}"
        )
    named = f"{text[0].upper()}{text[1:]}, {100 * probability:.0f} %"
    change = f"{error} {_change_range_words(wording, wording.after)}, noise {floor}"
    if wording.shows_no_share:
        return (
            f"{named}. {change[0].upper()}{change[1:]}: within tolerances {wording.nominal} is at the noise already, "
            f"and shows no share of the gap that the cause takes.{rest}"
        )
    return f"{named}; {_reduction_words(wording.takes, len(causes))}: {change}.{_fitted_words(wording)}{rest}"


def _fitted_words(wording: ErrorWording) -> str:
    """What the explanation takes on the trials that it is fitted to, where it takes less on unseen ones than is asked.

    The odds ask it of the fitted trials: the share on unseen ones alone would seem to break that rule.
    """
    if not wording.takes < min(wording.asked, wording.takes_fitted):
        return ""
    return f" On the trials that the explanation is fitted to it takes {100 * wording.takes_fitted:.0f} %."


def _reduction_words(share: float, causes: int) -> str:
    """What the explanation does to the gap; a share that would round to 0 % or less is none."""
    if share < LEAST_SHOWN_SHARE:
        them = {1: "it does", 2: "both do"}.get(causes, "together they do")
        return f"{them} not reduce the gap"
    them = {1: "it takes", 2: "both take"}.get(causes, "together they take")
    return f"{them} {100 * share:.0f} % of the gap"


def _errors_of_parts(wording: ErrorWording, parted: PartedErrors, moved: Estimate) -> str:
    """The errors on the trials that the explanation predicts as it is, then on those that need other tolerances."""
    plain, others = parted.counts
    (first, now), (start, end) = parted.as_is, parted.if_moved
    them = "the other one" if others == 1 else f"the other {others}"
    share = f" (takes {100 * parted.takes:.0f} % of the gap)" if parted.takes >= LEAST_SHOWN_SHARE else ""
    return (
        f"{plain} of {plain + others} {wording.on} {wording.error} {_change_words(first, now)}{share}, noise "
        f"{angle_text(wording.floor)}. On {them} it {_change_words(start, end)}, which may be due to the "
        f"tolerances: moved within them, as far as the training trials allow, the explanation follows all to "
        f"{angle_text(moved)}."
    )


def _change_words(before: Estimate, after: Estimate) -> str:
    verb = "falls" if after.value <= before.value else "rises"
    return f"{verb} from {angle_text(before)} to {angle_text(after)}"


def _change_range_words(wording: ErrorWording, *after: Estimate) -> str:
    """How the error changes, with the range of its values over several explanations."""
    low, high = (angle_text(end(after, key=lambda each: each.value)) for end in (min, max))
    most, ends = max(each.value for each in after), low if low == high else f"between {low} and {high}"
    if high == low == wording.falls_from:
        return f"stays at {low}"
    if most <= wording.before.value:
        return f"falls from {wording.falls_from} to {ends}"
    if min(each.value for each in after) >= wording.before.value:
        return f"rises from {wording.falls_from} to {ends}"
    return f"goes from {wording.falls_from} to {ends}"


def _either_or(wording: ErrorWording, causes: Sequence[str], tied: Sequence[Sequence[str]]) -> str:
    """Either this or that; what all explanations contain is said once, before."""
    ways = ", or ".join(" and ".join(option) for option in (causes, *tied))
    if not wording.common:
        return f"Either {ways}"
    text = " and ".join(wording.common)
    return f"{text[0].upper()}{text[1:]}, and either {ways}"


def _no_effect_sentence(wording: ErrorWording, error: str, floor: str) -> str:
    """If nothing is missing: within the required accuracy, within the noise, or as near as the library comes."""
    if 0.0 < wording.before.value <= wording.accuracy:
        return (
            f"The gap does not matter: {error} is {angle_text(wording.before)}, less than the accuracy of "
            f"{significant(math.degrees(wording.accuracy), 2)}° required."
        )
    if wording.none < SURE_OF_NONE:
        return (
            f"These trials cannot show whether an effect is missing (probability that none is "
            f"{100 * wording.none:.0f} %): within tolerances {wording.nominal} has an error of "
            f"{angle_text(wording.before)} on {wording.on.rstrip(',')}; the noise is {floor}."
        )
    if wording.left is not None and wording.left.times_noise > LEAST_MENTIONED:
        return (
            f"No effect in the library improves the prediction: within tolerances {wording.nominal} has an error of "
            f"{angle_text(wording.before)} on {wording.on.rstrip(',')}; the noise is {floor}."
        )
    return (
        f"These trials show no missing effect: within tolerances {wording.nominal} has an error of "
        f"{angle_text(wording.before)} on {wording.on.rstrip(',')}; the noise is {floor}."
    )


def _nearest_words(wording: ErrorWording) -> str:
    """The nearest explanation if none explains the gap: the leading causes, each with its share."""
    helps = [(text, share) for text, share in wording.leading if share > LEAST_LEADING_SHARE]
    best = sorted(helps, key=lambda item: -item[1])[:MOST_LEADING]
    listed = ", ".join(f"{text} {100 * share:.0f} %" for text, share in best)
    if wording.after.value < wording.before.value:
        named = f"the nearest explanation, {wording.nearest}," if wording.nearest else "the nearest explanation"
        nearest = f"{named} leaves {angle_text(wording.after)}"
        return f"{nearest} (alone {listed})" if listed else nearest
    return f"single causes remove {listed}" if listed else "no explanation helps"


def _remainder_sentence(verdict: Verdict, wording: ErrorWording) -> str:
    """The remainder beyond the noise, and its main place; empty if negligible."""
    if (
        wording.left is None
        or wording.left.times_noise < LEAST_MENTIONED
        or 0.0 < wording.before.value <= wording.accuracy
    ):
        return ""
    place = wording.left.place(released=wording.released)
    mostly = f", mostly {place}" if place else ""
    within = " (within the required accuracy)" if wording.left.rms.value <= wording.accuracy else ""
    left = angle_text(wording.left.rms)
    if verdict in ("effect", "tie") and wording.moved is not None:
        aside = f"{mostly}," if mostly else ""
        return (
            f" The remaining {left}{aside} may be due to the tolerances: moved within them, as far as the training "
            f"trials allow, the explanation follows to {angle_text(wording.moved)}."
        )
    if verdict == "tie" and wording.each:
        return f" The first of them leaves {left}{mostly}{within}."
    if verdict in ("effect", "tie") and wording.further is not None and _takes_most(wording.further, wording.left):
        aside = f"{mostly}," if mostly else ""
        return f" The remaining {left}{within}{aside} {_further_words(wording.further, wording.floor)}."
    if verdict in ("effect", "tie") and not wording.tried:
        return f" Beside it no further cause was tried for the remaining {left}{mostly}{within}."
    if verdict in ("effect", "tie"):
        return f" No effect in the library explains the remaining {left}{mostly}{within}."
    return f" {left} remains unexplained{mostly}{within}."


def _takes_most(further: FurtherCauseWords, left: Remainder) -> bool:
    """Whether a further cause takes most of the remainder."""
    return further.left.value <= (1.0 - MOST_OF_GAP) * left.rms.value


def _further_words(further: FurtherCauseWords, floor: Estimate) -> str:
    """What becomes of the remainder with a further cause, why that is not named, and how the named ones change."""
    at_noise = further.left.value < LEAST_MENTIONED * floor.value
    goes = "would vanish in the noise" if at_noise else f"would fall to {angle_text(further.left)}"
    them = "that takes" if len(further.further) == 1 else "they take"
    why = f"{them} too little of the gap to be named" if further.little else "not sure enough to be named"
    return f"{goes} if {' and '.join(further.further)} ({why}); then {' and '.join(further.named)}"


def reason_for_next_trial(
    verdict: Verdict,
    explanations: Sequence[str],
    left: Remainder,
    *,
    within: bool = False,
    none: float = 1.0,
    takes: float = 0.0,
) -> str:
    """Why another trial: ``explanations`` are the accepted one and those tied with it, in words.

    ``left`` : by the accepted one. ``within`` : the gap is below the required accuracy. ``none`` : probability that no
    effect is missing. ``takes`` : share of the gap that the accepted one, or of none the nearest, removes.
    """
    if verdict == "tie":
        return f"{', '.join(explanations[:-1])} and {explanations[-1]} explain these trials equally well."
    if within:
        return (
            "The gap is below the required accuracy and causes were not judged; in this trial the most probable ones "
            "would show first."
        )
    if verdict == "none" and none < SURE_OF_NONE:
        return f"To show whether an effect is missing: {FIRST_TO_SHOW}."
    if verdict == "none" and left.times_noise > LEAST_MENTIONED:
        return f"No effect in the library improves the prediction; {FIRST_TO_SHOW}."
    if verdict == "none":
        return f"These trials show no missing effect; {FIRST_TO_SHOW}."
    if verdict == "unknown" and takes > MOST_OF_GAP:
        return "The nearest explanation is not sure enough to be named; here the nearest ones differ most."
    if verdict == "unknown":
        return "The missing effect is unknown; here the nearest explanations differ most."
    return "To confirm the cause against the next most probable one."
