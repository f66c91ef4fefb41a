"""``synth import``: convert motion recorded by other programs into trials of a leg.

Reads DeepLabCut, SLEAP, Anipose, Vicon, Qualisys, OptiTrack, TRC, C3D, NWB pose, OpenSim, MATLAB, MCAP and ROS bags,
and CSV of other column names or of points (--list). The format is detected from the content. FILE is such a
recording, or several, with --leg, or a project (kind: import) that assigns columns or points of many files to the
leg's joints. For joints with a drive it brings in commands, voltages, currents and the supply too. The output has the
trials, the leg, a runnable fit.yaml (of a driven leg gap.yaml), a page with the leg as a stick figure, and a list of
what was detected, repaired and cut: angle jumps by whole turns, left and right exchanged by a tracker, samples before
the release.
"""

from __future__ import annotations

import argparse
import os
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from synth.commands.arguments import Quantities, one_of
from synth.errors import Problem, UserError

if TYPE_CHECKING:
    from synth.commands.progress import Progress
    from synth.files.import_project import ForeignFile, ImportProject
    from synth.motion.importers.import_result import ImportedTrial

CUTS = ("cut", "free", "keep")
BARE = (
    "--leg",
    "--points",
    "--plane",
    "--frame-rate",
    "--topic",
    "--commands",
    "--release",
)  # options for a single recording
PROJECTS = (".yaml", ".yml")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("files", nargs="*", metavar="FILE", help="recordings, or a project file, kind: import")
    parser.add_argument("--list", action="store_true", help="list the formats and what each needs")
    parser.add_argument("--leg", metavar="LEG", help="leg file for recordings without a project")
    parser.add_argument("--out", metavar="DIR", help="folder to write, whole or not at all")
    parser.add_argument("--points", metavar="A,B,...", help="the joints' points, proximal to distal, then the tip")
    parser.add_argument("--plane", metavar="X,Z", help="axes of space to the right and up; --plane=-y,z; --plane=fit,z")
    parser.add_argument("--topic", metavar="NAME", help="topic of the joint states in a robot's log")
    parser.add_argument("--commands", metavar="NAME", help="topic of the commands, if it is another one")
    parser.add_argument("--frame-rate", metavar="RATE", help='camera frame rate, such as "250 Hz"')
    kept = "cut (default): cut to the release; free: cut the driven part too; keep: keep all"
    parser.add_argument("--release", type=one_of(CUTS), metavar="|".join(CUTS), help=kept)
    parser.add_argument("--dry-run", action="store_true", help="read and check all input, write nothing")


def run(arguments: argparse.Namespace, progress: Progress) -> int:
    """Read the recordings, write ``trials/*.csv``, ``import.json`` and ``report.html``."""
    from synth.commands.answers import tell_document
    from synth.files.output import output_folder
    from synth.motion.importers.import_result import TRIALS, project_file, write_import

    if arguments.list:
        tell_document(progress, _formats_json(), _formats_text())
        return 0
    needed = [] if arguments.files else [Problem("name a recording or a project: synth import FILE", key="FILE")]
    if not arguments.out and not arguments.dry_run:
        needed.append(Problem("name the folder to write: --out DIR", key="--out"))
    if needed:
        raise UserError(needed)
    with progress.stage("reading"):
        project = _project(arguments)
        trials = _read_files(project, arguments.files)
    if arguments.dry_run:
        _tell_checked(project, trials, progress)
        verb = "is" if len(arguments.files) == 1 else "are"
        progress.say(f"{', '.join(arguments.files)} {verb} valid: {len(trials)} recordings")
        return 0
    read = [*map(Path, arguments.files), *(trial.source.path for trial in trials)]
    read += [Path(arguments.files[0]).parent / item.name for item in project.inputs]
    with output_folder(arguments.out, inputs=read) as folder, progress.stage("writing"):
        write_import(project, trials, folder)
        from synth.reports import write_import_report

        write_import_report(folder)
    out = Path(arguments.out)
    if progress.as_json:
        progress.document((out / "import.json").read_text(encoding="utf-8"))
    _tell_read(trials, project.leg.joint_names, progress)
    file = out / project_file(project.leg)
    what = "fit" if file.stem == "fit" else "diagnose"
    words = ["synth", file.stem, str(file), "--out", f"{out.name}_{file.stem}"]
    words += [word for each in arguments.effect for word in ("--effect", each)]
    progress.say(f"trials: {out / TRIALS}/*.csv; {what} them with: {shlex.join(words)}")
    progress.say(f"check the stick figure before you {what}: {out / 'report.html'}")
    return 0


def _read_files(project: ImportProject, named: Sequence[str]) -> list[ImportedTrial]:
    """The recordings; where a faulty one may be left out, or its columns assigned, the message tells how."""
    from synth.drives.servo import Servo
    from synth.motion.importers.foreign_data import ColumnProblem
    from synth.motion.importers.import_result import read_files

    try:
        return read_files(project)
    except UserError as error:
        bare = Path(named[0]).suffix.casefold() not in PROJECTS
        more = _others(project, error, bare=bare)
        if not bare or not any(isinstance(problem, ColumnProblem) for problem in error.problems):
            raise UserError([*error.problems, *more]) from None
        joint = project.leg.joints[0]
        told = isinstance(joint.drive, Servo) and not joint.drive.open_duty
        text = "columns are assigned in a project file, which is imported instead: kind: import, leg: ..., "
        files = ", ".join(Path(file).name for file in named)
        if project.mapping.points:
            text = "write the unit into the header, as in time [s], or state it in a project file, which is imported "
            text += f"instead: kind: import, leg: ..., files: [{files}], points: [{', '.join(project.mapping.points)}]"
            raise UserError([*error.problems, *more, Problem(f"{text}, time: {{column: COLUMN, unit: s}}")]) from None
        text += f"files: [{files}], joints: {{{joint.name}: {{column: COLUMN}}}}; beside it `unit: deg` "
        text += "where the file states none, of raw counts `counts: 4096` (a turn)"
        text += ", `command: COLUMN` where the command is in the same file" if told else ""
        raise UserError([*error.problems, *more, Problem(text)]) from None


