"""Imported motion as stick figures of the leg, which show a wrong sign, side or order of joints."""

from __future__ import annotations

import json
import math
from bisect import bisect_left
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import accumulate, pairwise
from pathlib import PurePosixPath
from typing import Any

from markupsafe import Markup

from synth.reports.figures.legend import legend
from synth.reports.figures.palette import BLACK, BLUE, GREEN, GREY, ORANGE, RULE, VERMILION, Line
from synth.reports.figures.svg import Point, Svg, shorten_apart
from synth.reports.figures.trials import Curve, TrialPanel, shared_limits, trial_figure
from synth.reports.reading import Json, Result, ResultTable, value_of
from synth.reports.scripts import data_block
from synth.reports.section import AbsentResult, ReportSection, mapping, sequence

MOST_TRIALS = 12  # trials that are drawn
SIZE = 430.0  # of a drawing, view box units
MARGIN = 46.0  # px
ROOM = 120.0  # px, width of a joint's label: a dozen letters of 12 px and the direction
GHOSTS = 7  # poses between the first and the last
START, END = Line(BLUE, 4.0), Line(VERMILION, 4.0, "9 4")
MEASURED, TOLD = Line(BLUE, 1.4), Line(VERMILION, 1.0)
# Beside plots whose legend has those colours for curves.
START_BESIDE, END_BESIDE = Line(GREY, 4.0), Line(GREY, 4.0, "9 4")
TIP_BESIDE = Line(GREY, 1.2, "1.5 2.5")
GHOST, TIP, TRACKED = Line("#b9c2cb", 1.6), Line(GREEN, 1.2), Line(ORANGE, 5.0, dots=True)
_DEGREES = {"deg": 1.0, "rad": 180.0 / math.pi}  # a unit


@dataclass(frozen=True)
class FigureJoint:
    """A joint of the drawn leg: angles in degrees, length in mm."""

    name: str
    zero: float
    sign: float
    length: float


@dataclass(frozen=True)
class Stick:
    """The leg, and the rotation of its base, degrees."""

    joints: tuple[FigureJoint, ...]
    tilt: float

    def pose(self, angles: Sequence[float]) -> list[Point]:
        """Positions of the joints and the tip (n + 1), mm, x right and z up, for measured angles (n,) in degrees."""
        absolute = self.tilt
        places = [(0.0, 0.0)]
        for joint, angle in zip(self.joints, angles, strict=True):
            absolute += joint.sign * (angle - joint.zero)
            x, z = places[-1]
            turn = math.radians(absolute)
            places.append((x + joint.length * math.sin(turn), z - joint.length * math.cos(turn)))
        return places


@dataclass(frozen=True)
class FigureMotion:
    """A trial: ``times`` (n,) s, ``angles`` (n, n_joint) degrees, nan where missing.

    ``commands`` : joint -> (n,) degrees, what its servo was told last.
    """

    times: Sequence[float]
    angles: Sequence[tuple[float, ...]]
    commands: Mapping[str, Sequence[float]] = field(default_factory=dict)

    @property
    def seen(self) -> list[int]:
        """Samples with all joints."""
        return [k for k, pose in enumerate(self.angles) if all(map(math.isfinite, pose))]


def content(result: Result) -> dict[str, Any] | AbsentResult:
    """Stick figures, angles over time and the import's notes, for each trial."""
    stick = _stick(mapping(result.content, "leg"))
    trials = [trial for trial in sequence(result.content, "trials") if isinstance(trial, Mapping)]
    if not stick.joints or not trials:
        return AbsentResult(f"{result.name} holds no leg or no trial")
    motions = {str(trial.get("file")): _motion(result, stick, str(trial.get("file"))) for trial in trials}
    panels = {file: _panels(stick, motion) for file, motion in motions.items() if motion is not None}
    limits = shared_limits([panel for each in panels.values() for panel in each])
    shown: list[dict[str, Any]] = []
    for trial in trials:
        file, motion = str(trial.get("file")), motions[str(trial.get("file"))]
        item: dict[str, Any] = {"file": file, "source": trial.get("source"), "notes": sequence(trial, "notes")}
        item |= {"form": trial.get("source_format"), "samples": trial.get("samples"), "rate": trial.get("rate")}
        item["total"], item["missing"] = trial.get("samples_in_source"), missing_words(trial)
        if motion is not None and motion.seen and len(shown) < MOST_TRIALS:
            item["stick"] = moving_drawing(
                PurePosixPath(file).stem,
                stick,
                stick_figure(file, stick, motion, _tracked_points(trial)),
                _conversion(_all_points(stick, motion, _tracked_points(trial))),
            )
            item["angles"] = trial_figure(f"{file}: measured angles", panels[file], limits, PurePosixPath(file).stem)
        shown.append(item)
    lines = [(START, "first pose"), (END, "last pose"), (GHOST, "between"), (TIP, "path of the tip")]
    if any(trial.get("points") for trial in trials):
        lines.append((TRACKED, "points as tracked, scaled to the leg file's length"))
    told = any(motion is not None and motion.commands for motion in motions.values())
    if told:
        lines += [(MEASURED, "measured"), (TOLD, "command")]
    drawn = sum("stick" in item for item in shown)
    return {"trials": shown, "legend": legend(lines), "drawn": drawn, "total": len(trials), "told": told}


