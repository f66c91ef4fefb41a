"""A rehearsal: rounds of planted cases on all cores, each stored when finished."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from synth.batch.folder import RunCheckpoint
from synth.batch.local import run_here
from synth.errors import UserError
from synth.rehearsal.ladder import round_of
from synth.rehearsal.one_case import CaseCall, keep_planted, plant_and_diagnose
from synth.rehearsal.outcome import FAILED, CaseOutcome
from synth.rehearsal.plants import RUNGS, PlantingTask, cause_places, unlisted_causes
from synth.rehearsal.users_rig import Rig, load_engine

# Cases without a main cause, and with a cause outside the library, per number of causes: a default rehearsal then
# estimates the rates of false alarms and of missed unlisted causes to a tenth or two.
OTHER_CASES = 8
CASES_A_CAUSE = 2  # default; fewer do not bisect for a rung
UNLISTED_RUNG = 2  # rung of causes outside the library: large enough to matter
OUTCOME_FILE = "outcome.json"
# Raised where a task is planted or recorded otherwise: finished cases of before are then not reused.
CASE_FORMAT = "4"
FOLDER_NOTE = "finished cases of an interrupted `synth gap --rehearse`; repeat the command to resume\n"


@dataclass
class Rehearsal:
    """The rehearsal's input: project file, rig, seed, ``count`` cases on ``workers`` processes, input hashes."""

    project: Path
    rig: Rig
    seed: int
    count: int
    workers: int
    identity: Mapping[str, str]
    effects: tuple[str, ...] = ()
    cases: str = ""  # folder in which cases are kept; empty: they are not
    outcomes: list[CaseOutcome] = field(default_factory=list)

    def run(self, kept: RunCheckpoint, earlier: Mapping[str, CaseOutcome], tell: Callable[[str], None]) -> None:
        """All cases; stored ones and those of ``earlier`` are reused, but a failed one is neither stored nor reused.

        It may have failed by the machine: killed for lack of memory, or slow beside other work.

        Raises
        ------
        UserError : every case of the first round failed.
        """
        wanted = cause_places(self.rig, self.seed)
        clock = _RunProgress(self.count)
        while len(self.outcomes) < self.count:
            tasks = self._next_round(wanted)
            made = dict(self._finished_cases(tasks, kept, earlier))
            for task, outcome in made.items():
                self._tell_outcome(task, outcome, clock, tell)
            rest = [task for task in tasks if task not in made]
            here = (str(self.project), str(kept.folder), self.seed)
            if self.cases:
                for task in (task for task, outcome in made.items() if outcome.counts):
                    keep_planted(CaseCall(*here, task, self.effects, self.cases))
            if rest:  # once, before each worker would
                load_engine(self.rig)
            calls = [(task.name, CaseCall(*here, task, self.effects, self.cases)) for task in rest]
            ended: dict[str, CaseOutcome] = {}
            for name, end in run_here(plant_and_diagnose, calls, min(self.workers, max(len(rest), 1))) if rest else ():
                if end.problems:
                    raise UserError(list(end.problems))
                if end.crash:
                    raise RuntimeError(end.crash)
                ended[name] = CaseOutcome.from_json(end.value)
                if ended[name].verdict != FAILED:
                    kept.save(name, self.identity, {OUTCOME_FILE: json.dumps(end.value).encode()})
                task = ended[name].task
                self._tell_outcome(task, ended[name], clock, tell, counted=False)
            self.outcomes += [made[t] if t in made else ended[t.name] for t in tasks]
            if all(outcome.verdict == FAILED for outcome in self.outcomes):
                raise UserError(f"every case failed: {self.outcomes[0].message.strip() or 'no message'}")

    def _next_round(self, wanted: Sequence[tuple[str, int]]) -> list[PlantingTask]:
        """The next round: a case of each cause, of a cause outside the library, and without a cause."""
        done: dict[tuple[str, int], list[CaseOutcome]] = {}
        for outcome in self.outcomes:
            done.setdefault((outcome.task.effect, outcome.task.joint), []).append(outcome)
        room = self.count - len(self.outcomes)
        others = max(min(len(wanted) // OTHER_CASES, room // OTHER_CASES), 0)
        number = sum(not outcome.task.effect for outcome in self.outcomes)
        rng = np.random.default_rng([self.seed, number, 0x57A])
        made = [PlantingTask("", 0, 0, number + i) for i in range(others)]
        made += [
            PlantingTask(e, j, UNLISTED_RUNG, number + i)
            for i, (e, j) in enumerate(unlisted_causes(self.rig, rng, others))
        ]
        made = list({task.name: task for task in made}.values())
        return made + round_of(wanted, done, room - len(made))

    def _finished_cases(
        self, tasks: Sequence[PlantingTask], kept: RunCheckpoint, earlier: Mapping[str, CaseOutcome]
    ) -> list[tuple[PlantingTask, CaseOutcome]]:
        found = []
        for task in tasks:
            if task.name in earlier and earlier[task.name].verdict != FAILED:
                found.append((task, earlier[task.name]))
            elif kept.has(task.name, self.identity):
                content = json.loads((kept.files(task.name) / OUTCOME_FILE).read_text(encoding="utf-8"))
                found.append((task, CaseOutcome.from_json(content)))
        return found

    def _tell_outcome(
        self,
        task: PlantingTask,
        outcome: CaseOutcome,
        clock: _RunProgress,
        tell: Callable[[str], None],
        *,
        counted: bool = True,
    ) -> None:
        clock.done += 1
        if not counted:
            clock.made += 1
        name = task.effect.replace("_", " ") or "nothing"
        where = f" ({outcome.planted[1]})" if outcome.planted else ""
        times = f", {RUNGS[task.rung]:g} times the remainder" if task.effect else ""
        word = "named" if outcome.right and outcome.kind == "cause" else outcome.taken_for
        word = "tied with " + ", ".join(outcome.tied_with) if outcome.tied and task.effect else word
        word = "failed: " + " ".join(outcome.message.split()) if outcome.verdict == FAILED else word.replace("_", " ")
        word += ", with one that is not there" if outcome.with_absent else ""
        tell(f"  {clock.done}/{self.count} {name}{where}{times}: {word}{'' if counted is True else clock.left()}")


@dataclass
class _RunProgress:
    """Finished cases, how many are of this run, and the remaining time at that pace."""

    count: int
    done: int = 0
    made: int = 0
    begun: float = field(default_factory=time.monotonic)

    def left(self) -> str:
        if not self.made:
            return ""
        seconds = (time.monotonic() - self.begun) / self.made * (self.count - self.done)
        # Up to 90 s in seconds, else in minutes.
        return f"; {seconds / 60:.0f} min left" if seconds >= 90 else f"; {seconds:.0f} s left"


def default_count(rig: Rig, seed: int) -> int:
    """Number of cases of a rehearsal for which none is stated: some for each cause, and some without a listed one."""
    causes = len(cause_places(rig, seed))
    return CASES_A_CAUSE * (causes + 2 * (causes // OTHER_CASES))
