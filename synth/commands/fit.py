"""``synth fit``: springs, dampers and free angles of a leg from its trials, or of many legs at once.

FILE is a project or a folder; of a folder every project is fitted, on all cores or on a Dask cluster. Projects that
cannot be fitted are listed at the end and do not stop the others. Give the same command again to resume an
interrupted run.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from synth.commands.arguments import cluster_argument, workers_argument
from synth.commands.fit_choice import add_fit_arguments, fit_choice, not_for_folders

if TYPE_CHECKING:
    from synth.batch.one_fit import Ready
    from synth.commands.progress import Progress


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("file", metavar="FILE", help="project file, kind: fit, or a folder of such projects")
    parser.add_argument("--out", required=True, metavar="DIR", help="folder to write, whole or not at all")
    add_fit_arguments(parser)
    parser.add_argument("--dry-run", action="store_true", help="read and check all input, write nothing")
    workers_argument(parser)
    cluster_argument(parser)


def run(arguments: argparse.Namespace, progress: Progress) -> int:
    """Read the project and fit; write ``fit.json``, the fitted leg, responses and a report."""
    from synth.commands.folder_options import only_for_folders
    from synth.files.paths import is_folder

    if is_folder(arguments.file):
        from synth.batch.one_fit import fits
        from synth.commands.project_folder import run_folder

        not_for_folders(arguments)
        return run_folder(arguments, progress, fits())
    only_for_folders(arguments)
    from dataclasses import replace
    from functools import partial

    from synth.api.fitting import check_project, fit_checked, read_fit
    from synth.commands.answers import fit_text, tell
    from synth.files.input_hashes import input_files
    from synth.files.output import output_folder
    from synth.files.shown_units import shown_for

    with progress.stage("reading the project"):
        project = read_fit(arguments.file)
        given = check_project(replace(project, fit=fit_choice(project.fit, arguments)))
    if arguments.dry_run:
        progress.say(_usable(arguments.file, given))
        return 0
    with output_folder(arguments.out, inputs=input_files(project)) as folder:
        progress.compiling(len(project.leg.joints), effects=given.needs_effects)
        found = fit_checked(given, stage=progress.stage)
        with progress.stage("writing"):
            found.write(folder)
    shown = shown_for(arguments.units, [project.path.parent / item.name for item in project.inputs])
    tell(progress, Path(arguments.out) / "fit.json", partial(fit_text, shown=shown))
    for proposal in found.result.proposals:
        progress.say(f"worth measuring: {proposal.brief} (how: report.html)")
    progress.say(f"fit: {Path(arguments.out) / 'fit.json'}")
    progress.say(f"report: {Path(arguments.out) / 'report.html'}")
    return 0


def _usable(file: str, ready: Ready) -> str:
    return f"{file} is valid: {len(ready.project.trials)} trials, {len(ready.project.inputs)} files"
