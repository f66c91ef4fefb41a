"""``synth fit``: springs, dampers and free angles of a leg from its trials."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from synth.commands.fit_choice import add_fit_arguments, fit_choice

if TYPE_CHECKING:
    from synth.commands.progress import Progress


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument("file", help="project file, kind: fit")
    parser.add_argument("--out", required=True, metavar="DIR", help="folder to write, whole or not at all")
    add_fit_arguments(parser)
    parser.add_argument("--dry-run", action="store_true", help="read and check everything, write nothing")


def run(arguments: argparse.Namespace, progress: Progress) -> int:
    """Read the project, fit, write ``fit.json``, the fitted leg, responses and a report."""
    from dataclasses import replace

    from synth.design.stages import with_held_out
    from synth.design.write import write_fit_responses
    from synth.errors import Problem, UserError
    from synth.files.leg import write_leg
    from synth.files.output import output_folder, write_json
    from synth.files.projects import read_fit_project
    from synth.fit.estimate import FitOptions
    from synth.fit.methods import fit_by, require_method
    from synth.fit.recordings import recordings
    from synth.parts.catalog import Catalogue
    from synth.parts.resolver import resolver

    with progress.stage("reading the project"):
        project = read_fit_project(arguments.file, resolve_part=resolver(Catalogue.load()))
        choice = fit_choice(project.fit, arguments)
        require_method(choice, str(project.path), static=bool(project.static), prior=project.prior is not None)
        fitted = [trial for trial in project.trials if not trial.held_out]
        if not fitted:
            text = "every trial is held out; at least one must be fitted"
            raise UserError(Problem(text, str(project.path), key="trials"))
        curves = {j.name: j.damper.curve for j in project.leg.joints if j.damper and j.damper.curve}
        made = recordings(project.leg, fitted)
        held_out = recordings(project.leg, [trial for trial in project.trials if trial.held_out], ())
    if arguments.dry_run:
        progress.say(f"{arguments.file} can be used: {len(project.trials)} trials, {len(project.inputs)} files")
        return 0
    with output_folder(arguments.out) as folder:
        progress.compiling(len(project.leg.joints))
        with progress.stage("fitting"):
            options = FitOptions(
                project.free_angle,
                choice.weight,
                curves,
                choice.seed,
                project.prior,
                static=project.static,
                intervals=choice.intervals,
            )
            result = with_held_out(fit_by(project.leg, made, options, choice), held_out)
            inputs = {item.name: item.sha256 for item in project.inputs}
            inputs |= {trial.name: trial.sha256 for trial in project.trials}
            result = replace(result, inputs=inputs)
        with progress.stage("writing"):
            write_json(folder / "fit.json", result.as_json())
            write_leg(result.leg, folder / "fitted.leg.yaml")
            write_fit_responses(result, folder / "responses" / "source")
            from reports import write_fit_report

            write_fit_report(folder)
    for sentence in (*result.warnings, *result.not_separable):
        progress.say(f"note: {sentence}")
    for proposal in result.proposals:
        progress.say(f"worth measuring: {proposal.sentence}")
    progress.say(f"fit: {Path(arguments.out) / 'fit.json'}")
    return 0
