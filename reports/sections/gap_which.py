"""Which effect: the verdict, what was accepted, and every candidate with its probability."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from markupsafe import Markup

from synth.reports.figures.bars import Bar, BarColumn, bar_figure
from synth.reports.parameter_rows import parameter_rows
from synth.reports.quantities import brief, number, share_text, whole_percent
from synth.reports.reading import Json, Result, value_of
from synth.reports.section import AbsentResult, ReportSection, mapping, sequence

VERDICTS = {
    "effect": "the trials identify the cause",
    "none": "no effect is missing: the designed leg, within its tolerances, explains the trials",
    "tie": "an effect is missing, but these trials cannot distinguish the effects below",
    "unknown": "no effect in the library explains the trials",
}
WITHIN = "the gap is below the required accuracy; causes were not judged"
# Probability from which the trials identify the first cause, or show that none is missing; below, they favour the
# cause, and cannot show whether one is missing.
SURE_PROBABILITY = 0.8
# Noise floors that a remainder may have for the trials to be explained; above, its size is told beside the verdict.
LARGEST_AT_NOISE = 0.5
# Of the gap, as of the headline (``MOST_OF_GAP`` in ``synth.diagnosis.sentences``): an explanation that takes more
# explains the trials, though it is too unsure to be named.
MOST_OF_GAP = 0.5
WIDTH, LABEL = 800.0, 236.0  # px
MOST_BARS = 10  # candidates drawn
LEAST_PROBABILITY = 0.005  # a candidate less probable than this is counted among the others
OTHERS = "all others together"  # less probable candidates, most of which are not in the result


def content(result: Result) -> dict[str, Any] | AbsentResult:
    """Verdict, accepted causes, the candidates' figure and table."""
    document = result.content
    ranked = [entry for entry in sequence(document, "ranked") if isinstance(entry, Mapping)]
    if not ranked and "verdict" not in document:
        return AbsentResult(f"{result.name} ranks no candidate")
    verdict = str(document.get("verdict"))
    return {
        "verdict": verdict,
        "means": meaning_of(document),
        "explanation": [_cause(item, document) for item in sequence(document, "explanation")],
        "several": len(sequence(document, "explanation")) > 1 or _adds_up_to_more(document, ranked),
        "tied": [[_cause(item, document) for item in causes] for causes in sequence(document, "tied")],
        "has_trial": bool(mapping(document, "next_experiment")),
        "figure": _figure(document, ranked),
        "unknown": verdict == "unknown",
        "ranked": [
            {**_cause(entry, document), "probability": share_text(entry.get("probability"))} for entry in ranked
        ],
        "shown": MOST_BARS,
        "others": _others_text(document, ranked),
        "diagnosed": False,
    }


def meaning_of(document: Json) -> str:
    """The verdict in words; of an effect how sure it is."""
    if within_accuracy(document):
        return WITHIN
    verdict = str(document.get("verdict"))
    if verdict == "none" and not sure_of_none(document):
        none = share_text(document.get("probability_none"))
        return f"these trials cannot show whether an effect is missing; the probability that none is missing is {none}"
    if leaves_error(document):
        left = mapping(document, "remainder")
        return (
            f"nothing in the library improves the prediction of the designed leg; {brief(left.get('rms'))}, "
            f"{number(_number(left.get('times_noise')), 2)} times the noise, remains unexplained"
        )
    if verdict == "unknown" and takes_most(document):
        takes = whole_percent(mapping(document, "gap").get("shrink"))
        return f"the nearest explanation, which takes {takes} of the gap, is not sure enough to be named"
    if verdict != "effect" or sure_of_effect(document):
        return VERDICTS.get(verdict, "")
    unknown = share_text(document.get("probability_unknown"))
    return f"the trials favour this cause; the probability that it is not in the library is {unknown}"


def takes_most(document: Json) -> bool:
    """Whether the explanation takes most of the gap, named or not."""
    return (value_of(mapping(document, "gap").get("shrink")) or 0.0) > MOST_OF_GAP


def sure_of_effect(document: Json) -> bool:
    """Whether the trials identify the first cause."""
    first = sequence(document, "ranked")[:1]
    return bool(first) and isinstance(first[0], Mapping) and _number(first[0].get("probability")) >= SURE_PROBABILITY


def sure_of_none(document: Mapping[str, Any]) -> bool:
    """Whether the trials show that no effect is missing; a result that does not state the probability is taken so."""
    return _number(document.get("probability_none", 1.0)) >= SURE_PROBABILITY


def leaves_error(document: Json) -> bool:
    """Whether no effect is named although an error above the noise, and the required accuracy, remains."""
    if document.get("verdict") != "none" or within_accuracy(document):
        return False
    return _number(mapping(document, "remainder").get("times_noise")) > LARGEST_AT_NOISE


