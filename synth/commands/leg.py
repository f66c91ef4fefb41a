"""``synth leg``: from a leg-design project to a folder with the complete design, or from a folder of projects."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from synth.commands.progress import Progress
    from synth.errors import UserError
    from synth.files.leg_project import LegProject
    from synth.files.stage_cache import StageCache
    from synth.parts.catalogs import Catalogue


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    from synth.commands import leg_parts
    from synth.commands.arguments import cluster_argument, workers_argument

    parser.add_argument("file", help="project file, kind: leg-design, or a folder of such projects")
    parser.add_argument("--out", required=True, metavar="DIR", help="folder to write, whole or not at all")
    parser.add_argument("--no-cad", action="store_true", help="leave the solids out")
    parser.add_argument("--no-pictures", action="store_true", help="leave the pictures of the solids out")
    parser.add_argument("--no-cache", action="store_true", help="neither use nor store cached results")
    parser.add_argument("--dry-run", action="store_true", help="read and check all input, write nothing")
    workers_argument(parser)
    cluster_argument(parser)
    leg_parts.add_arguments(parser)


def run(arguments: argparse.Namespace, progress: Progress) -> int:
    """Read; then copy an earlier result of the same input, or fit, choose, draw and write."""
    from synth.commands.folder_options import only_for_folders
    from synth.files.paths import is_folder

    if is_folder(arguments.file):
        return _run_folder(arguments, progress)
    only_for_folders(arguments)
    from functools import partial

    from synth.api.design_input import read_design
    from synth.commands.answers import tell
    from synth.commands.leg_parts import parts_text, require_known_joints, with_options
    from synth.errors import Problem
    from synth.files.input_hashes import input_files, input_hashes
    from synth.files.output import output_folder
    from synth.files.shown_units import shown_for
    from synth.files.stage_cache import StageCache, key_of

    with progress.stage("reading the project"):
        project, catalogue = read_design(arguments.file)
        project = with_options(project, arguments, catalogue)
        require_known_joints(project)
    if arguments.dry_run:
        progress.say(f"{arguments.file} is valid: {len(project.trials)} trials, {len(project.inputs)} files")
        return 0
    cache = StageCache(on=not arguments.no_cache)
    options = (arguments.no_cad, arguments.no_pictures, repr(project.parts))
    key = key_of("leg", arguments.file, input_hashes(project), *options)
    report = Path(arguments.out) / "report.html"
    replaced = Path(arguments.out, "parts").is_dir()
    failure: UserError | None = None
    with output_folder(arguments.out, inputs=input_files(project)) as folder:
        if cache.fetch(key, folder):
            progress.say("the input is unchanged: copying the earlier result (--no-cache runs again)")
        else:
            failure = _make_leg(arguments, project, catalogue, folder, cache, progress)
            # A later run of this machine may be able to draw.
            whole = arguments.no_cad or arguments.no_pictures or (folder / "parts" / "leg.png").exists()
            if failure is None and whole:
                cache.keep(key, folder)
    if failure is not None:
        if replaced:  # parts of another design would be taken for those of this one
            text = "now holds this design, without parts; those of the earlier run are removed"
            failure.problems.append(Problem(text, arguments.out))
        raise failure
    shown = shown_for(arguments.units, [project.path.parent / item.name for item in project.inputs])
    notes = _page_warnings(Path(arguments.out))
    tell(progress, Path(arguments.out) / "design.json", partial(parts_text, shown=shown), notes)
    progress.say(f"design: {Path(arguments.out) / 'design.json'}")
    progress.say(f"report: {report}")
    return 0


def _page_warnings(folder: Path) -> list[str]:
    """Every warning that the page shows, once, so that screen and page count the same."""
    from synth.remarks import about, read_remark
    from synth.reports.reading import read_result
    from synth.reports.sections.warnings import warnings_of

    found = warnings_of(read_result(folder, "design.json", "leg-design"))
    remarks = [(each.joint, read_remark({"text": each.text, "severity": each.level})) for each in found]
    return [about(joint, remark) if joint else remark for joint, remark in remarks]


def _run_folder(arguments: argparse.Namespace, progress: Progress) -> int:
    """Every project in a folder, on all cores or on a cluster."""
    from synth.api.leg_folder import legs
    from synth.commands.leg_parts import require_known_joints, with_options
    from synth.commands.project_folder import run_folder

    def wished(project: LegProject, catalogue: Catalogue) -> LegProject:
        project = with_options(project, arguments, catalogue)
        require_known_joints(project)
        return project

    drawn = {"solids": not arguments.no_cad, "pictures": not arguments.no_pictures}
    return run_folder(arguments, progress, legs(wished, **drawn))


def _make_leg(
    arguments: argparse.Namespace,
    project: LegProject,
    catalogue: Catalogue,
    folder: Path,
    cache: StageCache,
    progress: Progress,
) -> UserError | None:
    """Do all the work into ``folder``. If a check fails, return the error to raise once the folder is complete."""
    from synth.api.designs import design, drawing

    with drawing(project, solids=not arguments.no_cad, stage=progress.stage):
        found = design(
            project,
            catalogue,
            solids=not arguments.no_cad,
            cache=cache,
            stage=progress.stage,
            compiling=progress.compiling,
        )
        return found.write_with(
            folder,
            pictures=not arguments.no_pictures,
            cache=cache,
            report=Path(arguments.out) / "report.html",
            stage=progress.stage,
        )
