"""``synth gap --rehearse``: known causes simulated in the user's own leg and trials, and diagnosed blind."""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from synth.commands.table_text import table_text
from synth.errors import Problem, UserError
from synth.units import significant

if TYPE_CHECKING:
    from synth.commands.progress import Progress
    from synth.files.gap_project import GapProject
    from synth.rehearsal.outcome import CaseOutcome

Json = Mapping[str, Any]
CANNOT_BE_HAD = 1  # exit status, as in ``synth.cli``
MOST_WRONG = 8  # confusions and ties on the screen; JSON and page list all


def run_rehearsal(arguments: argparse.Namespace, progress: Progress, project: GapProject) -> int:
    """Rehearse; write ``rehearsal.json`` and a page. Finished cases of an earlier run are reused.

    Returns ``CANNOT_BE_HAD`` if some diagnosis failed: the counts are then of fewer cases than were asked for.
    """
    from synth.batch.folder import RunCheckpoint
    from synth.batch.folder_task import identity_of
    from synth.compiling.announced import told_to
    from synth.files.input_hashes import input_files
    from synth.files.output import output_folder, write_json
    from synth.files.run_manifest import sha256_file
    from synth.rehearsal.rehearsal_result import RehearsalResult
    from synth.rehearsal.rehearse import CASE_FORMAT, FOLDER_NOTE, Rehearsal, default_count
    from synth.rehearsal.users_rig import users_rig
    from synth.reports import write_rehearsal_report
    from synth.threads import core_count

    rig = users_rig(project)
    effects = tuple(os.path.realpath(file) for file in arguments.effect)
    identity = identity_of(project) | {file: sha256_file(file) for file in effects}
    identity |= {"project": project.path.name, "seed": str(project.seed), "cases": CASE_FORMAT}
    count = arguments.count or default_count(rig, project.seed)
    earlier = _earlier(Path(arguments.out), identity)
    progress.compiling(len(project.leg.joints))
    with output_folder(arguments.out, inputs=input_files(project)) as folder:
        kept = RunCheckpoint(Path(arguments.out), "rehearsal", FOLDER_NOTE)
        known = len(earlier)
        if kept.was_there or known:
            progress.say("reusing finished cases of the same input files")
        for text in rig.left_out:
            progress.say(f"note: {text}")
        workers = arguments.workers or core_count()
        work = Rehearsal(Path(os.path.realpath(project.path)), rig, project.seed, count, workers, identity, effects)
        work.cases = os.path.realpath(arguments.keep) if arguments.keep else ""
        with progress.stage(f"rehearsing {count} cases"), told_to(progress.stage):
            work.run(kept, earlier, progress.say)
        result = RehearsalResult(project.name, rig, project.seed, tuple(work.outcomes), identity)
        write_json(folder / "rehearsal.json", result.as_json())
        write_rehearsal_report(folder)
    kept.remove()
    content = json.loads((Path(arguments.out) / "rehearsal.json").read_text(encoding="utf-8"))
    if progress.as_json:
        progress.document(json.dumps(content))
    else:
        progress.result(rehearsal_text(content))
    progress.say(f"rehearsal: {Path(arguments.out) / 'rehearsal.json'}")
    progress.say(f"report: {Path(arguments.out) / 'report.html'}")
    if arguments.keep:
        progress.say(f"cases: {arguments.keep}")
    return CANNOT_BE_HAD if result.failed else 0


def _earlier(out: Path, identity: Mapping[str, str]) -> dict[str, CaseOutcome]:
    """Cases of a finished rehearsal in the output folder, if its input files are the same."""
    from synth.files.result_values import read_result
    from synth.rehearsal.outcome import CaseOutcome

    file = out / "rehearsal.json"
    if not file.is_file():
        return {}
    content = read_result(file, "rehearsal", ("plants", "identity"))
    if content["identity"] != dict(identity):
        return {}
    try:
        found = [CaseOutcome.from_json(item) for item in content["plants"]]
    except (KeyError, TypeError, IndexError):
        raise UserError(Problem("is not a rehearsal of this program; name another folder", str(file))) from None
    return {outcome.task.name: outcome for outcome in found}


def rehearsal_text(content: Json) -> str:
    """The answer, the smallest sizes found, the ties and the confusions."""
    answer = " ".join(words for key in ("sentence", "coverage") if (words := str(content.get(key) or "")))
    parts = [answer, "", "smallest size found:", _sizes(content["causes"], content["joints"])]
    tied, wrong = _most_frequent(content["causes"], "tied_with"), _most_frequent(content["causes"], "taken_for")
    if tied:
        parts += ["", "not distinguished from:", *tied]
    if wrong:
        parts += ["", "large, but taken for another cause:", *wrong]
    return "\n".join(parts)


def _sizes(causes: Sequence[Json], order: Sequence[str]) -> str:
    """One row per effect, one column per joint, in the ``order`` of the leg."""
    planted = {cause["joint"] for cause in causes}
    joints = [name for name in ("base", *order) if name in planted]
    found = {(cause["effect"], cause["joint"]): cause for cause in causes}
    rows = [["", *joints]]
    for effect in dict.fromkeys(cause["effect"] for cause in causes):
        rows.append([effect.replace("_", " "), *(_size(found.get((effect, joint))) for joint in joints)])
    return table_text(rows)


def _size(cause: Json | None) -> str:
    """The size; ``tied`` or ``not found`` with its cases if it never was; ``-`` where it was not planted."""
    if cause is None or not cause["cases"]:
        return "-"
    size = cause["visible_from"]
    if size is None:
        return f"tied ({cause['tied']} of {cause['cases']})" if cause["tied"] else f"not found (0 of {cause['cases']})"
    return f"{significant(size['value'], 2)} {size['unit']}"


def _most_frequent(causes: Sequence[Json], key: str) -> list[str]:
    pairs = [
        (count, f"{cause['effect'].replace('_', ' ')} ({cause['joint']})", name.replace("_", " "))
        for cause in causes
        for name, count in cause[key].items()
    ]
    pairs.sort(key=lambda item: -item[0])
    lines = [f"- {true}: {name}" + (f", {count} times" if count > 1 else "") for count, true, name in pairs]
    more = len(lines) - MOST_WRONG
    return lines[:MOST_WRONG] + ([f"and {more} more"] if more > 0 else [])
