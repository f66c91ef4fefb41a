"""``synth gap``: where the built leg departs from the simulated one, which effect causes it, and its size."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from synth.commands.arguments import cluster_argument, count

if TYPE_CHECKING:
    from synth.commands.progress import Progress


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("file", help="project file, kind: gap, or a folder of such; its leg swings or jumps")
    parser.add_argument("--out", metavar="DIR", help="folder to write, whole or not at all; optional with --check")
    parser.add_argument("--dry-run", action="store_true", help="read and check all input, write nothing")
    parser.add_argument(
        "--check",
        action="store_true",
        help="without a fit, in seconds: problems of the recordings, detectable sizes and inseparable causes",
    )
    parser.add_argument(
        "--rehearse",
        action="store_true",
        help="simulate your leg and trials with known causes, diagnose them blind, and report which are found "
        "and from which size; resumes an interrupted run",
    )
    parser.add_argument(
        "--keep",
        metavar="FOLDER",
        help="write each rehearsed case into it, as a project to open with `synth gap`, beside its truth.json",
    )
    parser.add_argument("--count", type=count, metavar="N", help="rehearsal cases (default: two per cause and joint)")
    parser.add_argument("--workers", type=count, metavar="N", help="parallel cases or projects (default: all cores)")
    cluster_argument(parser)


def run(arguments: argparse.Namespace, progress: Progress) -> int:
    """Read the project and diagnose; write ``gap.json``, predictions, the diagnosed leg and a report."""
    from synth.files.gap_kind import is_hopper_gap
    from synth.files.paths import is_folder

    if is_folder(arguments.file):
        return _run_folder(arguments, progress)
    jumps = is_hopper_gap(arguments.file)
    _refuse(arguments, jumps=jumps)
    if jumps:
        from synth.commands.gap_jumps import run_jumps

        return run_jumps(arguments, progress)
    return _run_swings(arguments, progress)


def _run_folder(arguments: argparse.Namespace, progress: Progress) -> int:
    """Every project in a folder, on all cores or on a cluster."""
    from synth.api.gap_folder import gaps
    from synth.commands.folder_options import refuse_options
    from synth.commands.project_folder import run_folder
    from synth.errors import UserError

    refuse_options(arguments, ("check", "rehearse", "count", "keep"), "is a folder; this is for one project")
    if not arguments.out:
        raise UserError('--out is missing: "--out DIR" names the folder to write (see synth gap --help)')
    return run_folder(arguments, progress, gaps())


APPLIES_TO = {
    "count": "--rehearse",
    "keep": "--rehearse",
    "workers": "a folder of projects or to --rehearse",
    "scheduler": "a folder of projects",
}


def _refuse(arguments: argparse.Namespace, *, jumps: bool) -> None:
    """Refuse options that exclude each other or do not apply to jumping legs."""
    from synth.errors import UserError

    asked = [name for name in ("--check", "--rehearse", "--dry-run") if getattr(arguments, name[2:].replace("-", "_"))]
    if len(asked) > 1:
        raise UserError(f"{' and '.join(asked)} exclude each other; give one of them")
    if jumps and (arguments.check or arguments.rehearse):
        raise UserError(f"{asked[0]} applies to swinging legs; use --dry-run for a jumping leg's recordings")
    for name in ("count", "keep", "workers", "scheduler"):
        if getattr(arguments, name) is not None and (name == "scheduler" or not arguments.rehearse):
            raise UserError(f"--{name} applies to {APPLIES_TO[name]} only")
    if not arguments.out and not arguments.check:
        raise UserError('--out is missing: "--out DIR" names the folder to write (see synth gap --help)')


def _run_swings(arguments: argparse.Namespace, progress: Progress) -> int:
    from synth.api.gaps import gap, read_gap, with_checked_trials
    from synth.commands.answers import gap_text, tell
    from synth.files.input_hashes import input_files
    from synth.files.output import output_folder

    with progress.stage("reading the project"):
        project = read_gap(arguments.file)
    if arguments.check:
        from synth.commands.gap_check import run_check

        return run_check(arguments, progress, project)
    if arguments.rehearse:
        from synth.commands.gap_rehearse import run_rehearsal

        return run_rehearsal(arguments, progress, project)
    with progress.stage("checking the trials"):
        given = with_checked_trials(project)
    if arguments.dry_run:
        for sentence in given.warnings:
            progress.say(f"note: {sentence}")
        progress.say(f"{arguments.file} is valid: {len(project.trials)} trials, {len(project.inputs)} files")
        return 0
    with output_folder(arguments.out, inputs=input_files(project)) as folder:
        progress.compiling(len(project.leg.joints))
        found = gap(given, stage=progress.stage)
        with progress.stage("writing"):
            found.write(folder)
    tell(progress, Path(arguments.out) / "gap.json", gap_text)
    progress.say(found.headline)
    progress.say(f"gap: {Path(arguments.out) / 'gap.json'}")
    progress.say(f"report: {Path(arguments.out) / 'report.html'}")
    return 0
