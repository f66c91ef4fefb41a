"""The opening of a rehearsal's page: how often planted causes are found, and their smallest sizes."""

from __future__ import annotations

from collections.abc import Mapping

from synth.reports.opening import Cell, Figures, Opening
from synth.reports.quantities import brief
from synth.reports.reading import Result
from synth.reports.section import sequence

# Causes shown first, of a leg with servos too
ASKED = ("coulomb_friction", "backlash", "spring_preload", "latency", "servo_gain", "gear_load_friction")


def rehearsal_opening(result: Result) -> Opening:
    """The sentence, and the sizes of what people ask for first."""
    document = result.content
    share = 100.0 * float(document.get("background_share") or 0.0)
    trust = (
        f"{document.get('cases')} cases in simulations of this leg with these trials, this noise and these tolerances, "
        f"additional small causes that leave {share:g} % of the motion ({brief(document.get('background'))}), "
        "with an independent engine and other functional forms; each diagnosed without access to the answer."
    )
    more = "For surer counts plant more: the same command with a larger `--count` goes on from here."
    return Opening(str(document.get("sentence") or ""), trust, [more], figures=_figures(result))


def _figures(result: Result) -> Figures | None:
    causes = [item for item in sequence(result.content, "causes") if isinstance(item, Mapping) and item.get("cases")]
    joints = list(dict.fromkeys(str(c.get("joint")) for c in causes if c.get("joint") != "base"))
    found = {(c.get("effect"), c.get("joint")): c for c in causes}
    rows = []
    planted = [effect for effect in ASKED if any((effect, joint) in found for joint in joints)]
    for effect in planted or list(dict.fromkeys(str(c.get("effect")) for c in causes))[: len(ASKED)]:
        cells = [visible_cell(found.get((effect, joint))) for joint in joints]
        if any((effect, joint) in found for joint in joints):
            rows.append([Cell(effect.replace("_", " ")), *cells])
    return Figures(("Smallest size found", *joints), rows) if rows else None


def visible_cell(cause: object) -> Cell:
    """Size, and the resulting gap."""
    if not isinstance(cause, Mapping) or not cause.get("cases"):
        return Cell("–")
    if cause.get("visible_from") is None:
        return Cell("only tied" if cause.get("tied") else "never")
    return Cell(brief(cause["visible_from"]), f"gap {brief(cause.get('visible_gap'))}")
