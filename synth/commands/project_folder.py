"""A command on a folder: every project of its kind in it, on all cores or on a Dask cluster.

Projects that fail are listed at the end and do not stop the others. An interrupted or killed run resumes if the
command is repeated: finished projects are stored beside the result until all are complete.
"""

from __future__ import annotations

import os
import shutil
import traceback
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import synth
from synth.batch.cluster import connected
from synth.batch.folder import FolderProject, RunCheckpoint, find_projects
from synth.batch.folder_summary import Failed, messages
from synth.batch.folder_task import FolderTask, summary_json
from synth.batch.local import run_here
from synth.batch.task_outcome import TaskOutcome
from synth.commands.answers import folder_text, tell_document
from synth.commands.streams import write_message
from synth.errors import Problem, UserError
from synth.files.output import output_folder, place, write_csv, write_json
from synth.threads import core_count

if TYPE_CHECKING:
    import argparse

    from synth.commands.progress import Progress

CANNOT_BE_HAD, MISTAKE, INTERNAL = 1, 2, 70  # exit statuses, as in ``synth.cli``
Runner = Callable[[Callable[[Any], Any], Iterator[tuple[str, Any]]], Iterator[tuple[str, TaskOutcome]]]


def run_folder(arguments: argparse.Namespace, progress: Progress, task: FolderTask) -> int:
    """Perform the task on every project of a folder; returns the exit status.

    That is 1 if results have failed checks only, 2 if a project failed, 70 after an internal error.
    """
    _require_outside(Path(arguments.file), Path(arguments.out))
    with progress.stage("looking for projects"):
        found = find_projects(Path(arguments.file), task.kind, task.done)
    if arguments.dry_run:
        return _dry_run(found, task, progress)
    with output_folder(arguments.out) as folder, ExitStack() as stack:
        runner = _runner(arguments, stack, progress, found, task)
        kept = RunCheckpoint(Path(arguments.out), task.made)
        if kept.was_there:
            progress.say("resuming an interrupted run: finished, unchanged projects are kept")
        run = _FolderRun(task, found, kept, progress)
        with progress.stage(f"{len(found)} project{'s' * (len(found) != 1)} to be {task.done}"):
            failed = run.perform(runner)
        with progress.stage("writing"):
            content = _write(folder, [item.name for item in found], kept, failed, task)
    tell_document(progress, content, folder_text(task.columns(content)))
    refused = [Failed(entry["name"], task.refused(entry)) for entry in content["legs"] if task.refused(entry)]
    if failed or refused:
        _tell_failed(failed, refused, len(found), task, progress)
    if failed:
        progress.say(f"correct them and repeat the command: the others are kept in {kept.folder}")
    else:
        kept.remove()
    progress.say(f"{task.made}: {Path(arguments.out) / f'{task.made}.csv'}")
    progress.say(f"report: {Path(arguments.out) / 'report.html'}")
    if failed:
        return INTERNAL if any(item.crash for item in failed) else MISTAKE
    return CANNOT_BE_HAD if refused else 0


def _require_outside(folder: Path, out: Path) -> None:
    """Refuse an output folder whose results would be the next run's projects, or overwrite them."""
    if Path(os.path.realpath(out)) == Path(os.path.realpath(folder)):
        raise UserError(Problem("is the folder of the projects; name another", str(out), key="--out"))


def _dry_run(found: list[FolderProject], task: FolderTask, progress: Progress) -> int:
    problems: list[Problem] = []
    trials = 0
    for item in found:
        try:
            if item.problems:
                raise UserError(list(item.problems))
            trials += task.checked(task.read(item.path))
        except UserError as error:
            problems += error.problems
    if problems:
        raise UserError(problems)
    progress.say(f"{len(found)} projects can be used, {trials} trials in all")
    return 0


