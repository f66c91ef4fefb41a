"""What a command ends with on the screen: its result as a table, and at most five notes, a line each.

Everything is read from the result file that the command has written, so that the screen, ``--json`` and the page tell
the same numbers.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from textwrap import shorten
from typing import TYPE_CHECKING, Any

from synth.commands.table_text import table_text
from synth.files.shown_units import METRIC, ShownUnits

if TYPE_CHECKING:
    from synth.commands.progress import Progress

Json = Mapping[str, Any]

MOST_NOTES = 5  # on the screen; the rest is counted and stands in the report
NOTE_LETTERS = 150  # of a note; the page has the whole
MOST_CAUSES = 5  # on the screen
OFFERED = 4.0  # times or part of the wanted rate: a spring farther off makes another leg, whatever its response


def tell(progress: Progress, result: Path, text: Callable[[Json], str], notes: Sequence[str] | None = None) -> None:
    """Print the result's table, or with ``--json`` the result itself; then the foremost notes.

    Parameters
    ----------
    result
        the JSON file that the command wrote; its warnings are the notes where none are given.
    text
        makes the table from its content.
    """
    written = result.read_text(encoding="utf-8")
    content = json.loads(written)
    if progress.as_json:
        progress.document(written)
    else:
        progress.result(text(content))
    tell_notes(progress, notes if notes is not None else warning_texts(content), result)


def tell_notes(progress: Progress, notes: Sequence[str], result: Path) -> None:
    """At most five notes, those first that could change a decision; the rest counted, and where they stand."""
    if not notes:
        return
    from synth.reports.severity import judged, ordered

    ranked = [each.text for each in ordered([judged("", note, "") for note in dict.fromkeys(notes)])]
    for note in ranked[:MOST_NOTES]:
        progress.say(f"note: {shorten(note, NOTE_LETTERS, placeholder=' ...')}")
    if len(ranked) > MOST_NOTES:
        progress.say(f"and {len(ranked) - MOST_NOTES} more notes: {result.parent / 'report.html'}")


def warning_texts(content: Json) -> list[str]:
    """The texts of ``warnings`` and of what is not separable."""
    found = [item["text"] if isinstance(item, Mapping) else str(item) for item in content.get("warnings") or []]
    return [*found, *(str(item) for item in content.get("not_separable") or [])]


def fit_text(content: Json, shown: ShownUnits = METRIC) -> str:
    """Spring rate, damper rate and free angle of each joint with their 90 % intervals, and what is left."""
    columns = (("k", "spring_rate", "N*m/rad"), ("b", "damper_rate", "N*m*s/rad"), ("free angle", "free_angle", "rad"))
    heads = [cell for name, _, si in columns for cell in (f"{name} [{shown.unit(si)}]", "90 %")]
    rows = [["joint", *heads, "RMS [deg]"]]
    for name, joint in content["joints"].items():
        given = [(joint.get(key), si) for _, key, si in columns]
        cells = [cell for item, si in given for cell in _estimate(shown.of(item, si) if item else None)]
        rows.append([name, *cells, _number(content["rms"].get(name))])
    count = len(warning_texts(content))
    return f"{table_text(rows)}\n{count} warning{'' if count == 1 else 's'}"


def gap_text(content: Json) -> str:
    """The likeliest causes with their probability and by how much each alone shrinks the gap."""
    rows = [["cause", "joint", "probability", "shrinks the gap by"]]
    for entry in content["ranked"][:MOST_CAUSES]:
        shrink = entry["shrink"]["value"] if entry.get("shrink") else None
        shown = "-" if shrink is None else f"{shrink:.0%}"
        rows.append([entry["effect"].replace("_", " "), entry["joint"], f"{entry['probability']:.0%}", shown])
    rows.append(["nothing is missing", "", f"{content['probability_none']:.0%}", "-"])
    rows.append(["not in the library", "", f"{content['probability_unknown']:.0%}", "-"])
    return f"verdict: {content['verdict']}\n{table_text(rows)}{_remainder_text(content.get('remainder'))}"


def _remainder_text(left: Json | None) -> str:
    """What stays unexplained, in a line."""
    if not left:
        return ""
    where = [max(each, key=lambda name: each[name]) for each in left["where"].values() if each]
    return (
        f"\nunexplained: {left['rms']['value']:.2g} {left['rms']['unit']}, {left['share']:.0%} of the gap, "
        f"{left['times_noise']:.2g} times the noise; most at: {', '.join(where)}"
    )


def hopper_text(content: Json) -> str:
    """Motor, ratio and length of the chosen leg, how high it jumps, and the interval."""
    best = content.get("best")
    if not best:
        return f"none of the {content['counts']['designs']} designs leaves the ground"
    clearance = best["clearance"]
    low, high = clearance.get("interval90") or (None, None)
    between = "" if low is None or high is None else f"{100 * low:.2f} to {100 * high:.2f}"
    heads = ["motor", "ratio", "upper link [mm]", "height [cm]", "90 %", "relative height"]
    row = [
        best["motor"],
        f"{best['gear_ratio']:g}",
        f"{1e3 * best['leg_length']['value']:.4g}",
        f"{100 * clearance['value']:.2f}",
        between,
        f"{best['relative_height']['value']:.3f}",
    ]
    return table_text([heads, row])


def offered(alternative: Json, wanted: float | None) -> bool:
    """Whether a spring's rate (of all the joint's springs together) is near enough to the wanted one to be named."""
    rate = alternative.get("rate")
    return rate is None or not wanted or wanted / OFFERED <= rate["value"] <= wanted * OFFERED


def _estimate(quantity: Json | None) -> tuple[str, str]:
    """A value and its 90 % interval, with the decimals that bear two digits of its half width."""
    if not quantity:
        return "curve", ""
    low, high = quantity.get("interval90") or (None, None)
    if low is None or high is None or not high > low:
        return _number(quantity), ""
    decimals = max(0, min(6, 1 - math.floor(math.log10((high - low) / 2))))
    return f"{quantity['value']:.{decimals}f}", f"{low:.{decimals}f} to {high:.{decimals}f}"


def _number(quantity: Json | None) -> str:
    return "-" if not quantity else f"{quantity['value']:.3g}"
