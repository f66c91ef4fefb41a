"""Exchange and tuning of parts in the page: plots that its script updates, and their content without it."""

from __future__ import annotations

import math
from typing import Any

from synth.reports.figures.legend import legend
from synth.reports.figures.palette import BUILT, GREEN, WANTED, Line
from synth.reports.figures.trials import AxisRanges, Curve, TrialPanel, trial_figure
from synth.reports.reading import Json, Result
from synth.reports.section import AbsentResult, ReportSection, sequence
from synth.reports.sections.live_leg import live_data

TRIED = Line(GREEN, 2.0, "2 3")
ROOM = 0.15  # of a joint's range of wanted angles, margin above and below for the motion with a worse part


def content(result: Result) -> dict[str, Any] | AbsentResult:
    """Panels of the first release: the wanted motion; the script adds those with chosen and tried parts."""
    page = live_data(result)
    if page is None:
        return AbsentResult("page.json is not in the folder")
    replay = page.get("replay") or {}
    unsupported = [str(name).replace("_", " ") for name in sequence(replay, "unsupported")]
    if unsupported:
        return AbsentResult(f"the leg has {', '.join(unsupported)}: the page's own integrator does not support it")
    releases = [release for release in sequence(replay, "releases") if isinstance(release, dict)]
    joints = [str(joint.get("name")) for joint in sequence(page, "leg", "joints")]
    if not releases or not joints:
        return AbsentResult("page.json holds no release")
    limits = _limits(joints, releases)
    panels = [_panel(name, releases[0], j) for j, name in enumerate(joints)]
    entries = [(WANTED, "wanted"), (BUILT, "chosen"), (TRIED, "tried")]
    return {
        "legend": legend(entries),
        "figure": trial_figure("wanted, chosen and tried", panels, limits, "swapped"),
        "joints": joints,
        "releases": [str(release.get("name")) for release in releases],
        "total": replay.get("of"),
    }


def _limits(joints: list[str], releases: list[Json]) -> AxisRanges:
    end = max(float(release["time"][-1]) for release in releases)
    angle = {}
    for j, name in enumerate(joints):
        values = [float(value) for release in releases for value in release["wanted"][j]]
        low, high = min(values), max(values)
        room = ROOM * max(high - low, 4.0)
        angle[name] = (low - room, high + room)
    return AxisRanges((0.0, end), angle)


def _panel(name: str, release: Json, j: int) -> TrialPanel:
    times = [float(time) for time in release["time"]]
    nothing = [math.nan] * len(times)
    curves = [
        Curve([float(value) for value in release["wanted"][j]], WANTED, "wanted"),
        Curve(nothing, BUILT, "chosen"),
        Curve(nothing, TRIED, "tried"),
    ]
    return TrialPanel(name, "deg", times, curves, "")


SECTION = ReportSection("swap", "Swap and tune parts", content)