def missing_words(trial: Mapping[str, Any]) -> str:
    """Where readings are missing, ``ankle missing in 4``; empty if none is."""
    return ", ".join(f"{name} missing in {count}" for name, count in mapping(trial, "missing").items())


def stick_figure(
    title: str,
    stick: Stick,
    motion: FigureMotion,
    tracked: Sequence[Sequence[Point]] = (),
    lines: tuple[Line, Line, Line] = (START, END, TIP),
) -> Markup:
    """The leg's first and last pose, some between, the tip's path, each joint's angle with its positive direction.

    ``lines``: of the first pose, the last pose and the tip's path.
    """
    start, end, tip = lines
    poses = [stick.pose(motion.angles[k]) for k in motion.seen]
    svg = Svg(SIZE, SIZE, f"{title}: the leg as a stick figure")
    place = _conversion(_all_points(stick, motion, tracked))
    _frame(svg)
    for pose in _even_poses(poses):
        svg.polyline(map(place, pose), GHOST.style)
    svg.polyline((place(pose[-1]) for pose in poses), tip.style)
    for pose, line in ((poses[-1], end), (poses[0], start)):
        svg.polyline(map(place, pose), line.style)
        for point in pose[:-1]:
            svg.circle(place(point), 4.5, f'fill="#fff" stroke="{line.colour}" stroke-width="2"')
    for frame in tracked:
        svg.dots(map(place, frame), TRACKED.width, TRACKED.colour)
    first = motion.angles[motion.seen[0]]
    for index, joint in enumerate(stick.joints):
        x, y = place(poses[0][index])
        sense = "↺" if joint.sign > 0 else "↻"
        angle = f" {first[index] if abs(first[index]) >= 0.5 else 0.0:.0f}° {sense}"
        halo = 'font-size="12" fill="none" stroke="#fff" stroke-width="4" aria-hidden="true"'
        beside = [place(pose[k])[0] for pose in (poses[0], poses[-1]) for k in (index - 1, index + 1) if k >= 0]
        left = _words_left(x, beside)
        most, anchor = int((x if left else SIZE - x) / 7.3) - 2, ' text-anchor="end"' if left else ""
        # Letters: longer names would cross the figure; the angle is never cut.
        short = shorten_apart([j.name for j in stick.joints], max(2, min(28, most) - len(angle)))[index] + angle
        for style in (halo, f'font-size="12" fill="{BLACK}"'):
            svg.text((x - 10 if left else x + 10, y - 7), joint.name + angle, style + anchor, short=short)
    return svg.markup


def _words_left(x: float, beside: Sequence[float]) -> bool:
    """Whether a joint's label is to its left: away from its links if there is space, else on the side with space."""
    left = sum(beside) / len(beside) > x
    room = x if left else SIZE - x
    return left if room > ROOM else x > SIZE / 2


def moving_drawing(trial: str, stick: Stick, drawing: Markup, place: Callable[[Point], Point]) -> Markup:
    """The drawing with the data for the page's script, which moves the leg with the cursor of the trial's plots."""
    origin, right = place((0.0, 0.0)), place((1.0, 0.0))
    numbers = {
        "tilt": stick.tilt,
        "at": list(origin),
        "scale": right[0] - origin[0],
        "joints": [
            {"name": joint.name, "zero": joint.zero, "sign": joint.sign, "length": joint.length}
            for joint in stick.joints
        ],
    }
    return Markup('<div data-stick="{}">{}<script type="application/json">{}</script></div>').format(
        trial, drawing, data_block(numbers)
    )


def _all_points(stick: Stick, motion: FigureMotion, tracked: Sequence[Sequence[Point]]) -> list[Point]:
    """All points that the drawing must contain, mm."""
    poses = [stick.pose(motion.angles[k]) for k in motion.seen]
    return [point for pose in (*poses, *tracked) for point in pose]


def figure_of_trial(result: Result, trial: str, table: ResultTable, kind: str, called: str = "") -> Markup:
    """The leg of ``page.json`` in a trial's motion, which follows the cursor of the trial's plots; empty without it.

    ``called`` : what the columns of this ``kind`` are on the page; empty for the kind itself.
    """
    path = result.path("page.json")
    if path is None:
        return Markup("")
    try:
        page = json.loads(path.read_text(encoding="utf-8"))
    except (UnicodeDecodeError, json.JSONDecodeError, RecursionError):
        return Markup("")
    stick = _stick(mapping(page, "leg"))
    names = [f"{joint.name} {kind}" for joint in stick.joints]
    if not names or any(name not in table.columns or table.units[name] not in _DEGREES for name in names):
        return Markup("")
    columns = [[value * _DEGREES[table.units[name]] for value in table.columns[name]] for name in names]
    motion = FigureMotion(table.columns.get("time", []), list(zip(*columns, strict=True)))
    if not motion.seen:
        return Markup("")
    lines = (START_BESIDE, END_BESIDE, TIP_BESIDE)
    drawing = stick_figure(f"{trial}, {called or kind}", stick, motion, lines=lines)
    key = legend([(START_BESIDE, "first pose"), (END_BESIDE, "last pose"), (GHOST, "between"), (TIP_BESIDE, "tip")])
    return Markup('<div class="stick-small">{}{}<p class="small soft">{}</p></div>').format(
        moving_drawing(trial, stick, drawing, _conversion(_all_points(stick, motion, ()))),
        key,
        f"The leg's poses in this trial, {called or kind}: the start and the end of the motion, not two models.",
    )


