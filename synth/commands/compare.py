"""``synth compare``: compare fits, designs, gaps, legs and recordings.

Each argument is a result folder (of `synth fit`, `leg` or `gap`), a project file, a leg file, a recording or a
folder of recordings, written PATH or NAME=PATH. A result has several sides: `animal`, `wanted` and `built` for a
design, `recorded`, `designed` and `explained` for a gap, `recorded` and `fitted` for a fit; PATH#built,wanted selects.
All legs are simulated from the same starts: those of the first recordings among the arguments, or of --start.

  synth compare old=old/gap.yaml new=new/result#built,wanted,animal --out side_by_side
  synth compare family=leg-design.yaml --time-scales 1,1.5,2,3 --out family
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from synth.errors import UserError

if TYPE_CHECKING:
    from synth.commands.progress import Progress
    from synth.comparison.side import ComparedMotion, Side
    from synth.comparison.side_source import Source


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("sources", nargs="+", metavar="SOURCE", help="NAME=PATH#VIEW; name and view are optional")
    parser.add_argument("--out", required=True, metavar="DIR", help="folder to write, whole or not at all")
    parser.add_argument(
        "--reference", metavar="SIDE", help="the side that the others are compared with (default: the first recorded)"
    )
    parser.add_argument(
        "--start", metavar="START", help="a recording's file, or angles at rest: 'hip=60 deg, knee=100 deg'"
    )
    parser.add_argument(
        "--stretch", action="append", default=[], metavar="SIDE=FACTOR",
        help="slow down a side's motion; an animal's from as recorded",
    )  # fmt: skip
    parser.add_argument("--leg", metavar="FILE", help="the leg for recordings that name none")
    parser.add_argument(
        "--time-scales", metavar="LIST",
        help="for a leg-design project: its wanted leg at time scales 1,1.5,2,..., each beside the animal",
    )  # fmt: skip


def run(arguments: argparse.Namespace, progress: Progress) -> int:
    """Open, simulate and compare; write ``compare.json``, ``compare.csv``, ``responses/`` and the page."""
    from synth.api.comparisons import compare_opened, open_compared
    from synth.commands.answers import tell
    from synth.comparison.side_source import read_source
    from synth.files.leg_file import read_leg
    from synth.files.output import output_folder
    from synth.parts.resolver import resolver

    with progress.stage("reading"):
        sources = [read_source(written) for written in arguments.sources]
        scales = _scales(arguments.time_scales, sources)
        stretch = dict(_stretch(written) for written in arguments.stretch)
        leg = None if arguments.leg is None else read_leg(arguments.leg, resolve_part=resolver())
    with progress.stage("opening the sides"):
        sides = open_compared(sources, leg=leg, time_scales=scales)
        starts = _starts(arguments.start, sides)
    with output_folder(arguments.out, inputs=_files(sources)) as folder:
        progress.compiling(len(sides[0].leg.joints), effects=any(_needs_effects(side) for side in sides))
        found = compare_opened(
            sides, sources, reference=arguments.reference, stretch=stretch, starts=starts, stage=progress.stage
        )
        with progress.stage("writing"):
            found.write(folder)
    tell(progress, Path(arguments.out) / "compare.json", compare_text)
    progress.say(f"table: {Path(arguments.out) / 'compare.csv'}")
    progress.say(f"report: {Path(arguments.out) / 'report.html'}")
    return 0


def compare_text(content: Mapping[str, Any]) -> str:
    """One row per side: RMS distance from the reference; each joint's rates and free angle."""
    from synth.commands.table_text import table_text

    joints = content["joints"]
    timed = any("pace" in side or "slowed" in side for side in content["sides"])
    heads = ["side", *["overlaid"] * timed, "from reference [deg]", ""]
    rows = [[*heads, *(f"{name} k, b, free angle" for name in joints)]]
    for side in content["sides"]:
        off = side.get("off_reference", {})
        overall = off.get("overall", {}).get("value")
        shown = "reference" if side["name"] == content["reference"] else "-" if overall is None else f"{overall:.2f}"
        basis = "no common start" if off and overall is None else off.get("basis", "")
        row = [side["name"], *[_overlaid(side)] * timed, shown, basis]
        rows.append([*row, *(_rates(side["joints"].get(name)) for name in joints)])
    return table_text(rows)


