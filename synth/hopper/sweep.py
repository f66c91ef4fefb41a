"""All motors by all lengths: jumps in chunks on every core, then limits, the Pareto front and the choice."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.errors import UserError
from synth.hopper.checkpoint import Checkpoint
from synth.hopper.hopper_tolerances import intervals, outcomes_of_copies, torque_interval
from synth.jump.hopper_leg import Contact, HopperLeg, HopperTolerances, Motor, in_reach
from synth.jump.jump_models import Model, lanes
from synth.jump.jump_runs import compiled_jump
from synth.jump.outcomes import (
    LANDED_AGAIN,
    LIMITS,
    N_OUTCOME,
    OUT_OF_REACH,
    OUTCOMES,
    STATUS,
    TOO_STIFF,
    column_of,
    known_heights,
)
from synth.jump.point_mass import point_mass_outcomes
from synth.threads import as_they_finish

if TYPE_CHECKING:
    from synth.batch.cluster import Cluster

N_ROWS = N_OUTCOME + 4  # of a chunk: outcomes, low and high of the clearance, low and high of the peak gear torque
CHUNK = 2048  # designs, a third of a second of one core without intervals
OBJECTIVES = {  # name -> +1 more is better, -1 less is
    "clearance": 1, "relative_height": 1, "total_height": 1, "energy": -1, "peak_gear_torque": -1,
}  # fmt: skip
Limiting = Literal["warn", "stop"]


@dataclass(frozen=True)
class SweepProblem:
    """The sweep: legs of ``lengths`` (m) by ``motors``, by one model."""

    leg: HopperLeg
    motors: tuple[Motor, ...]
    tolerances: tuple[HopperTolerances, ...]  # one a motor
    lengths: tuple[float, ...]
    contact: Contact
    model: Model
    with_intervals: bool
    height: str = "clearance"  # or total: the height for relative heights

    @property
    def size(self) -> int:
        """Number of designs."""
        return len(self.motors) * len(self.lengths)


@dataclass(frozen=True, eq=False)
class Sweep:
    """Every design's outcome; all arrays (n_design,), motor by motor, lengths rising.

    ``clearance_low``, ``clearance_high``: nan if no interval was requested, or a copy for it is too stiff or
    cannot start.
    """

    problem: SweepProblem
    motor: NDArray[np.int64]
    length: Array
    status: Array
    values: dict[str, Array]  # clearance, total_height, relative_height, energy, peak_gear_torque, peak_current, ...
    clearance_low: Array
    clearance_high: Array
    torque_ends: Array  # (2, n_design) N m, low and high of the peak gear torque; nan as those of the clearance

    def over_limit(self) -> NDArray[np.bool_]:
        """Designs whose gear torque in the push exceeds their gearbox's limit; none where that is not known."""
        return np.asarray(self.values["peak_gear_torque"] > self.limits())

    def limits(self) -> Array:
        """(n_design,) N m, what their gearboxes bear; infinite where it is not known."""
        limits = np.array([np.inf if m.torque_limit is None else m.torque_limit for m in self.problem.motors])
        return np.asarray(limits[self.motor])

    def without_limit(self) -> NDArray[np.bool_]:
        """Designs that jump with a motor whose gearbox's limit is not known: no torque is held against one."""
        unknown = np.array([m.torque_limit is None for m in self.problem.motors])
        return np.asarray((self.status == LANDED_AGAIN) & unknown[self.motor])

    def feasible(self, gearbox: Limiting) -> NDArray[np.bool_]:
        """Designs that jump, and with ``stop`` respect the gearbox's limit where one is known."""
        jumps = self.status == LANDED_AGAIN
        return np.asarray(jumps & ~self.over_limit()) if gearbox == "stop" else np.asarray(jumps)

    def limits_text(self, which: NDArray[np.bool_]) -> str:
        """The gearboxes' limits of these designs, which all have one."""
        limits = sorted({self.problem.motors[m].torque_limit or 0.0 for m in np.unique(self.motor[which])})
        if len(limits) == 1:
            return f"the gearbox's {limits[0]:.3f} N*m"
        return f"their gearboxes' {limits[0]:.3f} to {limits[-1]:.3f} N*m"

    def limit_text(self, index: int) -> str:
        """The limit of a design; empty if there is none."""
        if self.status[index] == OUT_OF_REACH:
            return "the crouch is out of the links' reach"
        if self.status[index] != LANDED_AGAIN:
            return LIMITS[int(self.status[index])]
        limit = self.problem.motors[self.motor[index]].torque_limit
        torque = self.values["peak_gear_torque"][index]
        if limit is not None and torque > limit:
            return f"gear torque {torque:.3f} N*m above the gearbox's {limit:.3f} N*m"
        return ""


