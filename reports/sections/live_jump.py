"""Data for the jumping leg's page: the animated jump, and every design for the pointer on the map."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from markupsafe import Markup

from synth.reports.figures.axes import with_margin
from synth.reports.figures.palette import BLUE, Line
from synth.reports.figures.trials import AxisRanges, Curve, TrialPanel, trial_figure
from synth.reports.reading import Json, Result, read_lines, value_of
from synth.reports.section import mapping, sequence
from synth.reports.sections.hopper_choice import shown_height

JUMP, DESIGNS = "jump.csv", "designs.csv"
MOST_DESIGNS = 6000  # that the page holds; of more, the map of the chosen family stands alone
MOST_POSES = 400  # of the jump in the page: its size grows with each
_NUMBERS = ("clearance [m]", "clearance_low [m]", "clearance_high [m]", "relative_height", "total_height [m]",
            "energy [J]", "peak_gear_torque [N*m]", "peak_current [A]")  # fmt: skip
_CURVES = (("hip height", "m"), ("foot height", "m"), ("ground force", "N"), ("gear torque", "N*m"), ("current", "A"),
           ("centre of mass speed", "m/s"))  # fmt: skip


def jump_data(result: Result) -> Json | None:
    """Lengths (m) and the poses over time; None if the folder has no jump."""
    table = result.table(JUMP)
    leg = mapping(result.content, "best", "leg")
    if table is None or not leg:
        return None
    columns = table.columns
    every = max(1, math.ceil(len(columns["time"]) / MOST_POSES))
    names = ("time", "hip height", "upper link angle", "upper link end angle", "lower link angle")
    if any(name not in columns for name in names):
        return None
    split = any(abs(a - b) > 1e-9 for a, b in zip(columns[names[2]], columns[names[3]], strict=True))
    return {
        "spacing": (value_of(leg.get("hip_spacing")) or 0.0) * 1e-3,
        "upper": (value_of(leg.get("upper_link")) or 0.0) * 1e-3,
        "lower": (value_of(leg.get("lower_link")) or 0.0) * 1e-3,
        "split": split,
        "takeoff": value_of(mapping(result.content, "best").get("takeoff_time")),
        "poses": [[_short(columns[name][k]) for name in names] for k in range(0, len(columns["time"]), every)],
    }


def designs_data(result: Result) -> Json | None:
    """Every design of the sweep by motor, ratio and length; None if there are none, or too many for a page.

    ``shown`` : the height that the study is about; ``relative`` : the one that its relative heights are made of.
    ``chosen`` : motor and length of the chosen design, None each without one.
    """
    path = result.path(DESIGNS)
    if path is None:
        return None
    found: list[list[Any]] = []
    for row in read_lines(path):
        if len(found) == MOST_DESIGNS:
            return None
        try:
            numbers = [_short(float(row[name])) if row.get(name) else None for name in _NUMBERS]
            place = [row["motor"], float(row["gear_ratio"]), _short(float(row["leg_length [m]"]))]
        except (KeyError, ValueError):
            return None
        found.append([*place, *numbers, row.get("feasible") == "yes", row.get("limit") or ""])
    best = mapping(result.content, "best")
    chosen = [best.get("motor"), value_of(best.get("leg_length"))]
    front = [
        [item.get("motor"), value_of(item.get("leg_length"))]
        for item in sequence(result.content, "pareto")
        if isinstance(item, Mapping)
    ]
    relative = "total height" if mapping(result.content, "settings").get("height") == "total" else "clearance"
    shown = shown_height(result.content).replace("_", " ")
    return {"designs": found, "chosen": chosen, "front": front, "shown": shown, "relative": relative} if found else None


def jump_curves(result: Result) -> Markup:
    """Heights, forces, torque and current over time, as plots that share the page's cursor."""
    table = result.table(JUMP)
    if table is None:
        return Markup("")
    times, panels, limits = table.columns["time"], [], {}
    for name, unit in _CURVES:
        if name in table.columns:
            values = table.columns[name]
            panels.append(TrialPanel(name, unit, times, [Curve(values, Line(BLUE, 1.6), name)], "", ""))
            limits[name] = with_margin([*values, 0.0])
    return trial_figure("the jump", panels, AxisRanges((times[0], times[-1]), limits), "jump")


def _short(value: float) -> float | None:
    return float(f"{value:.5g}") if math.isfinite(value) else None
