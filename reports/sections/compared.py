"""The comparison: motions from the same start, the table, differences between sides, and origins."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import PurePosixPath
from typing import Any

from markupsafe import Markup

from synth.reports.figures.interval_bars import IntervalRow, interval_figure
from synth.reports.figures.legend import legend
from synth.reports.figures.palette import MODEL_SIDES, RECORDED_SIDES, Line
from synth.reports.figures.trials import Curve, TrialPanel, shared_limits, trial_figure
from synth.reports.quantities import brief, interval_of, number, text, unit_text
from synth.reports.reading import Json, Result, value_of
from synth.reports.response_files import Response, read_response
from synth.reports.section import AbsentResult, FirstFigure, ReportSection, mapping, records, sequence
from synth.reports.stick_figure import figure_of_trial

FOLDER = "responses"
ROWS = (
    ("spring_rate", "spring rate"), ("damper_rate", "damper rate"), ("damper_law", "damper's law"),
    ("free_angle", "free angle"), ("spring_part", "spring"), ("damper_part", "damper"),
)  # fmt: skip
CHARACTERISTICS_SHOWN = (
    ("rise_time", "rise time 10–90 %"), ("damping_ratio", "damping ratio"), ("damped_frequency", "damped frequency"),
    ("overshoot", "overshoot"), ("settling_time", "settling time"),
)  # fmt: skip
ALONE = (("natural_frequency", "natural frequency, joint alone"), ("damping_ratio", "damping ratio, joint alone"))


def sides_of(document: Json) -> list[Json]:
    """The sides that are well formed."""
    return records(document, "sides")


def is_family(document: Json) -> bool:
    """Whether its sides move at several time scales."""
    return any((value_of(side.get("pace")) or 1.0) != 1.0 for side in sides_of(document))


def clock_of(document: Json) -> str:
    """What the time of the overlaid motions is."""
    return "time / time scale" if is_family(document) else "time"


def lines_of(document: Json) -> dict[str, Line]:
    """A line per side: recordings dotted, simulated legs each with a dash of its own."""
    found: dict[str, Line] = {}
    counts = {"recorded": 0, "model": 0}
    for side in sides_of(document):
        kind = "recorded" if side.get("kind") == "recorded" else "model"
        choice = RECORDED_SIDES if kind == "recorded" else MODEL_SIDES
        found[str(side.get("name"))] = choice[counts[kind] % len(choice)]
        counts[kind] += 1
    return found


def responses(result: Result) -> dict[str, Any] | AbsentResult:
    """Every start's motions overlaid."""
    read = _read_responses(result)
    if not read:
        return AbsentResult(f"there is no file in {FOLDER}")
    lines = lines_of(result.content)
    panels = {name: _panels(result.content, response, lines) for name, response in read.items()}
    limits = shared_limits([panel for found in panels.values() for panel in found])
    starts = {str(start.get("name")): start for start in sequence(result.content, "starts")}
    return {
        "family": is_family(result.content),
        "legend": legend(_drawn_sides(lines, [panel for found in panels.values() for panel in found])),
        "figures": [
            {
                "name": name,
                "svg": trial_figure(f"{name}: motions from the same start", found, limits, name),
                "notes": _notes(starts, name),
            }
            for name, found in panels.items()
        ],
        "folder": FOLDER,
    }


def telling_figure(result: Result) -> FirstFigure | None:
    """The start from which the sides differ most, with the leg that follows the cursor."""
    read, lines = _read_responses(result), lines_of(result.content)
    if not read:
        return None
    reference = str(result.content.get("reference"))
    name = max(read, key=lambda key: _largest_distance(read[key], reference, lines))
    panels = _panels(result.content, read[name], lines)
    drawn = trial_figure(f"{name}: motions from the same start", panels, shared_limits(panels), f"first-{name}")
    stick = figure_of_trial(result, f"first-{name}", read[name].table, reference)
    many = f"the start, of {len(read)}, from which the sides differ most" if len(read) > 1 else "the common start"
    key = legend(_drawn_sides(lines, panels))
    return FirstFigure(key + drawn, f"{name}: {many}.", stick)


