"""``synth fit`` on a folder: fit every project in it, on all cores or on a Dask cluster."""

from __future__ import annotations

import os
import shutil
import traceback
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from synth.batch.cluster import connected
from synth.batch.folder import FolderProjects, Kept, find_projects, identity_of
from synth.batch.folder_summary import Failed, fits_json, messages, table
from synth.batch.local import run_here
from synth.batch.one_fit import fit_files, ready
from synth.batch.task_outcome import Ended
from synth.commands.streams import write_message
from synth.errors import Problem, UserError
from synth.files.output import output_folder, place, write_csv, write_json
from synth.files.projects import read_fit_project
from synth.parts.catalogs import Catalogue
from synth.parts.resolver import resolver

if TYPE_CHECKING:
    import argparse

    from synth.commands.progress import Progress

Runner = Callable[[Callable[[Any], Any], Iterator[tuple[str, Any]]], Iterator[tuple[str, Ended]]]


def run_folder(arguments: argparse.Namespace, progress: Progress) -> int:
    """Fit every project of a folder; return 2 if one could not be fitted, 1 after an internal error."""
    _require_outside(Path(arguments.file), Path(arguments.out))
    with progress.stage("looking for projects"):
        found = find_projects(Path(arguments.file))
    if arguments.dry_run:
        return _dry_run(found, progress)
    with output_folder(arguments.out) as folder, ExitStack() as stack:
        runner = _runner(arguments, stack, progress, found)
        kept = Kept(Path(arguments.out))
        if kept.was_there:
            progress.say("resuming an interrupted run: finished, unchanged projects are kept")
        with progress.stage(f"fitting {len(found)} projects"):
            failed = _fit_all(found, kept, runner, progress)
        with progress.stage("writing"):
            _write(folder, [item.name for item in found], kept, failed)
    if failed:
        _tell_failed(failed, len(found), kept, progress)
    else:
        kept.remove()
    progress.say(f"fits: {Path(arguments.out) / 'fits.csv'}")
    progress.say(f"report: {Path(arguments.out) / 'report.html'}")
    return 1 if any(item.crash for item in failed) else 2 if failed else 0


def _require_outside(folder: Path, out: Path) -> None:
    """Refuse an output folder whose results would be read as projects, or overwrite them."""
    if Path(os.path.realpath(out)) == Path(os.path.realpath(folder)):
        raise UserError(Problem("contains the projects; name another folder", str(out), key="--out"))


def _dry_run(found: list[FolderProjects], progress: Progress) -> int:
    resolve = resolver(Catalogue.load())
    problems: list[Problem] = []
    trials = 0
    for item in found:
        try:
            if item.problems:
                raise UserError(list(item.problems))
            trials += len(ready(read_fit_project(item.path, resolve_part=resolve)).project.trials)
        except UserError as error:
            problems += error.problems
    if problems:
        raise UserError(problems)
    progress.say(f"{len(found)} valid projects, {trials} trials in total")
    return 0


def _runner(arguments: argparse.Namespace, stack: ExitStack, progress: Progress, found: list[FolderProjects]) -> Runner:
    """The cores of this machine, or the cluster."""
    if arguments.scheduler is not None:
        if arguments.workers is not None:
            raise UserError(Problem("applies to this machine; a cluster has its own workers", key="--workers"))
        with progress.stage(f"connecting to {arguments.scheduler}"):
            cluster = stack.enter_context(connected(arguments.scheduler))
        progress.say(f"{cluster.threads} parallel fits on the cluster")
        return cluster.run
    workers = min(arguments.workers or os.cpu_count() or 1, len(found))
    # Compiled before the workers start, so that only one process compiles. Most legs have three links.
    progress.compiling(3, effects=False)
    return lambda function, calls: run_here(function, calls, workers)


def _fit_all(found: list[FolderProjects], kept: Kept, runner: Runner, progress: Progress) -> list[Failed]:
    resolve = resolver(Catalogue.load())
    failed: list[Failed] = []
    identities: dict[str, dict[str, str]] = {}
    done = 0

    def told(name: str, word: str) -> None:
        nonlocal done
        done += 1
        progress.say(f"  {done}/{len(found)} {name}: {word}")

    def refuse(name: str, problems: tuple[Problem, ...]) -> None:
        failed.append(Failed(name, messages(problems)))
        told(name, "cannot be fitted")

    def fault(name: str, crash: str) -> None:
        write_message(crash)
        failed.append(Failed(name, (crash.strip().splitlines()[-1],), crash=True))
        told(name, "internal error")

    def waiting() -> Iterator[tuple[str, Any]]:
        for item in found:
            if item.problems:
                refuse(item.name, item.problems)
                continue
            try:
                project = read_fit_project(item.path, resolve_part=resolve)
                identity = identity_of(project)
                if kept.has(item.name, identity):
                    told(item.name, "kept")
                    continue
            except UserError as error:
                refuse(item.name, tuple(error.problems))
                continue
            except Exception:  # one internal error must not stop the other projects
                fault(item.name, traceback.format_exc())
                continue
            identities[item.name] = identity
            yield item.name, project

    for name, ended in runner(fit_files, waiting()):
        if ended.value is not None:
            kept.save(name, identities.pop(name), ended.value)
            told(name, "fitted")
        elif ended.crash:
            fault(name, ended.crash)
        else:
            refuse(name, ended.problems)
    return sorted(failed, key=lambda item: item.name)


def _write(folder: Path, names: list[str], kept: Kept, failed: list[Failed]) -> None:
    from synth.reports.fits_page import write_fits_report

    without = {item.name for item in failed}
    fitted = [name for name in names if name not in without]
    for name in fitted:
        shutil.copytree(kept.files(name), place(folder / "legs", name))
    content = fits_json(folder, fitted, failed)
    write_json(folder / "fits.json", content)
    write_csv(folder / "fits.csv", table(content))
    write_fits_report(folder)


def _tell_failed(failed: list[Failed], count: int, kept: Kept, progress: Progress) -> None:
    """Printed last on stderr, also with --quiet."""
    lines = [f"synth: {item.name}: {message}\n" for item in failed for message in item.messages]
    write_message(f"synth: {len(failed)} of {count} projects could not be fitted:\n{''.join(lines)}")
    progress.say(f"correct them and repeat the command: finished results are kept in {kept.folder}")