def _overlaid(side: Mapping[str, Any]) -> str:
    """In what time a side's motion is overlaid."""
    pace, slowed = (side.get(key, {}).get("value", 1.0) for key in ("pace", "slowed"))
    words = [f"its time / {pace:g}"] * (pace != 1.0) + [f"slowed {slowed:g} times"] * (slowed != 1.0)
    return ", ".join(words) or ("as recorded" if side["kind"] == "recorded" else "its time")


def _rates(joint: Mapping[str, Any] | None) -> str:
    if not joint:
        return "-"
    known = [joint.get(key) for key in ("spring_rate", "damper_rate", "free_angle")]
    words = ["-" if not item else "unknown" if item.get("unknown") else f"{item['value']:.3g}" for item in known]
    if known[1] is None and joint.get("damper_law"):
        words[1] = "curve"
    return ", ".join(words)


def _needs_effects(side: Side) -> bool:
    """Whether the leg has effects beyond springs, linear dampers and gravity."""
    return bool(side.leg.effects) or any(j.effects or (j.damper and j.damper.curve) for j in side.leg.joints)


def _files(sources: Sequence[Source]) -> list[Path]:
    """The files that are compared, of a folder its result."""
    from synth.comparison.side_source import RESULTS

    return [source.path / name if source.path.is_dir() else source.path for source in sources for name in RESULTS]


def _scales(written: str | None, sources: list[Source]) -> tuple[float, ...]:
    if written is None:
        return ()
    if not any(source.kind == "leg-design project" for source in sources):
        raise UserError("--time-scales is for a leg-design project, but no argument is one")
    scales = []
    for text in written.split(","):
        try:
            scale = float(text)
        except ValueError:
            raise UserError(f'--time-scales: "{text.strip()}" is not a number; write them like 1,1.5,2,3') from None
        if not 1e-3 <= scale <= 1e3:
            raise UserError(f"--time-scales: {text.strip()} is not allowed: a factor between 0.001 and 1000")
        scales.append(scale)
    return tuple(dict.fromkeys(scales))


def _stretch(written: str) -> tuple[str, float]:
    name, _, text = written.rpartition("=")
    try:
        factor = float(text)
    except ValueError:
        factor = 0.0
    if not name or not 1e-3 <= factor <= 1e3:
        raise UserError(f"--stretch {written} is not allowed: write SIDE=FACTOR, the factor between 0.001 and 1000")
    return name, factor


def _starts(written: str | None, sides: list[Side]) -> list[ComparedMotion]:
    """The start given by the user: a recording's, or angles at rest."""
    from synth import units
    from synth.comparison.overlay import STANDARD_TIME
    from synth.comparison.recorded_sides import from_trials, standard_release
    from synth.files.trial_list import read_trials
    from synth.files.validate import near

    if written is None:
        return []
    leg = sides[0].leg
    if written.endswith(".csv"):
        path = Path(written)
        return list(from_trials(leg, read_trials([path.name], path.parent, leg)))
    angles: dict[str, float] = {}
    for item in written.split(","):
        name, equals, text = (part.strip() for part in item.partition("="))
        if not equals or name not in leg.joint_names:
            raise UserError(f'--start: "{item.strip()}" names no joint{near(name, leg.joint_names)}; write hip=60 deg')
        angles[name] = units.parse(text, "rad")
    missing = [name for name in leg.joint_names if name not in angles]
    if missing:
        raise UserError(f"--start: give {', '.join(missing)} too, as in hip=60 deg")
    import numpy as np

    pose = leg.to_rotation(np.array([angles[name] for name in leg.joint_names]))
    from dataclasses import replace

    found = standard_release(leg, pose, STANDARD_TIME)
    return [replace(found, name="given start", start=pose)]
