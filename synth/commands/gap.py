"""``synth gap``: where the built leg departs from the simulated one, which effect causes it, and how far it shrinks."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from synth.commands.progress import Progress
    from synth.diagnosis.plants.swinging_chain.chain_result import GapResult
    from synth.files.gap_project import GapProject


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("file", help="project file, kind: gap; its leg swings (kind: leg) or jumps (hopper-design)")
    parser.add_argument("--out", required=True, metavar="DIR", help="folder to write, whole or not at all")
    parser.add_argument(
        "--effect",
        action="append",
        default=[],
        metavar="FILE.py",
        help="an effect of your own that is to take part; its file is run. May be given more than once",
    )
    parser.add_argument("--dry-run", action="store_true", help="read and check everything, write nothing")


def run(arguments: argparse.Namespace, progress: Progress) -> int:
    """Read the project, diagnose, write ``gap.json``, predictions, the diagnosed leg and a report."""
    from synth.files.hopper_gap_project import is_hopper_gap

    if is_hopper_gap(arguments.file):
        from synth.commands.gap_jumps import run_jumps

        return run_jumps(arguments, progress)
    from synth.swing.effects.users_own import blamed_on

    with blamed_on({str(Path(file).resolve()): file for file in arguments.effect}):
        return _run_swings(arguments, progress)


def _run_swings(arguments: argparse.Namespace, progress: Progress) -> int:
    from dataclasses import replace

    from synth.commands.answers import gap_text, tell
    from synth.diagnosis.plants.swinging_chain.trial_checks import check_trials
    from synth.files.gap_project import read_gap_project
    from synth.files.output import output_folder
    from synth.parts.resolver import resolver
    from synth.swing.effects.users_own import load_file

    with progress.stage("reading the project"):
        for file in arguments.effect:
            load_file(file)
        project = read_gap_project(arguments.file, resolve_part=resolver())
        warnings = check_trials(project.leg, project.trials)
    if arguments.dry_run:
        for sentence in warnings:
            progress.say(f"note: {sentence}")
        progress.say(f"{arguments.file} can be used: {len(project.trials)} trials, {len(project.inputs)} files")
        return 0
    with output_folder(arguments.out) as folder:
        progress.compiling(len(project.leg.joints))
        result = _diagnosed(project, progress)
        said = tuple(dict.fromkeys((*warnings, *result.warnings)))
        result = replace(result, warnings=said, inputs=_inputs(project, arguments.effect))
        with progress.stage("writing"):
            from reports import write_gap_report
            from synth.diagnosis.plants.swinging_chain.chain_write import write_gap

            write_gap(result, project, folder)
            write_gap_report(folder)
    tell(progress, Path(arguments.out) / "gap.json", gap_text)
    progress.say(result.sentence)
    progress.say(f"gap: {Path(arguments.out) / 'gap.json'}")
    progress.say(f"report: {Path(arguments.out) / 'report.html'}")
    return 0


def _diagnosed(project: GapProject, progress: Progress) -> GapResult:
    """The diagnosis; what it says that it is doing becomes stages, each ending where the next begins."""
    from contextlib import ExitStack

    from synth.diagnosis.plants.swinging_chain.chain_diagnosis import diagnose

    with progress.stage("diagnosing"), ExitStack() as open_stage:

        def say(text: str) -> None:
            open_stage.close()
            open_stage.enter_context(progress.stage(text))

        return diagnose(project.leg, project.trials, project.tolerance, seed=project.seed, progress=say)


def _inputs(project: GapProject, effects: list[str]) -> dict[str, str]:
    """Every file that the diagnosis rests on, with its SHA-256: project, leg, effects of the user's, recordings."""
    from synth.files.output import sha256_file

    found = {item.name: item.sha256 for item in project.inputs}
    found |= {Path(file).name: sha256_file(file) for file in effects}
    return found | {trial.name: trial.sha256 for trial in project.trials}
