"""Where the gap lies: shares, the torque that the nominal leg lacks, and the error over time."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from markupsafe import Markup

from synth.reports.figures.bars import Bar, BarColumn, bar_figure
from synth.reports.figures.legend import legend
from synth.reports.figures.missing_torque import FREE, NAMED, Cloud, missing_torque_figure
from synth.reports.figures.named_laws import law_of
from synth.reports.figures.palette import AFTER, BEFORE, FLOOR
from synth.reports.figures.trials import AxisRanges, Curve, TrialPanel, trial_figure
from synth.reports.quantities import in_si, number, unit_text
from synth.reports.reading import Json, Result, ResultTable
from synth.reports.section import AbsentResult, ReportSection, mapping, sequence

# Key of ``where`` -> heading, and the label of its bins.
SHARES = {
    "joint": ("by joint", "{}"),
    "phase": ("by phase", "{}"),
    "speed": ("by speed", "{} third"),
    "position": ("by deflection", "{} third"),
    "load": ("by load", "{} third"),
    "time": ("by time", "{} third"),
}
_TIMES = {"low": "first", "middle": "middle", "high": "last"}
PANEL, LABEL = 300.0, 104.0  # px
MOST_TIMES = 60  # points a time plot
ENDING = " missing torque"
DEFLECTION = "deflection from the free angle"  # the words for the column


def content(result: Result, deflection: str = DEFLECTION, without: Sequence[str] = ()) -> dict[str, Any] | AbsentResult:
    """Shares as bars; missing torque and error over time by joint.

    ``deflection`` : the label of that axis; ``without`` : phases that this motion does not have.
    """
    where = mapping(result.content, "where")
    if not where:
        return AbsentResult(f"{result.name} does not say where the gap lies")
    phases = {name: share for name, share in mapping(where, "phase").items() if name not in without}
    where = {**where, "phase": phases}
    tables = _tables(result)
    joints = _joints(tables)
    return {
        "shares": [figure for key in SHARES if (figure := _share(key, mapping(where, key))) is not None],
        "named": _legend(result, joints),
        "free": [_free_text({**item}) for item in sequence(result.content, "free_torque") if isinstance(item, Mapping)],
        "torques": [figure for joint in joints if (figure := _torque(result, joint, tables, deflection)) is not None],
        "errors": _errors(result, joints),
        "legend": legend([(BEFORE, "nominal at its best"), (AFTER, "with the explanation"), (FLOOR, "noise")]),
        "trials": len(tables),
        "scored": sum(bool(trial.get("scored")) for trial in sequence(result.content, "trials")),
    }


def _legend(result: Result, joints: list[str]) -> Markup | str:
    """The legend of the laws that the figures of the missing torque hold."""
    columns = ("speed", "deflection")
    drawn = []
    if any(_named_torque(result, joint, column) for joint in joints for column in columns):
        drawn.append((NAMED, "law of the named effect"))
    if any(_free(result, joint, column) for joint in joints for column in columns):
        drawn.append((FREE, "free-form torque, a curve for each direction of motion"))
    return legend(drawn) if drawn else ""


def _free(result: Result, joint: str, column: str) -> list[list[tuple[float, float]]]:
    """The free torque at the joint over this column, which is in degrees: a curve for each direction of motion."""
    for item in sequence(result.content, "free_torque"):
        if isinstance(item, Mapping) and item.get("joint") == joint and item.get("over") == column:
            curve = mapping(item, "curve")
            places, torques = (sequence(mapping(curve, name), "value") for name in ("place", "torque"))
            rows = list(zip(places, sequence(curve, "direction"), torques, strict=True))
            return [
                [(math.degrees(place), torque) for place, way, torque in rows if way == direction]
                for direction in sorted({way for _, way, _ in rows})
            ]
    return []


def _free_text(item: Json) -> str:
    """``at the knee, over speed: removes 41 %`` of the error on held-out trials."""
    taken = in_si(item.get("taken"))
    over = "deflection and direction" if item.get("over") == "deflection" else "speed"
    if taken is None or taken <= 0.0:
        return f"at the {item.get('joint')}, over {over}: removes nothing"
    return f"at the {item.get('joint')}, over {over}: removes {100 * taken:.0f} %"


def _tables(result: Result, *, scored: bool = False) -> list[ResultTable]:
    """The ``where`` tables of all trials, or of the scored ones."""
    found = []
    for trial in sequence(result.content, "trials"):
        if isinstance(trial, Mapping) and trial.get("where") and (trial.get("scored") or not scored):
            table = result.table(str(trial["where"]))
            found += [] if table is None else [table]
    return found


def _joints(tables: list[ResultTable]) -> list[str]:
    names = [name.removesuffix(ENDING) for table in tables for name in table.columns if name.endswith(ENDING)]
    return list(dict.fromkeys(names))


def _share(key: str, shares: Json) -> Markup | None:
    """Bars of one mapping of shares; the largest is highlighted."""
    values = {str(name): float(value) for name, value in shares.items() if isinstance(value, (int, float))}
    if not values:
        return None
    heading, words = SHARES[key]
    most = max(values.values())
    if key == "time":
        values = {_TIMES.get(name, name): value for name, value in values.items()}
    labels = [words.format(name) if len(name) < 8 else name for name in values]
    bars = [Bar(value, f"{100 * value:.0f} %", strong=value == most) for value in values.values()]
    title = f"Share of the gap {heading}"
    return bar_figure(title, labels, [BarColumn(f"share {heading}", bars, 1.0, words=40.0)], PANEL, LABEL)


def _torque(result: Result, joint: str, tables: list[ResultTable], deflection: str) -> Markup | None:
    """Missing torque against speed and against deflection, over all trials, and the named effect's own law."""
    clouds = []
    for column, words in (("speed", "speed"), ("deflection", deflection)):
        points, unit = [], ""
        for table in tables:
            torque, other = table.columns.get(joint + ENDING), table.columns.get(f"{joint} {column}")
            if torque is None or other is None:
                continue
            unit = unit_text(table.units.get(f"{joint} {column}", "")).replace("deg", "°")
            points += [(x, y) for x, y in zip(other, torque, strict=True) if math.isfinite(x) and math.isfinite(y)]
        if points:
            clouds.append(Cloud(joint, f"{words} [{unit}]", points, _named_torque(result, joint, column),
                                _free(result, joint, column)))  # fmt: skip
    return missing_torque_figure(f"{joint}: torque that the nominal leg lacks", clouds) if clouds else None


