"""``synth hopper``: gear motor, ratio and link length of a jumping leg, from motors that exist.

The study's three experiments are read from files of kind hopper-motor (run-ups: the motor's constants), hopper-pull-ups
(inverted pull-ups: one joint damping) and hopper-jumps (force plate and encoders: each model against the jumps).

A sweep that was interrupted, even killed, goes on where it stopped when the same command is given again. Many designs
can be simulated on a Dask cluster (--scheduler); a worker that dies loses nothing, and the bytes are the same.
"""

from __future__ import annotations

import argparse
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

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
    parser.add_argument("--truth", action="store_true", help="no file: hold the models against the published leg")
    parser.add_argument("--out", metavar="DIR", required=True, help="folder to write, whole or not at all")
    parser.add_argument("--no-cad", action="store_true", help="leave the parts out")
    cluster_argument(parser)
    parser.add_argument("--dry-run", action="store_true", help="read and check everything, write nothing")


def run(arguments: argparse.Namespace, progress: Progress) -> int:
    """Sweep, choose, write."""
    from synth.errors import UserError

    if arguments.truth == (arguments.file is not None):
        raise UserError("synth hopper takes a project file, or --truth and none: the published leg has its own numbers")
    if arguments.truth:
        _require_here(arguments, "the published leg is simulated here in a minute")
        _truth(arguments, progress)
        return 0
    from synth.files.hopper_project import read_hopper_project
    from synth.files.hopper_recordings import KINDS, kind_of
    from synth.hopper.study import sweep_problem
    from synth.parts.catalogs import Catalogue

    if (kind := kind_of(arguments.file)) in KINDS:
        _require_here(arguments, f"a file of kind {kind} is identified here in seconds")
        _identify(kind, arguments, progress)
        return 0
    with progress.stage("reading the project"):
        project = read_hopper_project(arguments.file)
        catalogue = Catalogue.load(project.catalogs)
        problem, _ = sweep_problem(project, catalogue)
    if arguments.dry_run:
        progress.say(f"{arguments.file} can be used: {len(problem.motors)} motors by {len(problem.lengths)} lengths")
        return 0
    _design(project, catalogue, arguments, progress)
    return 0


def _require_here(arguments: argparse.Namespace, why: str) -> None:
    from synth.errors import Problem, UserError

    if arguments.scheduler is not None:
        raise UserError(Problem(f"is for the sweep of a hopper-design; {why}", key="--scheduler"))


def _design(project: HopperProject, catalogue: Catalogue, arguments: argparse.Namespace, progress: Progress) -> None:
    from synth.commands.answers import hopper_text, tell
    from synth.commands.laminate_parts import draw_parts
    from synth.files.output import output_folder
    from synth.hopper.checkpoint import Checkpoint
    from synth.hopper.study import study
    from synth.hopper.write_study import write_designs, write_jump
    from synth.jump.jump_runs import compiled_jump

    with output_folder(arguments.out) as folder, ExitStack() as stack:
        cluster = None
        if arguments.scheduler is not None:
            from synth.batch.cluster import connected

            with progress.stage(f"connecting to {arguments.scheduler}"):
                cluster = stack.enter_context(connected(arguments.scheduler))
        checkpoint = Checkpoint(Path(arguments.out), _identity(project, catalogue))
        if checkpoint.finished:
            progress.say(f"going on with an interrupted sweep: {checkpoint.finished} chunks are done")
        with progress.stage("loading the compiled jump (compiled once on this machine, some 15 s)"):
            compiled_jump(project.leg.bending)
        found = study(project, catalogue, checkpoint, progress.stage, _tenths(progress), cluster)
        with progress.stage("writing the designs"):
            write_designs(found, folder / "designs.csv")
            write_jump(found, folder / "jump.csv")
        parts: dict[str, Any] = {}
        if not arguments.no_cad:
            with progress.stage("drawing the chosen leg's parts"):
                parts = draw_parts(found, folder)
        with progress.stage("writing the report"):
            _report(found, folder, parts)
    checkpoint.remove()
    tell(progress, Path(arguments.out) / "hopper.json", hopper_text)
    progress.say(f"result: {Path(arguments.out) / 'hopper.json'}")
    progress.say(f"report: {Path(arguments.out) / 'report.html'}")


def _tenths(progress: Progress) -> Callable[[int, int], None]:
    """Say each tenth of a sweep of many chunks."""

    def told(done: int, count: int) -> None:
        if count >= 20 and done * 10 // count > (done - 1) * 10 // count and done < count:
            progress.say(f"  {done * 10 // count * 10} % of the designs are done")

    return told


def _identity(project: HopperProject, catalogue: Catalogue) -> dict[str, str]:
    """What a sweep's numbers hang on."""
    from hashlib import sha256

    import synth

    motors = sha256(repr(catalogue.motors).encode()).hexdigest()
    files = {item.name: item.sha256 for item in project.inputs}
    return {"project file": sha256(repr(sorted(files.items())).encode()).hexdigest(), "catalogue": motors,
            "version of synth": synth.__version__}  # fmt: skip


def _report(found: Any, folder: Path, parts: dict[str, Any]) -> None:
    from reports.hopper import write_hopper_report
    from synth.files.output import write_json
    from synth.hopper.write_study import hopper_json

    files = sorted(path for path in folder.rglob("*") if path.is_file())
    write_json(folder / "hopper.json", hopper_json(found, files, folder) | ({"parts": parts} if parts else {}))
    write_hopper_report(folder)


def _identify(kind: str, arguments: argparse.Namespace, progress: Progress) -> None:
    """One of the study's three experiments on recorded data."""
    from synth.files import hopper_recordings as files
    from synth.files.output import output_folder, place, write_csv, write_json
    from synth.hopper import write_identified as write
    from synth.hopper.identify_damping import identify_damping
    from synth.hopper.identify_motor import identify_motor
    from synth.hopper.validate_jumps import validate
    from synth.parts.catalogs import Catalogue

    with output_folder(arguments.out) as folder, progress.stage(f"reading and identifying, {kind}"):
        if kind == "hopper-motor":
            runs = files.read_motor_runs(arguments.file)
            found = write.head(kind, runs.name, runs.inputs) | write.motor_json(identify_motor(runs.runs, runs.ratio))
        elif kind == "hopper-pull-ups":
            pulls = files.read_pull_ups(arguments.file)
            found = write.head(kind, pulls.name, pulls.inputs) | write.damping_json(identify_damping(pulls))
        else:
            jumps = files.read_plate_jumps(arguments.file)
            result = validate(jumps, Catalogue.load(jumps.design.catalogs))
            write_csv(folder / "first_jump.csv", result.curves)
            found = write.head(kind, jumps.name, jumps.inputs) | write.validation_json(result)
        write_json(place(folder, f"{kind.removeprefix('hopper-')}.json"), found)
    for line in write.lines(found):
        progress.say(line)
    progress.say(f"result: {Path(arguments.out) / (kind.removeprefix('hopper-') + '.json')}")


def _truth(arguments: argparse.Namespace, progress: Progress) -> None:
    """The models against what was published, on a page of its own."""
    from reports.hopper import write_truth_report
    from synth.files.output import output_folder, write_json
    from synth.hopper.truth import truth_json
    from synth.parts.catalogs import Catalogue

    with output_folder(arguments.out) as folder:
        with progress.stage("simulating the published leg and its neighbours by every model"):
            write_json(folder / "truth.json", truth_json(Catalogue.load()))
        with progress.stage("writing the page"):
            write_truth_report(folder)
    progress.say(f"page: {Path(arguments.out) / 'report.html'}")
