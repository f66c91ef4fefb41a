"""``synth gap`` for the recordings of a jumping leg."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from synth.commands.progress import Progress


def run_jumps(arguments: argparse.Namespace, progress: Progress) -> int:
    """Read the project and diagnose; write ``gap.json``, predictions and a report."""
    from synth.api.jump_gaps import jump_gap, read_jump_gap
    from synth.commands.answers import gap_text, tell
    from synth.files.input_hashes import input_files
    from synth.files.output import output_folder

    with progress.stage("reading the project"):
        project, catalogue, warnings = read_jump_gap(arguments.file)
    if arguments.dry_run:
        for text in warnings:
            progress.say(f"note: {text}")
        progress.say(f"{arguments.file} is valid: {len(project.trials)} trials, {len(project.inputs)} files")
        return 0
    with output_folder(arguments.out, inputs=input_files(project)) as folder:
        found = jump_gap(project, catalogue, stage=progress.stage)
        with progress.stage("writing"):
            found.write(folder)
    tell(progress, Path(arguments.out) / "gap.json", gap_text)
    progress.say(found.headline)
    for text in found.result.across.sentences():
        progress.say(text)
    progress.say(f"gap: {Path(arguments.out) / 'gap.json'}")
    progress.say(f"report: {Path(arguments.out) / 'report.html'}")
    return 0
