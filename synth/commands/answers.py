"""Terminal output of a finished command: the result as a table and at most five notes, one line each.

Everything is read from the written result file. The screen, ``--json`` and the page therefore show
the same numbers.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from textwrap import shorten
from typing import TYPE_CHECKING, Any

from synth.commands.table_text import table_text
from synth.estimation.estimate_words import estimate_words
from synth.files.shown_units import METRIC, ShownUnits
from synth.remarks import SEVERITIES, read_remark, severity_of
from synth.units import significant

if TYPE_CHECKING:
    from synth.commands.progress import Progress

Json = Mapping[str, Any]

MOST_NOTES = 5  # on the screen; the report has all
NOTE_LETTERS = 150  # of a note on the screen; the page has the full text
LARGEST_AT_NOISE = 0.5  # noise floors, of a gap's remainder: as on the page
MOST_CAUSES = 5  # on the screen: a glance, with those that the sentence names; the report has all
ANY_SHARE = [-1.0, 1.0]  # interval of a share of which the trials tell nothing, see ``PredictionErrors.shrink``
OFFERED = 4.0  # largest ratio to the wanted rate; a spring farther off would change the leg whatever its response


def tell(progress: Progress, result: Path, text: Callable[[Json], str], notes: Sequence[str] | None = None) -> None:
    """Print the result as a table, or as JSON with ``--json``; then the most important notes.

    Parameters
    ----------
    result
        the JSON file that the command wrote; without ``notes`` its warnings are the notes.
    text
        makes the table from the file's content.
    """
    written = result.read_text(encoding="utf-8")
    content = json.loads(written)
    if progress.as_json:
        progress.document(written)
    else:
        progress.result(text(content))
    tell_notes(progress, notes if notes is not None else warning_texts(content), result)


def tell_document(progress: Progress, content: Json, text: str) -> None:
    """Print a result without a file: its table, or with ``--json`` its content; ``text`` may be empty."""
    from synth.files.text_forms import json_text, plain

    if progress.as_json:
        progress.document(json_text(plain(content, ""), 0))
    elif text:
        progress.result(text)


def tell_notes(progress: Progress, notes: Sequence[str], result: Path) -> None:
    """At most five notes, those that could change a decision first; then the number of the others and their file."""
    if not notes:
        return
    ranked = sorted(dict.fromkeys(notes), key=lambda note: SEVERITIES.index(severity_of(note)))
    for note in ranked[:MOST_NOTES]:
        progress.say(f"note: {shorten(note, NOTE_LETTERS, placeholder=' ...')}")
    if len(ranked) > MOST_NOTES:
        progress.say(f"and {len(ranked) - MOST_NOTES} more notes: {result.parent / 'report.html'}")


def warning_texts(content: Json) -> list[str]:
    """The texts of ``warnings``, with their severity, and of ``not_separable``."""
    found = [read_remark(item) for item in content.get("remarks") or content.get("warnings") or []]
    return [*found, *(str(item) for item in content.get("not_separable") or [])]


def fit_text(content: Json, shown: ShownUnits = METRIC) -> str:
    """Spring rate, damper rate and free angle of each joint with 90 % intervals, and the residual."""
    from synth.reports.quantities import is_any_angle

    columns = (("k", "spring_rate", "N*m/rad"), ("b", "damper_rate", "N*m*s/rad"), ("free angle", "free_angle", "rad"))
    heads = [cell for name, _, si in columns for cell in (f"{name} [{shown.unit(si)}]", "90 %")]
    rows = [["joint", *heads, "RMS [deg]"]]
    for name, joint in content["joints"].items():
        given = [(joint.get(key), si) for _, key, si in columns]
        cells = [
            cell
            for item, si in given
            for cell in (("unknown", "") if is_any_angle(item) else _estimate(shown.of(item, si) if item else None))
        ]
        if (joint.get("damper") or {}).get("law") == "none":  # a joint that is locked in every trial
            cells[2] = "none"
        rows.append([name, *cells, _number(content["rms"].get(name))])
    count = len(warning_texts(content))
    return f"{table_text(rows)}\n{_law_text(content)}{count} warning{'' if count == 1 else 's'}"


def _law_text(content: Json) -> str:
    """The law beside springs and linear dampers, a line; empty without one."""
    law = content.get("law")
    if not law:
        return ""
    key = next(key for key in ("torque", "coefficient", "stiffening") if key in law)
    sizes = [f"{name} {_number(size)} {size['unit']}" for name, size in law[key].items()]
    return f"{law['effect'].replace('_', ' ')}: {', '.join(sizes)}\n"


def folder_text(columns: Mapping[str, Sequence[Any]]) -> str:
    """A folder's summary table for the screen: without interval ends, messages and empty columns."""
    shown = {
        head: column
        for head, column in columns.items()
        if head != "message" and not re.search(r" (low|high) \[", head) and any(cell is not None for cell in column)
    }
    rows = zip(*shown.values(), strict=True)
    return table_text([list(shown), *([_cell(cell) for cell in row] for row in rows)])


