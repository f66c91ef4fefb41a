"""Torque against speed of each damper: measured law, competing laws, vendor's point and secant."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from typing import Any

from markupsafe import Markup

from synth.reports.figures.legend import legend
from synth.reports.figures.palette import OTHER_LAWS, SECANT, USED_LAW, Line
from synth.reports.figures.svg import Point
from synth.reports.figures.torque_speed import RPM, DrawnLaw, Vendor, law_points, torque_speed_figure
from synth.reports.quantities import factor, in_si
from synth.reports.reading import Json, Result
from synth.reports.section import AbsentResult, ReportSection, mapping, sequence


def content(result: Result) -> dict[str, Any] | AbsentResult:
    """A figure and a table of laws by joint."""
    joints, measured = mapping(result.content, "joints"), mapping(result.content, "damper_laws")
    names = list(dict.fromkeys([*joints, *measured]))
    shown = [
        found
        for name in names
        if (found := _joint(result, name, mapping(joints, name, "damper"), mapping(measured, name))) is not None
    ]
    return {"joints": shown} if shown else AbsentResult("design.json has no damper curve, law or vendor's point")


def _joint(result: Result, name: str, damper: Json, measured: Json) -> Json | None:
    file = damper.get("curve") or measured.get("curve")
    used = _curve(result, file)
    vendor = _vendor(damper)
    laws = [law for law in sequence(measured, "laws") if isinstance(law, Mapping)]
    span = _speed_range(measured)
    # A damper may have been measured and another be chosen: then the laws are not those of the one that acts.
    other = bool(measured.get("part")) and bool(damper.get("part")) and measured.get("part") != damper.get("part")
    known = [*(span or ()), *([vendor.speed] if vendor else [])]
    fastest = 1.25 * max(known) if known else max([x for x, _ in used or []], default=0.0)
    drawn: list[DrawnLaw] = []
    key: list[tuple[Line, str]] = []
    styles = itertools.cycle(OTHER_LAWS)
    rows = []
    for law in laws:
        in_use = bool(law.get("used")) and not other
        points = used if in_use and used else _law_points(result, law, fastest)
        if points:
            line = USED_LAW if in_use else next(styles)
            drawn.append(DrawnLaw(_until(points, fastest), line))
            name_shown = str(law.get("law")).replace("_", " ")
            name_shown += f" ({measured.get('part')})" if other else ""
            key.append((line, f"{name_shown}, used" if in_use else name_shown))
        rows.append({**law, "drawn": bool(points)})
    if used and (other or not any(law.get("used") for law in laws)):
        drawn.append(DrawnLaw(_until(used, fastest), USED_LAW))
        name_used = f"{damper.get('law', 'curve')} ({damper.get('part')})" if other else damper.get("law", "curve")
        key.append((USED_LAW, f"{name_used}, used"))
    if vendor:
        key.append((SECANT, "vendor's point and the secant through it"))
    if not drawn and vendor is None:
        return None
    drawn.sort(key=lambda law: law.line is USED_LAW)  # the one in use on top
    figure = torque_speed_figure(f"{name}: torque against speed", drawn, vendor, span)
    return {
        "name": name, "part": damper.get("part") or measured.get("part"), "figure": figure, "legend": legend(key),
        "laws": rows, "trials": [t for t in sequence(measured, "trials") if isinstance(t, Mapping)],
        "how": measured.get("how_held_out"), "speed_range": sequence(measured, "speed_range"), "damper": damper,
        "curve": file if used else None, "lost": file if file and not used else None,
        "measured": bool(measured), "other": measured.get("part") if other else None,
        "insert": _insert(name, drawn, span, vendor),
    }  # fmt: skip


def _insert(name: str, drawn: list[DrawnLaw], span: Point | None, vendor: Vendor | None) -> Markup | None:
    """The same laws over the measured speeds alone, where the vendor's point lies far beyond them."""
    # Nearer, the main drawing shows it well.
    if span is None or vendor is None or not drawn or vendor.speed < 1.8 * span[1]:
        return None
    end = 1.15 * span[1]
    cut = [DrawnLaw(_until(law.points, end), law.line) for law in drawn]
    point = Vendor(end, vendor.torque / vendor.speed * end)
    secant = DrawnLaw([(0.0, 0.0), (point.speed, point.torque)], SECANT)
    return torque_speed_figure(f"{name}: torque against speed, measured speeds", [secant, *cut], None, span)


def _until(points: Any, end: float) -> list[Point]:
    """Points up to a speed, the last one interpolated."""
    kept: list[Point] = []
    for before, after in itertools.pairwise([(0.0, math.nan), *points]):
        if end <= 0.0 or after[0] <= end:
            kept.append(after)
        elif before[0] < end and math.isfinite(before[1]):
            share = (end - before[0]) / (after[0] - before[0])
            kept.append((end, before[1] + share * (after[1] - before[1])))
    return kept


def _curve(result: Result, file: object) -> list[Point] | None:
    """(rpm, N m) of a torque-speed file from the origin; None if there is none."""
    table = result.table(file) if isinstance(file, str) else None
    if table is None or not {"speed", "torque"} <= set(table.columns):
        return None
    speed, torque = factor(table.units["speed"]), factor(table.units["torque"])
    if speed is None or torque is None:
        return None
    pairs = zip(table.columns["speed"], table.columns["torque"], strict=True)
    points = [(x * speed / RPM, y * torque) for x, y in pairs]
    return points if points and points[0] == (0.0, 0.0) else [(0.0, 0.0), *points]


def _law_points(result: Result, law: Mapping[str, Any], fastest: float) -> list[Point] | None:
    """A competing law: its own file where it has one, otherwise from its numbers."""
    if (points := _curve(result, law.get("curve"))) is not None:
        return points
    parameters = {name: in_si(quantity) for name, quantity in mapping(law, "parameters").items()}
    known = {name: value for name, value in parameters.items() if value is not None}
    return law_points(str(law.get("law")), known, fastest)


def _vendor(damper: Json) -> Vendor | None:
    point = mapping(damper, "vendor_point")
    speed, torque = in_si(point.get("speed")), in_si(point.get("torque"))
    return Vendor(speed / RPM, torque) if speed and torque else None


def _speed_range(measured: Json) -> Point | None:
    ends = [in_si(end) for end in sequence(measured, "speed_range")]
    if len(ends) != 2 or ends[0] is None or ends[1] is None:
        return None
    return ends[0] / RPM, ends[1] / RPM


SECTION = ReportSection("damper-curves", "Torque–speed curves of the dampers", content)
