"""What to record next: the trial that best separates the remaining explanations."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from synth.reports.figures.bars import Bar, BarColumn, bar_figure
from synth.reports.quantities import number
from synth.reports.reading import Json, Result, value_of
from synth.reports.section import ReportSection, mapping, sequence
from synth.reports.sections.gap_which import leaves_error, sure_of_effect, sure_of_none, takes_most, within_accuracy

WIDTH, LABEL = 860.0, 515.0  # px
# What to do where no trial of the list would help, by ``_open_question``; if nothing is open nothing is left to record.
NO_TRIAL = {
    "tie": "No usual trial separates the tied explanations: measure what they blame by itself{example}. Until then "
    "take either; they predict these trials alike.",
    "unknown": "No usual trial shows more of the unknown cause: look at the rig where the remainder is largest.",
    "unsure": "No usual trial would make the nearest explanation surer: look at the part that it blames, and at the "
    "rig where the remainder is largest.",
    "whether": "None of the usual trials would show whether an effect is missing: what these trials still allow is too "
    "small for that. A finer sensor, many repeats or far larger swings would show smaller effects.",
    "remainder": "No usual trial shows more of what remains unexplained: look at the rig where it is largest.",
    "cause": "No usual trial would make this cause surer: look at the part that it blames, or measure that by itself.",
}
# Part of an effect's name, and what could be measured by itself; the first that fits.
BY_ITSELF = (
    ("spring", "a spring on a bench"),
    ("damping", "a damper on a bench"),
    ("command_delay", "the time from a command to the current that it draws"),
    ("latency", "the time from a knock to its reading"),
    ("resistance", "the winding with an ohmmeter"),
    ("link", "a link on a scale"),
)
NOTHING_NEEDED = "no trial of the list would change the diagnosis"
MOST_TRIALS = 8  # trials of the menu that are drawn


def content(result: Result) -> dict[str, Any]:
    """The trial as an entry of ``trials:``, its release, and the menu by expected information."""
    experiment = mapping(result.content, "next_experiment")
    if not experiment:
        settled = not _open_question(result.content)
        return {"experiment": None, "no_trial": without_trial(result.content, "Nothing"), "settled": settled}
    menu = [item for item in sequence(experiment, "menu") if isinstance(item, Mapping)]
    menu = sorted(menu, key=lambda item: -(value_of(item.get("information")) or 0.0))
    if all(item.get("information") != experiment.get("information") for item in menu):
        menu = [{"what": "the trial above", "information": experiment.get("information")}, *menu]
    left_out, menu = len(menu) - MOST_TRIALS, menu[:MOST_TRIALS]
    bits = [value_of(item.get("information")) or 0.0 for item in menu]
    bars = [Bar(value, f"{number(value, 2)} bit", strong=index == 0) for index, value in enumerate(bits)]
    labels = [str(item.get("what")) for item in menu]
    column = BarColumn("expected information", bars, max(bits), words=72.0)
    return {
        "experiment": experiment,
        "entry": entry_text(mapping(experiment, "trial")),
        "release": mapping(experiment, "release"),
        "left_out": max(left_out, 0),
        "figure": bar_figure("Trials by expected information", labels, [column], WIDTH, LABEL) if menu else None,
    }


def without_trial(document: Json, nothing: str) -> str:
    """What to do if the result proposes no trial; ``nothing`` begins the sentence where nothing is left to do."""
    found = NO_TRIAL.get(_open_question(document), f"{nothing}: {NOTHING_NEEDED}.")
    return found.replace("{example}", _example(document))


def _example(document: Json) -> str:
    """What could be measured by itself, of what the tied explanations blame; empty if nothing of the list."""
    causes = [*sequence(document, "explanation"), *(cause for each in sequence(document, "tied") for cause in each)]
    blamed = {str(cause.get("effect")) for cause in causes if isinstance(cause, Mapping)}
    return next((f", {words} for example" for part, words in BY_ITSELF if any(part in name for name in blamed)), "")


def _open_question(document: Json) -> str:
    """What the diagnosis leaves open, a key of ``NO_TRIAL``; empty if nothing."""
    verdict = str(document.get("verdict"))
    if within_accuracy(document):
        return ""
    if verdict == "none":
        return "whether" if not sure_of_none(document) else "remainder" if leaves_error(document) else ""
    if verdict == "effect":
        return "" if sure_of_effect(document) else "cause"
    return "unsure" if verdict == "unknown" and takes_most(document) else verdict


def entry_text(trial: Mapping[str, Any]) -> str:
    """An entry of ``trials:`` in the project file's form, with a placeholder for the file."""
    words = [f"{key}: {_value_text(value)}" for key, value in trial.items() if key != "file"]
    return "- {" + ", ".join([f"file: {trial.get('file', 'trials/next.csv')}", *words]) + "}"


def _value_text(value: object) -> str:
    if isinstance(value, list):
        return "[" + ", ".join(map(str, value)) + "]"
    if isinstance(value, Mapping) and value_of(value) is not None:
        return f"{number(value_of(value))} {value.get('unit', '')}".replace("−", "-")
    return str(value).lower() if isinstance(value, bool) else str(value)


SECTION = ReportSection("next", "What to record next", content)