def _stick(leg: Json) -> Stick:
    joints = [
        FigureJoint(
            str(item.get("name")),
            value_of(item.get("zero")) or 0.0,
            float(item.get("sign") or 1),
            value_of(item.get("length")) or 0.0,
        )
        for item in sequence(leg, "joints")
        if isinstance(item, Mapping)
    ]
    return Stick(tuple(joints), value_of(leg.get("tilt")) or 0.0)


def _motion(result: Result, stick: Stick, file: str) -> FigureMotion | None:
    table = result.table(file)
    if table is None or "time" not in table.columns or any(j.name not in table.columns for j in stick.joints):
        return None
    columns = [_in_degrees(table, joint.name) for joint in stick.joints]
    angles = list(zip(*columns, strict=True))
    told = {
        joint.name: _hold_values(_in_degrees(table, f"{joint.name} command"))
        for joint in stick.joints
        if f"{joint.name} command" in table.columns
    }
    # A row of commands alone is no sample of the motion: it would break every line.
    rows = [k for k, pose in enumerate(angles) if any(map(math.isfinite, pose))] if told else range(len(angles))
    return FigureMotion(
        [table.columns["time"][k] for k in rows],
        [angles[k] for k in rows],
        {name: [values[k] for k in rows] for name, values in told.items()},
    )


def _hold_values(values: Sequence[float]) -> list[float]:
    """Each value until the next one, nan before the first."""
    found, last = [], math.nan
    for value in values:
        last = value if math.isfinite(value) else last
        found.append(last)
    return found


def _in_degrees(table: ResultTable, joint: str) -> list[float]:
    return [value * _DEGREES[table.units[joint]] for value in table.columns[joint]]


def _tracked_points(trial: Mapping[str, Any]) -> list[list[Point]]:
    """The tracked points' places in mm, of some frames."""
    frames = [mapping(frame).get("places") for frame in sequence(trial, "points")]
    return [[(1e3 * x, 1e3 * z) for x, z in frame] for frame in frames if isinstance(frame, list)]


def _even_poses(poses: Sequence[Sequence[Point]]) -> list[Sequence[Point]]:
    """Poses evenly spaced along the tip's path, so that fast and slow parts of a swing have the same density."""
    steps = [math.dist(a[-1], b[-1]) for a, b in pairwise(poses)]
    way = list(accumulate(steps, initial=0.0))
    if way[-1] <= 0:
        return []
    wanted = [way[-1] * k / (GHOSTS + 1) for k in range(1, GHOSTS + 1)]
    return [poses[bisect_left(way, each)] for each in wanted]


def _conversion(points: Sequence[Point]) -> Callable[[Point], Point]:
    """The conversion from millimetres to drawing coordinates, with one scale for both axes."""
    low = [min(point[axis] for point in points) for axis in (0, 1)]
    high = [max(point[axis] for point in points) for axis in (0, 1)]
    span = max(high[0] - low[0], high[1] - low[1], 1e-6)
    scale = (SIZE - 2 * MARGIN) / span
    middle = [(a + b) / 2 for a, b in zip(low, high, strict=True)]

    def place(point: Point) -> Point:
        return SIZE / 2 + scale * (point[0] - middle[0]), SIZE / 2 - scale * (point[1] - middle[1])

    return place


def _frame(svg: Svg) -> None:
    """A border, and the direction of gravity."""
    svg.rectangle((1, 1), SIZE - 2, SIZE - 2, f'fill="none" stroke="{RULE}"')
    x, y = 24.0, SIZE - 52.0
    svg.line((x, y), (x, y + 26), f'stroke="{GREY}" stroke-width="1.6"')
    svg.path(f"M{x - 4} {y + 20}L{x} {y + 28}L{x + 4} {y + 20}", f'fill="none" stroke="{GREY}" stroke-width="1.6"')
    svg.text((x + 8, y + 18), "gravity", f'font-size="11" fill="{GREY}"')


def _panels(stick: Stick, motion: FigureMotion) -> list[TrialPanel]:
    """Angles over time, with a servo's commands, a panel a joint."""
    panels = []
    for index, joint in enumerate(stick.joints):
        curves = [Curve([pose[index] for pose in motion.angles], MEASURED, "measured")]
        if joint.name in motion.commands:
            curves.insert(0, Curve(motion.commands[joint.name], TOLD, "command"))
        panels.append(TrialPanel(joint.name, "deg", motion.times, curves, ""))
    return panels


SECTION = ReportSection("stick-figure", "The leg as imported", content)