def _runner(
    arguments: argparse.Namespace, stack: ExitStack, progress: Progress, found: list[FolderProject], task: FolderTask
) -> Runner:
    """The cores of this machine, or the cluster."""
    if arguments.scheduler is not None:
        if arguments.workers is not None:
            raise UserError(Problem("applies to this machine; a cluster has its own workers", key="--workers"))
        if arguments.effect:
            text = (
                "is a file of this machine; offer your effect to a cluster's workers by a package (see docs/extend.md)"
            )
            raise UserError(Problem(text, arguments.effect[0], key="--effect"))
        with progress.stage(f"connecting to {arguments.scheduler}"):
            cluster = stack.enter_context(connected(arguments.scheduler))
        progress.say(f"{cluster.threads} projects at once on the cluster")
        return cluster.run
    workers = min(arguments.workers or core_count(), len(found))
    # Compiled here, so that not every worker compiles the same; most legs have three links.
    progress.compiling(3, effects=task.effects)
    return lambda function, calls: run_here(function, calls, workers)


@dataclass
class _FolderRun:
    """The work on a folder's projects; each finished one is stored at once."""

    task: FolderTask
    found: list[FolderProject]
    kept: RunCheckpoint
    progress: Progress
    failed: list[Failed] = field(default_factory=list)
    identities: dict[str, dict[str, str]] = field(default_factory=dict)
    done: int = 0

    def perform(self, runner: Runner) -> list[Failed]:
        """Perform the remaining projects; return those that failed, by name."""
        for name, ended in runner(self.task.files, self._waiting()):
            if ended.value is not None:
                self.kept.save(name, self.identities.pop(name), ended.value)
                self._tell(name, self.task.done)
            elif ended.crash:
                self._fault(name, ended.crash)
            else:
                self._refuse(name, ended.problems)
        return sorted(self.failed, key=lambda item: item.name)

    def _waiting(self) -> Iterator[tuple[str, Any]]:
        """Every project that is not stored, read on demand, so that few are in memory."""
        for item in self.found:
            if item.problems:
                self._refuse(item.name, item.problems)
                continue
            try:
                project = self.task.read(item.path)
                identity = self.task.identity(project)
                if self.kept.has(item.name, identity):
                    self._tell(item.name, "kept")
                    continue
            except UserError as error:
                self._refuse(item.name, tuple(error.problems))
                continue
            except Exception:  # an internal error in one project must not lose the others
                self._fault(item.name, traceback.format_exc())
                continue
            self.identities[item.name] = identity
            yield item.name, project

    def _tell(self, name: str, word: str) -> None:
        self.done += 1
        self.progress.say(f"  {self.done}/{len(self.found)} {name}: {word}")

    def _refuse(self, name: str, problems: tuple[Problem, ...]) -> None:
        self.failed.append(Failed(name, messages(problems)))
        self._tell(name, f"cannot be {self.task.done}")

    def _fault(self, name: str, crash: str) -> None:
        write_message(crash)
        self.failed.append(Failed(name, (crash.strip().splitlines()[-1],), crash=True))
        self._tell(name, "internal error")


def _write(
    folder: Path, names: list[str], kept: RunCheckpoint, failed: list[Failed], task: FolderTask
) -> dict[str, Any]:
    without = {item.name for item in failed}
    finished = [name for name in names if name not in without]
    for name in finished:
        shutil.copytree(kept.files(name), place(folder / "legs", name))
    content = summary_json(task, folder, finished, failed, synth.__version__)
    write_json(place(folder, f"{task.made}.json"), content)
    write_csv(place(folder, f"{task.made}.csv"), task.columns(content))
    task.page(folder)
    return content


def _tell_failed(failed: list[Failed], refused: list[Failed], count: int, task: FolderTask, progress: Progress) -> None:
    """Report them last and on stderr, also when quiet."""
    for items, what in ((refused, "have failed checks"), (failed, f"could not be {task.done}")):
        lines = [f"synth: {item.name}: {message}\n" for item in items for message in item.messages]
        if items:
            write_message(f"synth: {len(items)} of {count} projects {what}:\n{''.join(lines)}")