def _cell(value: object) -> str:
    if value is None:
        return "-"
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def gap_text(content: Json) -> str:
    """The causes that count: probability, and by how much each alone reduces the gap."""
    from synth.reports.openings.gap_opening import listed_causes

    rows = [["cause", "joint", "probability", "reduces the gap by"]]
    listed = listed_causes(dict(content), MOST_CAUSES)
    for entry in listed:
        row = [entry["effect"].replace("_", " "), entry["joint"], _chance(entry["probability"])]
        rows.append([*row, _reduction(entry.get("shrink"))])
    others = 1.0 - content["probability_none"] - content["probability_unknown"]
    others -= sum(entry["probability"] for entry in listed)
    if len(content["explanation"]) < 2 and others >= 0.005:  # those of causes that act together do not add up to 1
        rows.append(["all others", "", _chance(others), "-"])
    rows.append([_words_of_none(content), "", _chance(content["probability_none"]), "-"])
    rows.append(["not in the library", "", _chance(content["probability_unknown"]), "-"])
    return f"verdict: {content['verdict']}\n{table_text(rows)}{_remainder_text(content)}"


def _reduction(shrink: Json | None) -> str:
    """The share in whole per cent; of a gap at the noise, of which the trials allow any share, that it is not known."""
    if not shrink:
        return "-"
    if shrink["value"] == 0.0 and shrink.get("interval90") == ANY_SHARE:
        return "unknown"
    return f"{round(shrink['value'], 2) + 0.0:.0%}"  # no -0%


def _words_of_none(content: Json) -> str:
    """What has the probability ``probability_none``, as on the page."""
    if content.get("within_accuracy"):
        return "below the required accuracy"
    far = content["verdict"] == "none" and (content.get("remainder") or {}).get("times_noise", 0.0) > LARGEST_AT_NOISE
    return "the design as it is" if far else "no missing effect"


def _chance(probability: float) -> str:
    """In whole per cent; a small value is not shown as 0."""
    return "under 1%" if probability < 0.005 else f"{probability:.0%}"  # below it would round to 0 %


def _remainder_text(content: Json) -> str:
    """The unexplained remainder in one line; a driven leg has no phases of a release."""
    left = content.get("remainder")
    if not left:
        return ""
    driven = any("driven_by" in trial for trial in content.get("trials", []))
    shares = [each for key, each in left["where"].items() if each and not (driven and key == "phase")]
    where = [max(each, key=lambda name: each[name]) for each in shares]
    most_at = f"; most at: {', '.join(where)}" if where and left["rms"]["value"] > 0.0 else ""
    return (
        f"\nunexplained: {significant(left['rms']['value'], 2)} {left['rms']['unit']}, {left['share']:.0%} of the gap, "
        f"{significant(left['times_noise'], 2)} times the noise{most_at}"
    )


def hopper_text(content: Json) -> str:
    """Motor, ratio and length of the chosen leg; the height that it is chosen by, with interval."""
    best = content.get("best")
    if not best:
        return str(content["none_because"])
    settings = content["settings"]
    means_total = settings["height"] == "total"
    total = settings["choose"] == "total_height" or (means_total and settings["choose"] != "clearance")
    height = best["total_height" if total else "clearance"]
    ends = height.get("interval90")
    shown, between = _estimate(
        {"value": 100 * height["value"], "interval90": [100 * end for end in ends] if ends else None}
    )
    heads = ["motor", "ratio", "upper link [mm]", f"{'total height' if total else 'clearance'} [cm]", "90 %"]
    heads.append(f"{'total height' if means_total else 'clearance'} / link")
    row = [
        best["motor"],
        f"{best['gear_ratio']:g}",
        f"{1e3 * best['leg_length']['value']:.4g}",
        shown,
        between,
        f"{best['relative_height']['value']:.3f}",
    ]
    return table_text([heads, row])


def is_near_enough(alternative: Json, wanted: float | None) -> bool:
    """Whether the total spring rate of the joint is close enough to the wanted rate to be offered."""
    rate = alternative.get("rate")
    return rate is None or not wanted or wanted / OFFERED <= rate["value"] <= wanted * OFFERED


def _estimate(quantity: Json | None) -> tuple[str, str]:
    """A value and its 90 % interval, in as many digits as the interval justifies."""
    if not quantity:
        return "curve", ""
    low, high = quantity.get("interval90") or (None, None)
    if low is None or high is None or not high > low:
        return _number(quantity), ""
    return estimate_words(quantity["value"], low, high)


def _number(quantity: Json | None) -> str:
    return "-" if not quantity else significant(quantity["value"], 3)