def _read_responses(result: Result) -> dict[str, Response]:
    found = {}
    for file in result.files(FOLDER):
        response = read_response(result, file)
        if response is not None:
            found[PurePosixPath(file).stem] = response
    return found


def _largest_distance(response: Response, reference: str, lines: Mapping[str, Line]) -> float:
    """Largest RMS of a side off the reference over all joints."""
    found = [
        value
        for name in lines
        for joint in response.joints(reference)
        if (value := response.rms(joint, reference, name)) is not None
    ]
    return max(found, default=-1.0)


def _panels(document: Json, response: Response, lines: Mapping[str, Line]) -> list[TrialPanel]:
    times, clock = response.table.columns.get("time", []), clock_of(document)
    panels = []
    for joint in (str(name) for name in sequence(document, "joints")):
        curves = [
            Curve(response.table.columns[f"{joint} {name}"], line, name)
            for name, line in lines.items()
            if any(map(math.isfinite, response.table.columns.get(f"{joint} {name}", [])))
        ]
        if len(times) > 1 and curves:
            panels.append(TrialPanel(joint, "deg", times, curves, "", clock=clock))
    return panels


def _drawn_sides(lines: Mapping[str, Line], panels: Sequence[TrialPanel]) -> list[tuple[Line, str]]:
    """The sides that have a curve; one that shares no start with the others has none."""
    names = {curve.name for panel in panels for curve in panel.curves}
    return [(line, name) for name, line in lines.items() if name in names]


def _notes(starts: Mapping[str, Any], name: str) -> list[str]:
    """Which recordings stand in a picture, and who is missing."""
    start = next((found for key, found in starts.items() if PurePosixPath(key).stem == name), None)
    if start is None:
        return []
    notes = []
    for side, seen in mapping(start, "recordings").items():
        away = value_of(mapping(seen).get("starts_away")) or 0.0
        words = f", which starts {number(away, 2)}° from it" if away > 0 else ""
        notes.append(f"{side}: {mapping(seen).get('file')}{words}")
    notes += [f"{side} is left out: {why}" for side, why in mapping(start, "left_out").items()]
    locked = [str(joint) for joint in sequence(start, "locked")]
    return [*notes, *([f"held: {', '.join(locked)}"] if locked else [])]


def parameters(result: Result) -> dict[str, Any] | AbsentResult:
    """One table a joint, a column a side; and rates over the reference's."""
    sides = sides_of(result.content)
    joints = [str(name) for name in sequence(result.content, "joints")]
    tables = []
    for joint in joints:
        rows = [("overlaid", [(overlaid_in(side), "") for side in sides])]
        rows += [(words, [_cell(mapping(side, "joints", joint).get(key)) for side in sides]) for key, words in ROWS]
        rows += [(words, [_cell(mapping(side, "alone", joint).get(key)) for side in sides]) for key, words in ALONE]
        rows += [
            (words, [_spread(mapping(side, "characteristics", joint).get(key)) for side in sides])
            for key, words in CHARACTERISTICS_SHOWN
        ]
        off = [mapping(side, "off_reference", "rms").get(joint) for side in sides]
        bases = [str(mapping(side, "off_reference").get("basis") or "") for side in sides]
        rows.append(
            (
                "RMS from the reference",
                [(brief(one), basis) if one else ("–", "") for one, basis in zip(off, bases, strict=True)],
            )
        )
        tables.append(
            {"joint": joint, "rows": [(words, cells) for words, cells in rows if any(a != "–" for a, _ in cells)]}
        )
    if not tables:
        return AbsentResult("compare.json names no joint")
    names = [str(side.get("name")) for side in sides]
    return {
        "tables": tables,
        "names": names,
        "reference": result.content.get("reference"),
        "ratios": _ratios(result.content),
    }