def run_sweep(
    problem: SweepProblem,
    checkpoint: Checkpoint | None = None,
    *,
    workers: int | None = None,
    cluster: Cluster | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Sweep:
    """Simulate every design.

    Parameters
    ----------
    checkpoint : storage of finished chunks.
    workers : threads; default as many as cores.
    cluster : where the chunks are computed instead; they are stored here.
    progress : called by this thread with finished and total chunks.

    Raises
    ------
    UserError : the cluster is gone, or a chunk fails on every worker.
    """
    count = -(-problem.size // CHUNK)
    rows: list[Array | None] = [checkpoint.load(index) if checkpoint is not None else None for index in range(count)]
    missing = [index for index in range(count) if rows[index] is None]

    chunks = _on_threads(problem, missing, workers) if cluster is None else _on_cluster(problem, missing, cluster)
    for done, (index, found) in enumerate(chunks, count - len(missing) + 1):  # stored and counted by this thread alone
        if checkpoint is not None:
            checkpoint.save(index, found)
        rows[index] = found
        if progress is not None:
            progress(done, count)
    return _collect(problem, np.concatenate([row for row in rows if row is not None], axis=1))


def _on_threads(problem: SweepProblem, missing: Sequence[int], workers: int | None) -> Iterator[tuple[int, Array]]:
    if problem.model.engine == "lanes":
        compiled_jump(problem.leg.bending)  # once, before threads need it
    elif problem.model.engine == "mujoco":
        workers = 1  # its callback for passive forces is global to the process
    for k, found in as_they_finish(lambda k: _chunk(problem, missing[k]), len(missing), workers):
        yield missing[k], found


def _on_cluster(problem: SweepProblem, missing: Sequence[int], cluster: Cluster) -> Iterator[tuple[int, Array]]:
    for key, ended in cluster.run(_chunk_of, ((str(index), (problem, index)) for index in missing)):
        if ended.crash:
            raise RuntimeError(f"chunk {key} of the sweep failed on a worker:\n{ended.crash}")
        if ended.problems:
            raise UserError(list(ended.problems))
        yield int(key), ended.value


_mujoco = threading.Lock()


def _chunk_of(given: tuple[SweepProblem, int]) -> Array:
    """One chunk, in a worker that may run several at once."""
    problem, index = given
    if problem.model.engine == "mujoco":
        with _mujoco:
            return _chunk(problem, index)
    return _chunk(problem, index)


def _chunk(problem: SweepProblem, index: int) -> Array:
    """(N_ROWS, n) outcomes, low and high of clearance and peak gear torque of one chunk's designs."""
    first, last = index * CHUNK, min((index + 1) * CHUNK, problem.size)
    lengths = np.array(problem.lengths)
    number = np.arange(first, last)
    motor, length = number // len(lengths), lengths[number % len(lengths)]
    found = np.zeros((N_ROWS, last - first))
    found[N_OUTCOME:] = np.nan
    found[STATUS] = OUT_OF_REACH
    reach = in_reach(problem.leg, length)
    for m in np.unique(motor):
        chosen = np.flatnonzero((motor == m) & reach)
        if len(chosen):
            found[:, chosen] = _jumps(problem, int(m), length[chosen])
    return found


def _jumps(problem: SweepProblem, index: int, length: Array) -> Array:
    motor, model = problem.motors[index], problem.model
    found = np.full((N_ROWS, len(length)), np.nan)
    if model.engine == "point":
        found[:N_OUTCOME] = point_mass_outcomes(problem.leg, motor, length)
        return found
    if model.engine == "mujoco":
        from synth.jump.mujoco_model import mujoco_jump

        for i, each in enumerate(length):
            jump = mujoco_jump(problem.leg.with_length(float(each)), motor, problem.contact, model)
            found[:N_OUTCOME, i] = column_of(jump.outcome)
        return found
    if not problem.with_intervals:
        jumper = compiled_jump(problem.leg.bending)
        found[:N_OUTCOME] = jumper.run(lanes(problem.leg, motor, problem.contact, model, length))
        return found
    made = outcomes_of_copies(problem.leg, motor, problem.contact, model, problem.tolerances[index], length)
    for i, outcome in enumerate(made):
        found[:N_OUTCOME, i] = outcome[:, 0]
        _, low, high = intervals(known_heights(outcome)[None, :])
        found[N_OUTCOME:, i] = low[0], high[0], *torque_interval(outcome)
    return found


def _collect(problem: SweepProblem, rows: Array) -> Sweep:
    n = len(problem.lengths)
    number = np.arange(problem.size)
    motor, length = number // n, np.array(problem.lengths)[number % n]
    status = rows[STATUS]
    reached = np.where(status == TOO_STIFF, 0.0, rows[:N_OUTCOME])  # what a jump had reached that did not end
    by_name = dict(zip(OUTCOMES, reached, strict=True))
    jumps = status == LANDED_AGAIN
    clearance = np.where(jumps, by_name["clearance"], 0.0)
    values = {
        "clearance": clearance,
        "relative_height": (by_name["apex"] if problem.height == "total" else clearance) / length,
        "total_height": by_name["apex"],
        "energy": by_name["energy"],
        "peak_gear_torque": by_name["peak_gear_torque"],
        "peak_current": by_name["peak_current"],
        "takeoff_speed": by_name["takeoff_speed"],
        "takeoff_time": by_name["takeoff_time"],
    }
    return Sweep(
        problem, motor, length, status, values, rows[N_OUTCOME], rows[N_OUTCOME + 1], rows[N_OUTCOME + 2 : N_ROWS]
    )


def pareto_front(sweep: Sweep, objectives: Sequence[str], allowed: NDArray[np.bool_]) -> list[int]:
    """Allowed designs not dominated by any other (Pareto front), best first objective first.

    Kung, Luccio & Preparata's order (J. ACM 22 (1975) 469-476): sorted by the first objective, each candidate is held
    against the front found so far.
    """
    index = np.flatnonzero(allowed)
    scores = np.stack([OBJECTIVES[name] * sweep.values[name][index] for name in objectives], axis=1)
    order = np.lexsort(tuple(-scores[:, k] for k in range(scores.shape[1] - 1, -1, -1)))
    if scores.shape[1] == 1:
        return [int(index[order[0]])] if len(order) else []
    if scores.shape[1] == 2:  # sorted by the first, a design is on the front if the second is a new maximum
        second = scores[order, 1]
        before = np.concatenate([[-np.inf], np.maximum.accumulate(second)[:-1]])
        return [int(index[i]) for i in order[second > before]]
    front: list[int] = []
    kept = np.empty_like(scores)
    for i in order:
        n = len(front)
        if not np.any(np.all(kept[:n] >= scores[i], axis=1)):
            kept[n] = scores[i]
            front.append(int(i))
    return [int(index[i]) for i in front]
