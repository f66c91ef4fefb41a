"""The chosen leg's jump: poses, heights, forces, torque and current."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from synth.reports.figures.jump_drawing import Geometry, Pose, strip_figure
from synth.reports.reading import Result, value_of
from synth.reports.section import AbsentResult, ReportSection, mapping
from synth.reports.sections.live_jump import jump_curves

FILE = "jump.csv"
POSES = 9  # of the leg drawn over the jump


def content(result: Result) -> dict[str, Any] | AbsentResult:
    """A strip of poses and a curve a quantity."""
    table = result.table(FILE)
    best = mapping(result.content, "best")
    if table is None or not best:
        return AbsentResult(f"there is no {FILE}")
    times = table.columns["time"]
    takeoff = value_of(best.get("takeoff_time"))
    leg = mapping(best, "leg")

    def metres(name: str) -> float:
        return (value_of(leg.get(name)) or 0.0) * 1e-3

    split = any(
        abs(a - b) > 1e-9
        for a, b in zip(table.columns["upper link angle"], table.columns["upper link end angle"], strict=True)
    )
    geometry = Geometry(metres("hip_spacing"), metres("upper_link"), metres("lower_link"), split)
    # Half of the poses in the push, half in flight.
    ends = (0.0, min(takeoff or 0.0, times[-1]), times[-1])
    wanted = [ends[0] + (ends[1] - ends[0]) * i / (POSES // 2) for i in range(POSES // 2 + 1)]
    wanted += [ends[1] + (ends[2] - ends[1]) * i / (POSES // 2) for i in range(1, POSES // 2 + 1)]
    rows = [_nearest(times, time) for time in wanted]
    columns = [table.columns[name] for name in
               ("time", "hip height", "upper link angle", "upper link end angle", "lower link angle")]  # fmt: skip
    poses = [Pose(*(column[row] for column in columns)) for row in rows]
    return {
        "strip": strip_figure(geometry, poses),
        "curves": jump_curves(result),
        "takeoff": best.get("takeoff_time"),
        "table": FILE,
    }


def _nearest(times: Sequence[float], wanted: float) -> int:
    """Index of the time nearest to the one wanted."""
    distances = [abs(time - wanted) for time in times]
    return distances.index(min(distances))


SECTION = ReportSection("hopper-jump", "The jump", content)
