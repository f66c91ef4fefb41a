"""The opening of a rehearsal's page: how often planted causes are found, and their smallest sizes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from synth.reports.opening import Cell, Figures, Opening
from synth.reports.quantities import brief
from synth.reports.reading import Result
from synth.reports.section import mapping, sequence

MOST_CAUSES = 8  # in the opening; their section has all
# Causes shown first, of a leg with servos too
ASKED = ("coulomb_friction", "backlash", "spring_preload", "latency", "servo_gain", "gear_friction")


def rehearsal_opening(result: Result) -> Opening:
    """The sentence, and the sizes of the planted causes, what people ask for first."""
    document = result.content
    trust = (
        f"{document.get('cases')} cases in simulations of this leg with these trials, this noise"
        f"{_filter_words(document)} and these tolerances, {_planted_beside(document)}, with an independent engine and "
        "other functional forms; each diagnosed without access to the answer."
    )
    more = "For surer counts plant more: the same command with a larger `--count` goes on from here."
    coverage = str(document.get("coverage") or "")
    return Opening(str(document.get("sentence") or ""), f"{coverage} {trust}".strip(), [more], figures=_figures(result))


def _filter_words(document: Mapping[str, Any]) -> str:
    """What the noise of some joints seems to have gone through; nothing where it is independent."""
    behind = mapping(document, "noise_filters")
    return f" ({', '.join(f'{joint}: as behind {words}' for joint, words in behind.items())})" if behind else ""


def _planted_beside(document: Mapping[str, Any]) -> str:
    """What was planted beside the main causes."""
    share = f"{100.0 * float(document.get('background_share') or 0.0):g} % of the motion"
    small, aim = mapping(document, "small_causes"), brief(document.get("background"))
    if not small.get("cases"):
        return f"no small causes beside ({share}, {aim}, would be hidden by the noise, {brief(document.get('noise'))})"
    where = "" if small.get("cases") == small.get("of") else f" in {small.get('cases')} of {small.get('of')}"
    text = f"up to {small.get('most')} small causes beside{where} that leave {brief(small.get('gap'))} "
    return text + f"(aim: {share}, {aim})"


def _figures(result: Result) -> Figures | None:
    causes = [item for item in sequence(result.content, "causes") if isinstance(item, Mapping) and item.get("cases")]
    planted_at = {c.get("joint") for c in causes}
    joints = [str(name) for name in sequence(result.content, "joints") if name in planted_at]
    found = {(c.get("effect"), c.get("joint")): c for c in causes}
    rows = []
    planted = {str(c.get("effect")): False for c in causes}
    planted |= {str(c.get("effect")): True for c in causes if c.get("visible_from") is not None}
    # Of those that people ask for and of the others, the found ones first.
    order = sorted(planted, key=lambda effect: (effect not in ASKED, not planted[effect]))
    for effect in order[:MOST_CAUSES]:
        cells = [visible_cell(found.get((effect, joint))) for joint in joints]
        if any((effect, joint) in found for joint in joints):
            rows.append([Cell(effect.replace("_", " ")), *cells])
    more = len(order) - MOST_CAUSES
    note = f"{more} more planted cause{'s are' if more > 1 else ' is'} in the table below." if more > 0 else ""
    return Figures(("Smallest size found", *joints), rows, note) if rows else None


def visible_cell(cause: object) -> Cell:
    """Size and the resulting gap; if it never was found, the number of cases: one miss is not "never"."""
    if not isinstance(cause, Mapping) or not cause.get("cases"):
        return Cell("–")
    if cause.get("visible_from") is None:
        word, count = ("only tied", cause.get("tied")) if cause.get("tied") else ("not found", 0)
        return Cell(word, f"{count} of {cause.get('cases')}")
    return Cell(brief(cause["visible_from"]), f"gap {brief(cause.get('visible_gap'))}")