def _others(project: ImportProject, error: UserError, *, bare: bool) -> list[Problem]:
    """How to import the recordings that are not at fault; ``bare`` : without a project. Empty if there are none."""
    faulty = {file.name for file in project.files} & {problem.file for problem in error.problems}
    left = len(project.files) - len(faulty)
    if not faulty or not left:
        return []
    out = "do not name them" if bare else f"exclude: [{', '.join(sorted(map(str, faulty)))}]"
    found = "1 recording" if left == 1 else f"{left} recordings"
    return [Problem(f"nothing is written; the other {found} can be imported without those: {out}, or correct them")]


def _project(arguments: argparse.Namespace) -> ImportProject:
    """The named project, or one made from recordings and the options."""
    from synth.files.import_mapping import CommandTopic, Mapping
    from synth.files.import_project import ImportProject, read_import_project
    from synth.files.leg_file import read_leg
    from synth.parts.catalogs import Catalogue
    from synth.parts.resolver import resolver

    projects = [name for name in arguments.files if Path(name).suffix.casefold() in PROJECTS]
    quantities = Quantities(arguments)
    resolve = resolver(Catalogue.load())
    if projects:
        if len(arguments.files) > 1:
            raise UserError(
                Problem("is a project, which is imported by itself; name its recordings there", projects[0])
            )
        given = [option for option in BARE if quantities.given(option)]
        if given:
            text = f"applies to recordings; {projects[0]} is a project: write it there"
            raise UserError([Problem(text, key=option) for option in given])
        return read_import_project(Path(projects[0]), resolve_part=resolve)
    rate = quantities.read("--frame-rate", "Hz")
    if arguments.leg is None:
        text = "name the leg whose joints were recorded: --leg LEG.leg.yaml"
        quantities.problems.append(Problem(text, arguments.files[0]))
    plane = _words(arguments.plane)
    if plane and len(plane) != 2:
        quantities.problems.append(Problem(f'"{arguments.plane}": write two axes, such as x,z', key="--plane"))
    quantities.require()
    leg = read_leg(arguments.leg, resolve_part=resolve)
    points, both = _words(arguments.points), (plane[0], plane[1]) if plane else None
    commands = (CommandTopic(arguments.commands),) if arguments.commands else ()
    mapping = Mapping(frame_rate=rate, points=points, plane=both, topic=arguments.topic, commands=commands)
    return ImportProject(leg.name, leg, _named_files(arguments.files), "auto", mapping, arguments.release or "cut")


def _named_files(names: Sequence[str]) -> tuple[ForeignFile, ...]:
    """The recordings of a command line, each once; a bag's folder stands for its file."""
    from synth.files.import_project import ForeignFile, bag_file
    from synth.files.paths import is_folder

    found: dict[Path, ForeignFile] = {}
    problems = []
    for name in names:
        path = Path(bag_file(Path(), str(Path(name))))
        place = Path(os.path.realpath(path))
        if is_folder(str(path)):
            text = f"is a folder; name the files in it, such as {name}/*.csv, or in a project, kind: import"
            problems.append(Problem(text, name))
        elif place in found:
            problems.append(Problem("is named twice; name it once", name))
        found[place] = ForeignFile(path, str(path))
    if problems:
        raise UserError(problems)
    return tuple(found.values())


def _tell_checked(project: ImportProject, trials: list[ImportedTrial], progress: Progress) -> None:
    """Write the import where nobody keeps it, since its trials are checked by reading them; tell what was read."""
    from tempfile import TemporaryDirectory

    from synth.motion.importers.import_result import write_import

    with TemporaryDirectory(prefix="synth-import-") as made, progress.stage("checking"):
        write_import(project, trials, Path(made))
        written = (Path(made) / "import.json").read_text(encoding="utf-8")
    if progress.as_json:
        progress.document(written)
    _tell_read(trials, project.leg.joint_names, progress)


def _tell_read(trials: Sequence[ImportedTrial], joints: Sequence[str], progress: Progress) -> None:
    """One row per recording, then what was detected, repaired and cut, alike in many recordings at once."""
    from synth.commands.grouped_notes import grouped_notes
    from synth.commands.table_text import table_text

    rows = [["recording", "samples", "time [s]", "notes", "format"]]
    for trial in trials:
        made = trial.imported
        duration = f"{made.time[-1] - made.time[0]:.2f}"
        rows.append([trial.source.name, str(len(made.time)), duration, str(len(made.notes)), made.format])
    if not progress.as_json:
        progress.result(table_text(rows))
    notes = [(trial.source.name, note) for trial in trials for note in trial.imported.notes]
    for line in grouped_notes(notes, joints):
        progress.say(line)


def _formats_json() -> dict[str, Any]:
    """The formats with the needs of each."""
    from synth.motion.importers.registry import formats

    keys = ("name", "title", "gives", "package", "extra", "installed")
    rows = [{key: getattr(item, key) for key in keys} for item in formats().values()]
    return {"format": "synth/formats/1", "formats": rows}


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
