"""The opening of a check's page: whether the recordings can be used, and what to correct first."""

from __future__ import annotations

from collections.abc import Mapping

from synth.reports.opening import Cell, Figures, Opening
from synth.reports.quantities import brief
from synth.reports.reading import Result
from synth.reports.section import sequence

MOST_STEPS = 3  # what to do first; the section has all
# Causes shown first, those of a drive where there is one.
ASKED = ("coulomb_friction", "backlash", "spring_preload", "latency")
ASKED_OF_DRIVE = ("gear_play", "servo_gain", "command_delay", "torque_constant", "torque_gain", "torque_delay")
ENDS = {"upper": "an end above at", "lower": "an end below at"}  # of travel, measured angle


def check_opening(result: Result) -> Opening:
    """The sentence, remedies of the worst findings, and the smallest detectable sizes."""
    document = result.content
    findings = [item for item in sequence(document, "findings") if isinstance(item, Mapping)]
    worst = [item for item in findings if item.get("level") != "note" and item.get("remedy")]
    steps = [f"{item.get('recording') or item.get('joint') or 'All'}: {item.get('remedy')}." for item in worst]
    trust = "No fit was made: this shows the content of the recordings, and the response to each cause."
    return Opening(
        str(document.get("sentence") or ""),
        trust,
        steps[:MOST_STEPS],
        figures=_figures(result),
        good=bool(document.get("usable")),
    )


def _figures(result: Result) -> Figures | None:
    causes = [item for item in sequence(result.content, "causes") if isinstance(item, Mapping)]
    joints = list(dict.fromkeys(str(c.get("joint")) for c in causes if c.get("joint") not in ("base", "all")))
    shown = {(c.get("effect"), c.get("joint")): c for c in causes}
    rows = []
    for effect in (*ASKED, *ASKED_OF_DRIVE):
        cells = [Cell(cause_size(shown.get((effect, joint)))) for joint in joints]
        if any((effect, joint) in shown for joint in joints):
            rows.append([Cell(effect.replace("_", " ")), *cells])
    if not rows:
        return None
    share = result.content.get("remainder_assumed")
    note = f"Smallest detectable size, with {100 * float(share or 0):g} % of the motion unexplained."
    return Figures(("Cause", *joints), rows, note)


def cause_size(cause: object) -> str:
    """The smallest detectable size of a cause; one that is not plausible is said to be so; a dash without any."""
    if not isinstance(cause, Mapping):
        return "–"
    only, limit = cause.get("only_from"), bool(cause.get("limit"))
    text = size_text(only or cause.get("visible_from"), limit=limit)
    stated = cause.get("stated")
    if isinstance(stated, Mapping) and stated and text != "–":
        text = f"a change of {text} from the stated {brief(next(iter(stated.values())))}"
    return f"only from {text}, implausible" if only else text


def size_text(visible: object, *, limit: bool = False) -> str:
    """The first strength of a cause, at most it of a ``limit``, its place if it is a stop, or a dash."""
    if not isinstance(visible, Mapping) or not visible:
        return "–"
    places = [f"{ENDS[key]} {brief(value)}" for key, value in visible.items() if key in ENDS]
    if places:
        return ", ".join(places)
    return f"{'at most ' if limit else ''}{brief(next(iter(visible.values())))}"
