"""``synth import``: motion that other programs recorded, as trials of a leg.

Reads DeepLabCut, SLEAP, Anipose, TRC, C3D, NWB pose, OpenSim, MATLAB, MCAP and ROS bags, and CSV of other column
names (--list). A file's format is told by its content. FILE is such a recording, with --leg, or a project (kind:
import) that says for many files which columns or points are the leg's joints. Writes the trials, the leg and a
fit.yaml that runs as it stands, a page with the leg as a stick figure, and what was found, mended and cut. Angles jump
by whole turns, trackers exchange left and right, recordings begin before the release: all that is looked for and told.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from synth.commands.arguments import Quantities, one_of
from synth.errors import Problem, UserError

if TYPE_CHECKING:
    from synth.commands.progress import Progress
    from synth.files.import_project import ImportProject

CUTS = ("cut", "free", "keep")
BARE = (
    "--leg",
    "--points",
    "--plane",
    "--frame-rate",
    "--topic",
    "--release",
)  # options of a recording named on its own
PROJECTS = (".yaml", ".yml")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("file", nargs="?", metavar="FILE", help="a recording, or a project file, kind: import")
    parser.add_argument("--list", action="store_true", help="the formats, what each needs, and whether it is there")
    parser.add_argument("--leg", metavar="LEG", help="leg file, of a recording named on its own")
    parser.add_argument("--out", metavar="DIR", help="folder to write, whole or not at all")
    parser.add_argument("--points", metavar="A,B,...", help="the joints' points, proximal to distal, then the tip")
    parser.add_argument(
        "--plane", metavar="X,Z", help="axes of space that are right and up; --plane=-y,z; --plane=fit,z"
    )
    parser.add_argument("--topic", metavar="NAME", help="topic of the joint states in a robot's log")
    parser.add_argument("--frame-rate", metavar="RATE", help='frames filmed a second, such as "250 Hz"')
    kept = "cut to the release (default), free: also what a hand still drives, keep: everything"
    parser.add_argument("--release", type=one_of(CUTS), metavar="|".join(CUTS), help=kept)
    parser.add_argument("--dry-run", action="store_true", help="read and check everything, write nothing")


def run(arguments: argparse.Namespace, progress: Progress) -> int:
    """Read the recordings, write ``trials/*.csv``, ``import.json`` and ``report.html``."""
    from synth.files.output import output_folder
    from synth.motion.importers.import_result import FIT, TRIALS, read_files, write_import

    if arguments.list:
        progress.result(_formats_text())
        return 0
    needed = [] if arguments.file else [Problem("name a recording or a project: synth import FILE", key="FILE")]
    if not arguments.out and not arguments.dry_run:
        needed.append(Problem("name the folder to write: --out DIR", key="--out"))
    if needed:
        raise UserError(needed)
    with progress.stage("reading"):
        project = _project(arguments)
        trials = read_files(project)
    for trial in trials:
        recording = trial.imported
        duration = recording.time[-1] - recording.time[0]
        progress.say(f"{trial.source.name}: {len(recording.time)} samples over {duration:.2f} s, {recording.format}")
        for note in recording.notes:
            progress.say(f"  {note}")
    if arguments.dry_run:
        progress.say(f"{arguments.file} can be used: {len(trials)} recordings")
        return 0
    with output_folder(arguments.out) as folder, progress.stage("writing"):
        write_import(project, trials, folder)
        from synth.reports import write_import_report

        write_import_report(folder)
    out = Path(arguments.out)
    progress.say(f"trials: {out / TRIALS}/*.csv; they can be fitted: synth fit {out / FIT} --out {out.name}_fit")
    progress.say(f"look at the stick figure before you fit: {out / 'report.html'}")
    return 0


def _project(arguments: argparse.Namespace) -> ImportProject:
    """The project named, or one made of a single recording and the options."""
    from synth.files.import_project import ForeignFile, ImportProject, Mapping, read_import_project
    from synth.files.leg_file import read_leg
    from synth.parts.catalogs import Catalogue
    from synth.parts.resolver import resolver

    path = Path(arguments.file)
    quantities = Quantities(arguments)
    resolve = resolver(Catalogue.load())
    if path.suffix.casefold() in PROJECTS:
        given = [option for option in BARE if quantities.given(option)]
        if given:
            text = f"belongs to a recording named on its own; {path} is a project: write it there"
            raise UserError([Problem(text, key=option) for option in given])
        return read_import_project(path, resolve_part=resolve)
    rate = quantities.read("--frame-rate", "Hz")
    if arguments.leg is None:
        text = "name the leg whose joints were recorded: --leg LEG.leg.yaml"
        quantities.problems.append(Problem(text, str(path)))
    plane = _words(arguments.plane)
    if plane and len(plane) != 2:
        quantities.problems.append(Problem(f'"{arguments.plane}": write two axes, such as x,z', key="--plane"))
    quantities.require()
    leg = read_leg(arguments.leg, resolve_part=resolve)
    points, both = _words(arguments.points), (plane[0], plane[1]) if plane else None
    mapping = Mapping(frame_rate=rate, points=points, plane=both, topic=arguments.topic)
    return ImportProject(leg.name, leg, (ForeignFile(path, str(path)),), "auto", mapping, arguments.release or "cut")


def _formats_text() -> str:
    """The formats as a table."""
    from synth.commands.table_text import table_text
    from synth.motion.importers.registry import formats

    rows = [["format", "what it is", "gives", "needs"]]
    for item in formats().values():
        missing = "" if item.installed else f", not installed: pip install limb-synth[{item.extra}]"
        rows.append([item.name, item.title, item.gives, f"{item.package}{missing}" if item.package else "nothing"])
    return table_text(rows, numbers_right=False)


def _words(text: str | None) -> tuple[str, ...]:
    return tuple(word.strip() for word in text.split(",") if word.strip()) if text else ()
