"""``synth hopper``: gear motor, ratio and link length of a jumping leg, from available motors.

The study's three experiments are read from files of kind hopper-motor (run-ups: the motor's constants), hopper-pull-ups
(inverted pull-ups: one joint damping) and hopper-jumps (force plate and encoders: each model against the jumps).

Give the same command again to resume an interrupted sweep. Many designs can be simulated on a Dask cluster
(--scheduler); a lost worker loses no result, and the output is identical.
"""

from __future__ import annotations

import argparse
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING

from synth.commands.arguments import cluster_argument

if TYPE_CHECKING:
    from collections.abc import Callable

    from synth.commands.progress import Progress
    from synth.files.hopper_project import HopperProject
    from synth.parts.catalogs import Catalogue


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument(
        "file", nargs="?", help="project file, kind: hopper-design, hopper-motor, hopper-pull-ups or hopper-jumps"
    )
    parser.add_argument(
        "--truth", action="store_true", help="without a file: compare the models with the published leg"
    )
    parser.add_argument("--out", metavar="DIR", required=True, help="folder to write, whole or not at all")
    parser.add_argument("--no-cad", action="store_true", help="leave the parts out")
    cluster_argument(parser)
    parser.add_argument("--dry-run", action="store_true", help="read and check all input, write nothing")


def run(arguments: argparse.Namespace, progress: Progress) -> int:
    """Sweep, choose, write."""
    from synth.errors import UserError

    if arguments.truth == (arguments.file is not None):
        raise UserError("synth hopper takes either a project file or --truth")
    if arguments.truth:
        _require_here(arguments, "the published leg is simulated on this machine")
        if arguments.dry_run:
            progress.say("--truth reads no file: the published leg is part of the program")
            return 0
        _truth(arguments, progress)
        return 0
    from synth.api.hoppers import read_hopper
    from synth.files.hopper_recordings import KINDS, kind_of

    if (kind := kind_of(arguments.file)) in KINDS:
        _require_here(arguments, f"a file of kind {kind} is identified on this machine")
        if arguments.dry_run:
            _check_recordings(arguments, progress)
            return 0
        _identify(kind, arguments, progress)
        return 0
    with progress.stage("reading the project"):
        project, catalogue, motors = read_hopper(arguments.file)
    if arguments.dry_run:
        progress.say(f"{arguments.file} is valid: {motors} motors by {len(project.lengths)} lengths")
        return 0
    return 0 if _design(project, catalogue, arguments, progress) else 1


def _require_here(arguments: argparse.Namespace, why: str) -> None:
    from synth.errors import Problem, UserError

    if arguments.scheduler is not None:
        raise UserError(Problem(f"applies to the sweep of a hopper-design; {why}", key="--scheduler"))


def _design(project: HopperProject, catalogue: Catalogue, arguments: argparse.Namespace, progress: Progress) -> bool:
    """Sweep and write; return whether a design was chosen."""
    from synth.api.hoppers import hopper
    from synth.commands.answers import hopper_text, tell
    from synth.files.input_hashes import input_files
    from synth.files.output import output_folder
    from synth.hopper.checkpoint import Checkpoint

    with output_folder(arguments.out, inputs=input_files(project)) as folder, ExitStack() as stack:
        cluster = None
        if arguments.scheduler is not None:
            from synth.batch.cluster import connected

            with progress.stage(f"connecting to {arguments.scheduler}"):
                cluster = stack.enter_context(connected(arguments.scheduler))
        checkpoint = Checkpoint(Path(arguments.out), _identity(project, catalogue))
        if checkpoint.finished:
            progress.say(f"resuming an interrupted sweep: {checkpoint.finished} chunks are done")
        found = hopper(
            project, catalogue, checkpoint=checkpoint, cluster=cluster, stage=progress.stage, progress=_tenths(progress)
        )
        found.write_with(folder, parts=not arguments.no_cad, stage=progress.stage)
    checkpoint.remove()
    tell(progress, Path(arguments.out) / "hopper.json", hopper_text)
    progress.say(f"result: {Path(arguments.out) / 'hopper.json'}")
    progress.say(f"report: {Path(arguments.out) / 'report.html'}")
    return found.chosen


def _tenths(progress: Progress) -> Callable[[int, int], None]:
    """Report every tenth of a sweep with many chunks."""

    def report(done: int, count: int) -> None:
        # A tenth of fewer chunks is less than two.
        if count >= 20 and done * 10 // count > (done - 1) * 10 // count and done < count:
            progress.say(f"  {done * 10 // count * 10} % of the designs done")

    return report


def _identity(project: HopperProject, catalogue: Catalogue) -> dict[str, str]:
    """The input on which the sweep's results depend."""
    from hashlib import sha256

    from synth.files.input_hashes import input_hashes
    from synth.files.program_versions import versions

    files = sorted(input_hashes(project).items())
    named = {"project file": repr(files), "catalogue": repr(catalogue.motors)}
    of_programs = {f"version of {name}": version for name, version in versions().items()}
    return {name: sha256(text.encode()).hexdigest() for name, text in named.items()} | of_programs


def _check_recordings(arguments: argparse.Namespace, progress: Progress) -> None:
    """Read recorded data and say what there is."""
    from synth.api.hopper_experiments import read_experiment

    with progress.stage("reading the recordings"):
        read = read_experiment(arguments.file).inputs
    names = ", ".join(item.name for item in read)
    progress.say(f"{arguments.file} is valid; read: {names}")


def _identify(kind: str, arguments: argparse.Namespace, progress: Progress) -> None:
    """One of the study's three experiments from recorded data."""
    from synth.api.hopper_experiments import hopper_experiment
    from synth.commands.answers import tell
    from synth.files.output import output_folder, place, write_csv, write_json

    read = [Path(arguments.file)]
    with output_folder(arguments.out, inputs=read) as folder, progress.stage(f"reading and identifying, {kind}"):
        found = hopper_experiment(arguments.file)
        if found.first_jump is not None:
            write_csv(folder / "first_jump.csv", found.first_jump)
        if found.motor_row is not None:
            write_csv(folder / "motor.csv", found.motor_row)
        write_json(place(folder, found.file_name), dict(found.content))
    tell(progress, Path(arguments.out) / found.file_name, lambda _: "\n".join(found.lines()), notes=())
    progress.say(f"result: {Path(arguments.out) / found.file_name}")


def _truth(arguments: argparse.Namespace, progress: Progress) -> None:
    """The models compared with published results, on a page."""
    from synth.files.output import output_folder, write_json
    from synth.parts.catalogs import Catalogue
    from synth.reports.hopper_pages import write_truth_report
    from synth.validation.published_leg import truth_json

    with output_folder(arguments.out) as folder:
        with progress.stage("simulating the published leg and its neighbours with every model"):
            write_json(folder / "truth.json", truth_json(Catalogue.load()))
        with progress.stage("writing the page"):
            write_truth_report(folder)
    if progress.as_json:
        progress.document((Path(arguments.out) / "truth.json").read_text(encoding="utf-8"))
    progress.say(f"page: {Path(arguments.out) / 'report.html'}")
