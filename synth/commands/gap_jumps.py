"""``synth gap`` on the recordings of a jumping leg."""

from __future__ import annotations

import argparse
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from synth.commands.progress import Progress


def run_jumps(arguments: argparse.Namespace, progress: Progress) -> int:
    """Read the project, diagnose, write ``gap.json``, predictions and a report."""
    from synth.commands.answers import gap_text, tell
    from synth.diagnosis.plants.jumping_leg.jump_data import prepared
    from synth.errors import UserError
    from synth.files.hopper_gap_project import read_hopper_gap_project
    from synth.files.output import output_folder
    from synth.parts.catalogs import Catalogue

    if arguments.effect:
        raise UserError("--effect is for swinging legs; those of the jumping leg are built in")
    with progress.stage("reading the project"):
        project = read_hopper_gap_project(arguments.file)
        catalogue = Catalogue.load(project.design.catalogs)
        _, warnings = prepared(project, catalogue)
    if arguments.dry_run:
        for text in warnings:
            progress.say(f"note: {text}")
        progress.say(f"{arguments.file} can be used: {len(project.trials)} trials, {len(project.inputs)} files")
        return 0
    with output_folder(arguments.out) as folder:
        with progress.stage("loading the compiled jump (compiled once on this machine, some 15 s)"):
            from synth.diagnosis.plants.jumping_leg.jump_diagnosis import diagnose
            from synth.jump.jump_runs import compiled_jump

            compiled_jump(project.design.leg.bending)
        with progress.stage("diagnosing"), ExitStack() as stage:

            def say(text: str) -> None:
                stage.close()
                stage.enter_context(progress.stage(text))

            result = diagnose(project, catalogue, say)
        with progress.stage("writing"):
            from reports.hopper import write_jump_gap_report
            from synth.diagnosis.plants.jumping_leg.jump_write import write_gap

            write_gap(result, project, folder)
            write_jump_gap_report(folder)
    tell(progress, Path(arguments.out) / "gap.json", gap_text)
    progress.say(result.sentence)
    for text in result.across.sentences():
        progress.say(text)
    progress.say(f"gap: {Path(arguments.out) / 'gap.json'}")
    progress.say(f"report: {Path(arguments.out) / 'report.html'}")
    return 0