def _named_torque(result: Result, joint: str, column: str) -> Callable[[float], float] | None:
    """The sum of the accepted effects' laws at the joint against this column, which is in degrees."""
    laws = []
    for cause in sequence(result.content, "explanation"):
        if not isinstance(cause, Mapping) or cause.get("joint") != joint:
            continue
        numbers = {name: in_si(quantity) for name, quantity in mapping(cause, "parameters").items()}
        known = {name: value for name, value in numbers.items() if value is not None}
        if (law := law_of(str(cause.get("effect")), known, column)) is not None:
            laws.append(law)
    return (lambda x: sum(law(math.radians(x)) for law in laws)) if laws else None


def _errors(result: Result, joints: list[str]) -> Markup | None:
    """RMS error over the scored trials against time, a panel a joint, with the noise."""
    tables = _tables(result, scored=True)
    panels, limits = [], {}
    for joint in joints:
        times, before = error_over_time(tables, f"{joint} error before")
        _, after = error_over_time(tables, f"{joint} error after")
        if len(times) < 2:
            continue
        noise = in_si(mapping(result.content, "noise").get(joint))
        curves = [Curve(before, BEFORE, "nominal at its best"), Curve(after, AFTER, "with the explanation")]
        if noise is not None:
            curves.insert(0, Curve([math.degrees(noise)] * len(times), FLOOR, "noise"))
        remark = "" if noise is None else f"noise {number(math.degrees(noise), 2)}°"
        panels.append(TrialPanel(joint, "deg", times, curves, remark, "error"))
        highest = max(value for curve in curves for value in curve.values if math.isfinite(value))
        limits[joint] = (0.0, 1.08 * highest or 1.0)
    return trial_figure("Error over time", panels, AxisRanges(None, limits)) if panels else None


def error_over_time(tables: list[ResultTable], column: str) -> tuple[list[float], list[float]]:
    """Bins of time (s, their middles) and the RMS of a column of all tables in each; nan where none is known."""
    known = [
        (time, value)
        for table in tables
        for time, value in zip(table.columns.get("time", []), table.columns.get(column, []), strict=False)
        if math.isfinite(value)
    ]
    longest = max((time for time, _ in known), default=0.0)
    if not longest > 0:
        return [], []
    bins = min(MOST_TIMES, max(2, len(known) // 4))
    squares, counts = [0.0] * bins, [0] * bins
    for time, value in known:
        place = min(int(time / longest * bins), bins - 1)
        squares[place] += value**2
        counts[place] += 1
    middles = [(index + 0.5) * longest / bins for index in range(bins)]
    return middles, [math.sqrt(s / c) if c else math.nan for s, c in zip(squares, counts, strict=True)]


SECTION = ReportSection("where", "Where the gap lies", content)
