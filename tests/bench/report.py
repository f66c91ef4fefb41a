"""All benchmarks into one page: ``PYTHONPATH=tests python -m bench.report --to build/bench [--only gap] [--hopper]``.

Each benchmark runs in a process of its own, one after another, so that none has another's threads or caches.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import json
import math
import platform
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from jinja2 import Environment
from markupsafe import Markup

from bench.results import Cell, Figure, Section, load, say
from synth.reports.figures.axes import Axes, AxisScale
from synth.reports.figures.legend import legend
from synth.reports.figures.palette import BLUE, GREEN, GREY, ORANGE, VERMILION, Line
from synth.reports.figures.svg import Svg
from synth.threads import core_count

BENCHES = ("engine", "fit", "parts", "gap")
LIBRARIES = ("limb-synth", "numpy", "scipy", "numba", "llvmlite", "mujoco", "casadi")
LINES = [Line(BLUE), Line(VERMILION, dash="5 3"), Line(GREEN, dash="2 2"), Line(ORANGE, dash="7 2 2 2")]
HOPPER = "Jumps a second"


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="bench.report", description=__doc__)
    parser.add_argument("--to", type=Path, required=True, help="folder for bench.html and bench.json")
    parser.add_argument("--only", choices=BENCHES, action="append", help="one benchmark; may be given more than once")
    parser.add_argument("--hopper", action="store_true", help="also the jumping leg's (some minutes)")
    chosen = parser.parse_args(arguments)
    before = load()
    sections = {name: measured(name) for name in chosen.only or BENCHES}
    if chosen.hopper:
        sections["hopper"] = hopper()
    about = {**machine(), "load": {"before": before, "after": load()}}
    chosen.to.mkdir(parents=True, exist_ok=True)
    document = {"format": "synth/bench/1", **about, "sections": {n: s.as_json() for n, s in sections.items()}}
    (chosen.to / "bench.json").write_text(json.dumps(document, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    (chosen.to / "bench.html").write_text(page(list(sections.values()), about), encoding="utf-8")
    say(str(chosen.to / "bench.html"))
    return 0


def measured(name: str) -> Section:
    """One benchmark's section, from a process of its own."""
    say(f"{name} ...")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "section.json"
        subprocess.run([sys.executable, "-m", f"bench.bench_{name}", str(file)], check=True)
        return Section.from_json(json.loads(file.read_text(encoding="utf-8")))


def hopper() -> Section:
    """The jumping leg's benchmark as it prints itself."""
    say("hopper ...")
    script = Path(__file__).with_name("bench_hopper.py")
    printed = subprocess.run([sys.executable, str(script)], check=True, capture_output=True, text=True).stdout
    return Section(HOPPER, words=(f"By tests/bench/bench_hopper.py; load {load():.1f}.",), text=printed)


def machine() -> dict[str, Any]:
    """The machine and its versions."""
    info = Path("/proc/cpuinfo")
    models = [line.split(":", 1)[1].strip() for line in info.read_text().splitlines() if line.startswith("model name")]
    return {
        "at": datetime.now(UTC).isoformat(timespec="seconds"),
        "processor": models[0] if models else platform.processor(),
        "cores": core_count(),
        "system": platform.platform(),
        "versions": {"python": platform.python_version(), **{n: importlib.metadata.version(n) for n in LIBRARIES}},
    }


def page(sections: Sequence[Section], about: dict[str, Any]) -> str:
    """The page's text."""
    template = Environment(autoescape=True).from_string(Path(__file__).with_name("bench.html").read_text("utf-8"))
    goals = [goal for section in sections for goal in section.goals]
    versions = ", ".join(f"{name} {version}" for name, version in about["versions"].items())
    return template.render(
        opening=f"{sum(goal.reached for goal in goals)} of {len(goals)} targets are reached.",
        machine=(
            f"{about['at']}: {about['processor']}, {about['cores']} cores, {about['system']}; {versions}. Load (1 min) "
            f"{about['load']['before']:.1f} before, {about['load']['after']:.1f} after; above zero before, other work "
            "shared the machine, and what is taken on the wall is too long."
        ),
        goals=[
            {
                "what": goal.what,
                "value": f"{shown(goal.value)} {goal.unit}",
                "target": f"{goal.sense} {shown(goal.bound)}",
                "reached": goal.reached,
            }
            for goal in goals
        ],
        sections=[_section(section) for section in sections],
    )


def _section(section: Section) -> dict[str, Any]:
    tables = [
        {"title": t.title, "head": t.head, "note": t.note, "rows": [[shown(cell) for cell in row] for row in t.rows]}
        for t in section.tables
    ]
    figures = [{"title": f.title, "note": f.note, "drawing": drawing(f), "legend": key_to(f)} for f in section.figures]
    return {
        "title": section.title,
        "words": section.words,
        "tables": tables,
        "figures": figures,
        "text": section.text,
    }


def shown(cell: Cell) -> str:
    """A cell's text: numbers with at most four significant digits."""
    if cell is None:
        return "–"
    if isinstance(cell, str):
        return cell
    return f"{cell:,.0f}" if abs(cell) >= 1000 or cell == int(cell) else f"{cell:.4g}"


def key_to(figure: Figure) -> Markup:
    """The curves' names."""
    return legend([(line, curve.name) for line, curve in zip(LINES, figure.curves, strict=False)])


def drawing(figure: Figure) -> Markup:
    """Curves with a dot at each point; logarithmic in both or linear from zero."""
    points = [point for curve in figure.curves for point in curve.points]
    xs, ys = [x for x, _ in points], [y for _, y in points]
    if figure.logarithmic:
        ends = (min(xs) / 1.3, max(xs) * 1.3, 10 ** math.floor(math.log10(min(ys))), max(ys) * 1.6)
    else:
        ends = (0.0, 1.08 * max(xs), 0.0, 1.12 * max(ys))
    svg = Svg(430, 270, figure.title)
    axes = Axes(
        AxisScale(ends[0], ends[1], 58, 415, figure.logarithmic),
        AxisScale(ends[2], ends[3], 225, 14, figure.logarithmic),
    )
    axes.frame(svg)
    for line, curve in zip(LINES, figure.curves, strict=False):
        place = axes.points(curve.points)
        svg.polyline(place, line.style)
        svg.dots(place, 5, line.colour)
    words = f'font-size="11" fill="{GREY}"'
    svg.text((236, 262), figure.x, f'text-anchor="middle" {words}')
    svg.text((13, 120), figure.y, f'text-anchor="middle" transform="rotate(-90 13 120)" {words}')
    return svg.markup


if __name__ == "__main__":
    sys.exit(main())
