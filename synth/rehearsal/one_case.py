"""One case in a separate process: planted here, diagnosed by another process that cannot read the answer."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import synth
from synth.files.output import output_folder, write_json
from synth.planting.refusals import NotApplicable, TooSmall
from synth.rehearsal.case_files import write_case
from synth.rehearsal.outcome import CANNOT, FAILED, CaseOutcome, explanations_of, named_causes
from synth.rehearsal.plants import Field, Planted, PlantingTask
from synth.rehearsal.users_rig import Rig, users_rig

if TYPE_CHECKING:
    from synth.files.gap_project import GapProject

PACKAGE = Path(synth.__file__).resolve().parent
LONGEST_DIAGNOSIS = 900.0  # s per diagnosis; a longer one counts as failed
TRUTH_FILE = "truth.json"
MOST_MESSAGE = 400  # characters of a failed diagnosis' message


@dataclass(frozen=True)
class CaseCall:
    """A task on a project file; ``kept`` : the folder of finished answers, closed to the diagnosis."""

    project: str
    kept: str
    seed: int
    task: PlantingTask
    effects: tuple[str, ...] = ()  # files of the user's own effects, which the diagnosis includes
    cases: str = ""  # folder in which the case is kept, with its answer; empty: it is not


def plant_and_diagnose(call: CaseCall) -> dict[str, Any]:
    """Plant and diagnose; ``CaseOutcome.as_json``."""
    project, rig = _read_project_and_rig(call.project)
    task = call.task
    try:
        planted = _plant_case(call)
    except (NotApplicable, ArithmeticError, np.linalg.LinAlgError) as why:
        names = {-1: "base", -2: "all", **dict(enumerate(rig.nominal.names))}
        none = CaseOutcome(task, (task.effect, names[task.joint]), "", 0.0, None, (), CANNOT, (), 0.0)
        return replace(none, message=_reason(why)).as_json()
    with tempfile.TemporaryDirectory(prefix="synth-rehearsal-") as folder:
        case = write_case(project, rig, planted, Path(folder))
        closed = [Path(call.kept), *([Path(call.cases)] if call.cases else [])]
        document, message = diagnose_apart(case, Path(folder) / "out", closed, call.effects)
    if call.cases:
        _keep_case(call, planted)
    return _case_outcome(task, planted, document, message).as_json()


def keep_planted(call: CaseCall) -> None:
    """Write a case that was diagnosed before into ``call.cases``, unless it is there."""
    if not (Path(call.cases) / call.task.name).exists():
        _keep_case(call, _plant_case(call))


def _keep_case(call: CaseCall, planted: Planted) -> None:
    """As a project beside ``truth.json``; what an earlier run left of it is replaced."""
    project, rig = _read_project_and_rig(call.project)
    with output_folder(Path(call.cases) / call.task.name) as folder:
        write_case(project, rig, planted, folder)
        write_json(folder / TRUTH_FILE, planted.answer)


@lru_cache(maxsize=1)
def _read_project_and_rig(path: str) -> tuple[GapProject, Rig]:
    from synth.files.gap_project import read_gap_project
    from synth.parts.resolver import resolver

    project = read_gap_project(path, resolve_part=resolver())
    return project, users_rig(project)


@lru_cache(maxsize=2)
def _plant_field(path: str, seed: int, draw: int) -> Field:
    return Field.of(_read_project_and_rig(path)[1], seed, draw)


def _reason(why: Exception) -> str:
    """Why a cause cannot be planted; empty: only not as large."""
    if isinstance(why, TooSmall):
        return ""
    return str(why) if isinstance(why, NotApplicable) else "its motion cannot be simulated"


def _plant_case(call: CaseCall) -> Planted:
    task = call.task
    letters = [ord(letter) for letter in task.effect]
    rng = np.random.default_rng([call.seed, task.draw, task.rung, task.joint + 2, *letters])
    return _plant_field(call.project, call.seed, task.draw).plant(rng, task)


def diagnose_apart(
    case: Path, out: Path, closed: list[Path], effects: Sequence[str] = ()
) -> tuple[dict[str, Any] | None, str]:
    """``gap.json`` of a case from a process that cannot read these folders or the generator; or None and the reason."""
    folders = [*closed, PACKAGE / "planting", PACKAGE / "rehearsal"]
    command = [sys.executable, str(PACKAGE / "commands" / "watched.py")]
    command += [os.pathsep.join(os.path.realpath(folder) for folder in folders), "--ends-with-input", "--"]
    command += ["gap", str(case), "--out", str(out), "--quiet"]
    command += [word for file in effects for word in ("--effect", file)]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(PACKAGE.parent), os.environ.get("PYTHONPATH", "")])}
    heard, held = os.pipe()  # closes with this process, however it ends, and the diagnosis ends then
    try:
        ended = subprocess.run(
            command,
            stdin=heard,
            cwd=case.parent,
            env=environment,
            capture_output=True,
            text=True,
            timeout=LONGEST_DIAGNOSIS,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return None, f"longer than {LONGEST_DIAGNOSIS:g} s"
    finally:
        os.close(heard)
        os.close(held)
    if ended.returncode:
        return None, f"{_end_in_words(ended.returncode)}: {ended.stderr[-MOST_MESSAGE:].strip()}".removesuffix(": ")
    return json.loads((out / "gap.json").read_text(encoding="utf-8")), ""


def _end_in_words(status: int) -> str:
    """How a process ended: by its exit status, or by a signal, which says nothing on its error output."""
    if status >= 0:
        return f"exit status {status}"
    try:
        return f"killed by {signal.Signals(-status).name}"
    except ValueError:
        return f"killed by signal {-status}"


def _case_outcome(task: PlantingTask, planted: Planted, document: dict[str, Any] | None, message: str) -> CaseOutcome:
    causes = planted.answer["causes"]
    main: dict[str, Any] = causes[0] if causes else {"form": "", "gap": 0.0, "size": None}
    key = (main["effect"], main["joint"]) if causes else None
    small = tuple((effect, joint) for effect, joint in planted.answer["small"])
    if document is None:
        failed = CaseOutcome(task, key, main["form"], main["gap"], main["size"], small, FAILED, (), 0.0, message)
        return replace(failed, truth=planted.answer["truth"])
    named = named_causes(document)
    first = [c["probability"] for c in document["ranked"] if named and (c["effect"], c["joint"]) == named[0]]
    probability = float(first[0]) if first else 0.0
    made = CaseOutcome(
        task, key, main["form"], main["gap"], main["size"], small, document["verdict"], named, probability
    )
    made = replace(made, explanations=explanations_of(document), truth=planted.answer["truth"])
    return replace(made, small_gap=planted.answer["small_gap"])
