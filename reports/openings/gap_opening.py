"""The opening of a gap's page: the diagnosis in a sentence, its motion, and the causes with their probabilities."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from markupsafe import Markup

from synth.reports.opening import Cell, Figures, Opening
from synth.reports.quantities import brief, percent_interval, share_text, whole_percent
from synth.reports.reading import Json, Result, value_of
from synth.reports.section import mapping, sequence
from synth.reports.sections import gap_how_far
from synth.reports.sections.gap_next import entry_text, without_trial
from synth.reports.sections.gap_which import (
    LEAST_PROBABILITY,
    OTHERS,
    leaves_error,
    meaning_of,
    name_of,
    others_probability,
    sure_of_none,
    within_accuracy,
    words_of_none,
)

MOST_CAUSES = 3  # in the opening, with those that the sentence above it names; its section has all
# Explanations tied with the first, and causes that alone remove most and at least this share, that the sentence names
# (``synth.diagnosis.sentences``).
TIED_NAMED, MOST_ALONE, LEAST_ALONE = 2, 3, 0.05
# In words, how the scored trials were predicted if none was held out.
HOW = {
    "in_turn": ", each in turn predicted from the others",
    "pieces_in_turn": ", each piece in turn predicted from the others",
    "fitted": ", the one that was fitted",
}
ON = {
    "in_turn": "each trial, predicted from the others",
    "pieces_in_turn": "each piece of the recording, predicted from the others",
    "fitted": "the trial that was fitted",
}


def gap_opening(result: Result) -> Opening:
    """The sentence, the scored trial with the largest error, and the most probable causes."""
    document = result.content
    figure = gap_how_far.worst_figure(result)
    verdict = str(document.get("verdict") or "–")
    return Opening(
        str(document.get("sentence") or ""),
        _trust(document, verdict),
        _steps(document),
        figure.drawing if figure else Markup(""),
        figure.caption if figure else "",
        _figures(document),
        _is_good(document, verdict),
        beside=figure.pose if figure else Markup(""),
    )


def _is_good(document: Json, verdict: str) -> bool | None:
    """Of the verdict none only where it settles the matter: the probability of a missing effect may be larger."""
    if _leaves_open(document, verdict):
        return None
    return {"effect": True, "none": True, "unknown": False}.get(verdict)


def _leaves_open(document: Json, verdict: str) -> bool:
    """Whether the verdict none is unsure, or an error above the noise remains."""
    unsure = verdict == "none" and not (within_accuracy(document) or sure_of_none(document))
    return unsure or leaves_error(document)


def _trust(document: Json, verdict: str) -> str:
    trials = [trial for trial in sequence(document, "trials") if isinstance(trial, Mapping)]
    scored = [trial for trial in trials if trial.get("scored")]
    means = meaning_of(document)
    words = f"{means[:1].upper()}{means[1:]}." if means else f"Verdict {verdict}."
    if _leaves_open(document, verdict):
        words = ""  # the headline says it
    if not scored:
        return words
    count = f"{len(scored)} trial{'s' if len(scored) != 1 else ''}"
    if all(trial.get("held_out") for trial in scored):
        return f"{words} Scored on {count} left out of the diagnosis.".strip()
    fallback = "in_turn" if len(scored) > 1 else "fitted"  # of a result that does not say it
    how = HOW.get(str(document.get("scored_by") or fallback), "")
    return f"{words} Scored on {count}{how}.".strip()


def _steps(document: Json) -> list[str]:
    experiment = mapping(document, "next_experiment")
    if not experiment:
        return [without_trial(document, "No further recording needed")]
    trial = mapping(experiment, "trial")
    entry = f" Write it as `{entry_text(trial)}` under `trials:`." if trial else ""
    command = experiment.get("command")
    settled = " Let the leg settle at the first angles of"
    play = f"{settled} `{command}`, which lies beside this page; then play and record it." if command else ""
    return [f"{experiment.get('why')}{play}{entry}"]


def listed_causes(document: Json, most: int) -> list[Mapping[str, Any]]:
    """The ``most`` probable causes, and those that the sentence names besides."""
    ranked = [entry for entry in sequence(document, "ranked") if isinstance(entry, Mapping)]
    explanations = [sequence(document, "explanation"), *sequence(document, "tied")[:TIED_NAMED]]
    named = {name_of(cause) for causes in explanations for cause in causes}
    if document.get("verdict") == "unknown":  # it names those that alone remove most
        alone = [entry for entry in ranked if (value_of(entry.get("shrink")) or 0.0) > LEAST_ALONE]
        alone.sort(key=lambda entry: -(value_of(entry.get("shrink")) or 0.0))
        named |= {name_of(entry) for entry in alone[:MOST_ALONE]}
    return [entry for place, entry in enumerate(ranked) if place < most or name_of(entry) in named]


def _figures(document: Json) -> Figures | None:
    """The most probable causes, and the error that remains with them."""
    listed = listed_causes(document, MOST_CAUSES)
    rows = [
        [
            Cell(name_of(entry)),
            Cell(share_text(entry.get("probability"))),
            Cell(whole_percent(entry.get("shrink")), percent_interval(entry.get("shrink"))),
        ]
        for entry in listed
    ]
    others = others_probability(document, listed)
    if others >= LEAST_PROBABILITY:
        rows.append([Cell(OTHERS), Cell(share_text(others)), Cell("–")])
    for key, words in (("none", words_of_none(document)), ("unknown", "not in the library")):
        if f"probability_{key}" in document:
            rows.append([Cell(words), Cell(share_text(document[f"probability_{key}"])), Cell("–")])
    if not rows:
        return None
    gap = mapping(document, "gap")
    steps = (("as_designed", "as designed"), ("before", "at its best within tolerances"), ("after", "explained"))
    errors = [f"{words} {brief(gap.get(key))}" for key, words in steps if gap.get(key)]
    on = ON.get(str(document.get("scored_by")), "unseen trials")
    note = f"RMS angle error on {on}: {', '.join(errors)}; noise {brief(gap.get('noise_floor'))}."
    if len(sequence(document, "explanation")) > 1:
        note += " Of causes accepted together the one that takes most comes first."
    return Figures(("Cause", "Probability", "Alone reduces the gap by"), rows, note if errors else "")