def words_of_none(document: Json) -> str:
    """The candidate that is no effect, in a few words: of what remains unexplained it is not said that none lacks."""
    if within_accuracy(document):
        return "below the required accuracy"
    return "the design as it is" if leaves_error(document) else "no effect is missing"


def within_accuracy(document: Json) -> bool:
    """Whether the gap is below the required accuracy, so that causes were not judged."""
    return document.get("within_accuracy") is True


def name_of(cause: Mapping[str, Any]) -> str:
    """``coulomb friction, knee``."""
    where = "all joints" if cause.get("joint") == "all" else cause.get("joint")
    return f"{str(cause.get('effect')).replace('_', ' ')}, {where}"


def others_probability(document: Json, shown: Sequence[Mapping[str, Any]]) -> float:
    """Probability of the candidates that are not shown, those that the result does not list too.

    If several causes act together, each has the probability of being one of them, which does not add up: of those
    that are listed only.
    """
    ranked = [entry for entry in sequence(document, "ranked") if isinstance(entry, Mapping)]
    if len(sequence(document, "explanation")) > 1:
        return sum(_number(entry.get("probability")) for entry in ranked if entry not in shown)
    known = sum(_number(document.get(f"probability_{key}")) for key in ("none", "unknown"))
    return max(0.0, 1.0 - known - sum(_number(entry.get("probability")) for entry in shown))


def _adds_up_to_more(document: Json, ranked: Sequence[Mapping[str, Any]]) -> bool:
    """Whether the listed probabilities add up to more than 1, as of causes that are likely together but not named."""
    known = sum(_number(document.get(f"probability_{key}")) for key in ("none", "unknown"))
    return known + sum(_number(entry.get("probability")) for entry in ranked) > 1.0 + LEAST_PROBABILITY


def _others_text(document: Json, ranked: Sequence[Mapping[str, Any]]) -> str:
    """The probability of the candidates that the result does not list; empty if negligible."""
    others = others_probability(document, ranked)
    return share_text(others) if others >= LEAST_PROBABILITY else ""


def _cause(entry: Mapping[str, Any], document: Json) -> Json:
    described = mapping(document, "effects", str(entry.get("effect")))
    return {
        "name": name_of(entry),
        "effect": str(entry.get("effect")),
        "joint": str(entry.get("joint")),
        "parameters": parameter_rows(entry, document),
        "shrink": entry.get("shrink"),
        **{key: described.get(key) for key in ("meaning", "formula", "source")},
    }


def _figure(document: Json, ranked: list[Mapping[str, Any]]) -> Markup:
    """Probability and shrink of each candidate, improbable candidates as one row, then none and unknown.

    In the order of the table: of several causes accepted together the one that takes most comes first.
    """
    shown = [entry for entry in ranked if _number(entry.get("probability")) >= LEAST_PROBABILITY][:MOST_BARS]
    shown = shown or ranked[:3]
    others, unlisted = others_probability(document, shown), others_probability(document, ranked)
    labels = [name_of(entry) for entry in shown]
    chances = [_number(entry.get("probability")) for entry in shown]
    shrinks = [_shrink(entry.get("shrink")) for entry in shown]
    if len(shown) < len(ranked) or unlisted >= LEAST_PROBABILITY:
        listed = unlisted < LEAST_PROBABILITY
        labels.append(f"{len(ranked) - len(shown)} others together" if listed else OTHERS)
        chances.append(others)
        shrinks.append(None)
    labels += [f"none: {words_of_none(document)}", "unknown: not in the library"]
    chances += [_number(document.get(f"probability_{key}")) for key in ("none", "unknown")]
    shrinks += [None, None]
    most, last = max(chances), len(labels) - 2
    bars = [
        Bar(chance, share_text(chance), strong=chance == most and index < last, apart=index >= last)
        for index, chance in enumerate(chances)
    ]
    columns = [BarColumn("probability", bars, 1.0), BarColumn("alone it reduces the gap by", shrinks, 1.0, words=76.0)]
    return bar_figure("Candidates with their probability", labels, columns, WIDTH, LABEL)


def _shrink(shrink: object) -> Bar | None:
    value = value_of(shrink)
    if value is None:
        return None
    low, high = (shrink.get("interval90") or (None, None)) if isinstance(shrink, Mapping) else (None, None)
    return Bar(value, whole_percent(value), low, high)


def _number(value: object) -> float:
    return float(value) if isinstance(value, (int, float)) else 0.0


def _content_of_swings(result: Result) -> dict[str, Any] | AbsentResult:
    """The same, with the file that a diagnosis of a swinging leg writes beside its page."""
    found = content(result)
    return found if isinstance(found, AbsentResult) else {**found, "diagnosed": True}


SECTION = ReportSection("which", "Which effect causes it", _content_of_swings)
OF_A_JUMP = ReportSection("which", "Which effect causes it", content)  # a diagnosis of jumps writes no leg file
