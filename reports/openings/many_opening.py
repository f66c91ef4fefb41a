"""The openings of the pages of many diagnoses and many designs."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from markupsafe import Markup

from synth.reports.opening import Cell, Figures, Opening, joined_names
from synth.reports.quantities import text
from synth.reports.reading import Result, value_of
from synth.reports.section import AbsentResult, mapping, records, sequence
from synth.reports.sections import many_gaps
from synth.reports.sections.gap_which import LARGEST_AT_NOISE, sure_of_none
from synth.reports.sections.warnings import of_leg

WORDS = {  # of one leg, and of several
    "effect": ("has a cause", "have a cause"),
    "tie": ("is tied between causes", "are tied between causes"),
    "unknown": ("has an unknown cause", "have an unknown cause"),
    "none": ("lacks nothing", "lack nothing"),
    "unexplained": ("has an error that no effect reduces", "have an error that no effect reduces"),
    "unsure": ("cannot show whether an effect is missing", "cannot show whether an effect is missing"),
}
MOST_ROWS = 5  # of the opening's table
NEXT = "Open a leg's page below: it tells the cause; beside that of a swinging leg `diagnosed.leg.yaml` has it."


def gaps_opening(result: Result) -> Opening:
    """How many were diagnosed, which causes are common, and what failed."""
    legs = records(result.content, "legs")
    verdicts = Counter(_kind(leg) for leg in legs)
    verdict_counts = [f"{verdicts[key]} {words[verdicts[key] > 1]}" for key, words in WORDS.items() if verdicts[key]]
    found = many_gaps.CAUSES.content(result)
    figure, caption = Markup(""), ""
    if not isinstance(found, AbsentResult):
        figure, caption = found["figure"], found["title"]
    rows = [
        [Cell(name), Cell(str(len(where)), joined_names(where[:3]))] for name, where in many_gaps.causes(result).items()
    ][:MOST_ROWS]
    unsure = [str(leg["name"]) for leg in legs if _kind(leg) in ("tie", "unknown", "unsure")]
    steps = [f"See in the reports of {_some_names(unsure)} what would decide."] if unsure else []
    return Opening(
        f"{_diagnosed_count(result)} diagnosed{f': {joined_names(verdict_counts)}' if verdict_counts else ''}.",
        _warned_count(legs),
        [*steps, *_mend(result, "diagnosed")] or [NEXT],
        figure,
        caption,
        Figures(("Cause", "Legs"), rows) if rows else None,
        not sequence(result.content, "failed"),
    )


def _kind(leg: Mapping[str, Any]) -> str:
    """The verdict of a leg; where nothing was found ``unsure`` if the trials cannot show whether something is, and
    ``unexplained`` if an error far above the noise remains.
    """
    verdict = str(leg.get("verdict"))
    if verdict != "none":
        return verdict
    if not sure_of_none(leg):
        return "unsure"
    # Within the required accuracy, where nothing is judged, the probability is 1.
    return "unexplained" if leg.get("probability_none") != 1.0 and _times_noise(leg) > LARGEST_AT_NOISE else verdict


def _times_noise(leg: Mapping[str, Any]) -> float:
    """A leg's remaining error above the noise, in noise floors."""
    left, floor = (value_of(mapping(leg, "rms").get(stage)) for stage in ("after", "noise_floor"))
    return math.sqrt(max((left / floor) ** 2 - 1.0, 0.0)) if left and floor else 0.0


def legs_opening(result: Result) -> Opening:
    """How many were designed, which are farthest from the wanted motion, and what failed."""
    legs = records(result.content, "legs")
    refused = [str(leg["name"]) for leg in legs if sequence(leg, "failed_checks")]
    steps = (
        [f"The joints of {_some_names(refused)} fail a check and are not exported: see their reports."]
        if refused
        else []
    )
    other = [str(leg["name"]) for leg in legs if sequence(leg, "another_motion")]
    if other:
        steps.append(
            f"The links of {_some_names(other)} do not make the animal's motion, and are near another one: see their "
            "reports."
        )
    worst = sorted(legs, key=lambda leg: -float(mapping(leg, "rms").get("value") or 0.0))[:MOST_ROWS]
    rows = [[Cell(str(leg["name"])), Cell(text(leg.get("rms")))] for leg in worst]
    bad, final = bool(refused or sequence(result.content, "failed")), all(leg.get("drawn") is not False for leg in legs)
    return Opening(
        f"{_diagnosed_count(result)} designed.",
        _warned_count(legs),
        [*steps, *_mend(result, "designed")] or [_next_of_legs(legs)],
        figures=Figures(("Farthest from the wanted motion", "RMS"), rows) if rows else None,
        good=False if bad else True if final and not other else None,
    )


def _next_of_legs(legs: Sequence[Mapping[str, Any]]) -> str:
    bare = [str(leg["name"]) for leg in legs if leg.get("drawn") is False]
    if bare:
        return (
            f"Run {_some_names(bare)} without `--no-cad` before you order: only then do the links carry their joints' "
            "parts, and spring rates go with the links' inertia."
        )
    return "Open a leg's page below: its parts to order and to print."


def _diagnosed_count(result: Result) -> str:
    legs, failed = sequence(result.content, "legs"), sequence(result.content, "failed")
    return f"{len(legs)} of {len(legs) + len(failed)} projects {'was' if len(legs) == 1 else 'were'}"


def _warned_count(legs: Sequence[Mapping[str, Any]]) -> str:
    warned = sum(bool(of_leg(leg)) for leg in legs)
    return (
        f"{warned} of them {'has' if warned == 1 else 'have'} warnings."
        if warned
        else "None has a warning."
        if legs
        else ""
    )


def _mend(result: Result, done: str) -> list[str]:
    failed = [str(mapping(item).get("name")) for item in sequence(result.content, "failed")]
    return (
        [f"Correct {_some_names(failed)}, and repeat the command: projects already {done} are kept."] if failed else []
    )


def _some_names(names: Sequence[str]) -> str:
    more = f" and {len(names) - 3} more" if len(names) > 3 else ""
    return f"{', '.join(names[:3]) if more else joined_names(names)}{more}"