def overlaid_in(side: Json) -> str:
    """The time in which a side's motion is overlaid, unless that is its own."""
    pace, slowed = (value_of(side.get(key)) or 1.0 for key in ("pace", "slowed"))
    words = [f"in its time / {number(pace)}"] * (pace != 1.0) + [f"slowed {number(slowed)} times"] * (slowed != 1.0)
    return ", ".join(words) or "–"


def _cell(item: object) -> tuple[str, str]:
    """What counts, and its interval."""
    if isinstance(item, str):
        return item, ""
    if not isinstance(item, Mapping):
        return "–", ""
    ends = interval_of(item)
    shown = f"{number(ends[0])} to {number(ends[1])}" if ends and None not in ends else ""
    return text(item), shown


def _spread(item: object) -> tuple[str, str]:
    """A median, and between which ends of how many motions."""
    if not isinstance(item, Mapping):
        return "–", ""
    count = item.get("motions")
    if not isinstance(count, int) or count < 2:
        return brief(item), ""
    unit = unit_text(str(item.get("unit")))
    return brief(item), f"{number(item.get('least'), 3)} to {number(item.get('most'), 3)} {unit} of {count}"


def _ratios(document: Json) -> Markup:
    """Every side's rates over those of the first side that has them, on one axis."""
    sides = sides_of(document)
    rows: list[IntervalRow] = []
    for joint in (str(name) for name in sequence(document, "joints")):
        for key, words in ROWS[:2]:
            known = [(index, side, mapping(side, "joints", joint).get(key)) for index, side in enumerate(sides)]
            values = [(index, side, item, value) for index, side, item in known if (value := value_of(item))]
            if len(values) < 2:
                continue
            base = values[0][3]
            for place, (index, side, item, value) in enumerate(values):
                low, high = interval_of(item) or (value, value)
                rows.append(IntervalRow(
                    f"{joint} {words}, {side.get('name')}", index, value / base,
                    None if low is None else low / base, None if high is None else high / base, place == 0,
                ))  # fmt: skip
    if not rows:
        return Markup("")
    return interval_figure("rates of every side over the first one's", "over the first side's", rows)


def differences(result: Result) -> dict[str, Any] | AbsentResult:
    """Differences between the sides, and the figures that each result states."""
    sides = sides_of(result.content)
    names = [str(side.get("name")) for side in sides]
    found = {
        (str(item.get("from")), str(item.get("of"))): item
        for item in sequence(result.content, "differences")
        if isinstance(item, Mapping)
    }
    rows = []
    for name in names:
        cells = []
        for other in names:
            item = found.get((name, other)) or found.get((other, name))
            overall = mapping(item).get("overall")
            cells.append((brief(overall), str(mapping(item).get("basis"))) if overall else ("", ""))
        rows.append((name, cells))
    stated = [(side.get("name"), str(mapping(item).get("what")), _cell(mapping(item).get("value")))
              for side in sides for item in sequence(side, "stated")]  # fmt: skip
    if not any(cell[0] for _, cells in rows for cell in cells) and not stated:
        return AbsentResult("no two sides share a start")
    return {"names": names, "rows": rows, "stated": stated}


def origins(result: Result) -> dict[str, Any] | AbsentResult:
    """The origin of each side, and the files' hashes."""
    return {
        "sides": sides_of(result.content),
        "inputs": mapping(result.content, "inputs"),
        "starts_of": result.content.get("starts_of"),
    }


RESPONSES = ReportSection("compared-responses", "Motion from the same start", responses)
PARAMETERS = ReportSection("compared-parameters", "Side by side, joint by joint", parameters)
DIFFERENCES = ReportSection("compared-differences", "Differences between sides", differences)
ORIGINS = ReportSection("compared-origins", "Origin of each side", origins)
