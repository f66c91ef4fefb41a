"""The complete study of a project: sweep, front, choice, cost of its neighbours, all models for the choice."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.errors import UserError
from synth.files.hopper_project import HopperProject, model_problem, motor_problem
from synth.files.hopper_sections import MOST_INTERVALS
from synth.hopper.checkpoint import Checkpoint
from synth.hopper.hopper_tolerances import contributions, half_width, intervals, outcomes_of_copies, torque_interval
from synth.hopper.motors import chosen_rows, motor_of
from synth.hopper.sweep import OBJECTIVES, Sweep, SweepProblem, pareto_front, run_sweep
from synth.jump.hopper_leg import HopperLeg, HopperTolerances, Motor, in_reach
from synth.jump.jump_layout import LAYOUTS
from synth.jump.jump_models import MODELS, lane
from synth.jump.jump_runs import compiled_jump, simulate
from synth.jump.mujoco_model import mujoco_jump, require_mujoco
from synth.jump.outcomes import APEX, CROSSED, LANDED_AGAIN, JumpOutcome, known_heights, outcome_of
from synth.jump.planar_jump import planar_jump
from synth.jump.point_mass import point_mass_outcomes
from synth.parts.catalogs import Catalogue
from synth.parts.rows import GearMotorRow

if TYPE_CHECKING:
    from synth.batch.cluster import Cluster

MOST_MUJOCO = 400  # designs of a sweep by model C: two minutes
Stage = Callable[[str], AbstractContextManager[None]]


@dataclass(frozen=True)
class Neighbour:
    """A design similar to the chosen one: the change, and its outcome."""

    change: str
    motor: Motor
    length: float
    outcome: JumpOutcome


@dataclass(frozen=True)
class LeaningDesign:
    """The chosen design by the planar form, leaning at the start."""

    pitch: float  # rad, at the start
    outcome: JumpOutcome
    final_pitch: float
    slip: float


@dataclass(frozen=True)
class LadderRung:
    """The chosen design by one model; ``own_contact``: on the ground contact of its engine and not on ours."""

    model: str
    outcome: JumpOutcome
    own_contact: bool = False

    @property
    def name(self) -> str:
        """The model, and the contact where it is another."""
        return f"{self.model}, its own contact" if self.own_contact else self.model


@dataclass(frozen=True, eq=False)
class Study:
    """All data of a project's result; ``best`` None if nothing jumps, or with ``gearbox: stop`` no gearbox bears it."""

    project: HopperProject
    rows: tuple[GearMotorRow, ...]
    sweep: Sweep
    front: list[int]
    low: Array
    high: Array
    best: int | None
    ladder: tuple[LadderRung, ...]
    ladder_notes: dict[str, str]
    neighbours: list[Neighbour]
    contributions: dict[str, tuple[float, float]]
    leaning: list[LeaningDesign]
    trace: Array | None
    total_ends: tuple[float, float] | None = None  # 90 % interval of the choice's total height, m
    torque_ends: Array = field(default_factory=lambda: np.empty((2, 0)))  # (2, n_design) N m, of the peak gear torque

    @property
    def best_leg(self) -> HopperLeg:
        """The leg of the chosen design."""
        assert self.best is not None
        return self.project.leg.with_length(float(self.sweep.length[self.best]))

    @property
    def best_motor(self) -> Motor:
        """The motor of the chosen design."""
        assert self.best is not None
        return self.sweep.problem.motors[int(self.sweep.motor[self.best])]

    @property
    def torque_after_takeoff(self) -> float | None:
        """Largest torque of one gear of the chosen design after takeoff, when it runs into its stop, N m.

        None without a choice, or with a model whose jump has no trace of its own.
        """
        if self.best is None or self.trace is None or not _has_lanes(self.sweep.problem):
            return None
        late = self.trace[:, 0] > self.sweep.values["takeoff_time"][self.best]
        gear = self.trace[late, 1 + LAYOUTS[self.project.leg.bending].row("gear_torque")]
        return float(np.abs(gear).max()) if len(gear) else None

    @property
    def breaks_after_takeoff(self) -> bool:
        """Whether that torque exceeds the gearbox's limit, which the designs are not judged by."""
        torque = self.torque_after_takeoff
        limit = None if torque is None else self.best_motor.torque_limit
        return torque is not None and limit is not None and torque > limit

    @property
    def over_limit_at_end(self) -> NDArray[np.bool_]:
        """Designs that jump within their gearbox's limit, which the upper 90 % end of their torque exceeds."""
        within = (self.sweep.status == LANDED_AGAIN) & ~self.sweep.over_limit()
        return np.asarray(within & (self.torque_ends[1] > self.sweep.limits()))

    @property
    def none_because(self) -> str:
        """Why there is no choice; empty if there is one."""
        if self.best is not None:
            return ""
        count, jumping = len(self.sweep.motor), self.sweep.status == LANDED_AGAIN
        if not jumping.any():
            crossed = int((self.sweep.status == CROSSED).sum())
            return f"none of the {count} designs " + (
                f"jumps: the knees of {crossed} cross, through their stop" if crossed else "lifts off"
            )
        return (
            f"{int(jumping.sum())} of {count} designs jump, but all exceed {self.sweep.limits_text(jumping)} "
            "(gearbox: stop)"
        )


def sweep_problem(project: HopperProject, catalogue: Catalogue) -> tuple[SweepProblem, tuple[GearMotorRow, ...]]:
    """The sweep, with the motors' rows.

    Raises
    ------
    UserError : a pattern matches no motor, or an incomplete one; the resistance does not suit a motor.
    """
    try:
        rows = chosen_rows(catalogue.motors, project.motors)
        motors = tuple(motor_of(row, project.motor_options) for row in rows)
    except UserError as error:
        raise UserError([motor_problem(project, problem.text) for problem in error.problems]) from None
    size = len(motors) * len(project.lengths)
    if MODELS[project.model].engine == "mujoco":
        require_mujoco()
        if size > MOST_MUJOCO:
            text = f'"{project.model}" takes a third of a second per design; {size} asked, at most {MOST_MUJOCO}:'
            raise UserError(model_problem(project, f"{text} write model: A, or fewer motors and lengths"))
    everywhere = project.intervals == "all" or (project.intervals == "auto" and size <= MOST_INTERVALS)
    tolerances = tuple(_tolerances(project, row) for row in rows)
    return SweepProblem(project.leg, motors, tolerances, project.lengths, project.contact, MODELS[project.model],
                   everywhere and MODELS[project.model].engine == "lanes", project.height), tuple(rows)  # fmt: skip


def study(
    project: HopperProject,
    catalogue: Catalogue,
    checkpoint: Checkpoint | None,
    stage: Stage,
    progress: Callable[[int, int], None] | None = None,
    cluster: Cluster | None = None,
) -> Study:
    """Run the whole study; the sweep on ``cluster`` if given, the rest here."""
    problem, rows = sweep_problem(project, catalogue)
    with stage(f"simulating {problem.size} designs with model {project.model}"):
        sweep = run_sweep(problem, checkpoint, cluster=cluster, progress=progress)
    allowed = sweep.feasible(project.gearbox)
    front = pareto_front(sweep, project.objectives, allowed) if allowed.any() else []
    low, high, torques = sweep.clearance_low.copy(), sweep.clearance_high.copy(), sweep.torque_ends.copy()
    best = _best(sweep, project.choose, allowed)
    if not problem.with_intervals and problem.model.engine == "lanes":
        with stage("intervals of the front"):
            for index in {*front, *([] if best is None else [best])}:
                found = _group(problem, index)
                _, low[index : index + 1], high[index : index + 1] = intervals(known_heights(found)[None, :])
                torques[:, index] = torque_interval(found)
    if best is None:
        return Study(project, rows, sweep, front, low, high, None, (), {}, [], {}, [], None,
                     torque_ends=torques)  # fmt: skip
    leg = project.leg.with_length(float(sweep.length[best]))
    motor = problem.motors[sweep.motor[best]]
    with stage("the chosen design by every model (the planar form compiles once on this machine, some 10 s)"):
        ladder, notes = run_ladder(leg, motor, problem)
        leaning = (
            [_lean_design(leg, motor, problem, angle) for angle in (0.0, 0.05, 0.1)] if _has_lanes(problem) else []
        )
    shown, changes, ends = MODELS["A"], {}, None
    if _has_lanes(problem):
        shown, copies = problem.model, _group(problem, best)
        changes = contributions(known_heights(copies))
        _, least, most = intervals(known_heights(copies, APEX)[None, :])
        ends = None if np.isnan(least[0]) else (float(least[0]), float(most[0]))
    return Study(
        project, rows, sweep, front, low, high, best, ladder, notes, _neighbours(problem, rows, best), changes,
        leaning, compiled_jump(leg.bending).trace(lane(leg, motor, problem.contact, shown)), ends, torques,
    )  # fmt: skip


def run_ladder(leg: HopperLeg, motor: Motor, problem: SweepProblem) -> tuple[tuple[LadderRung, ...], dict[str, str]]:
    """One design by every model; model C on both grounds if MuJoCo is installed, else a note on how to get it."""
    found: list[LadderRung] = []
    notes: dict[str, str] = {}
    for name, model in MODELS.items():
        if model.engine == "point":
            outcome = outcome_of(point_mass_outcomes(leg, motor, np.array([leg.length]))[:, 0])
            found.append(LadderRung(name, outcome))
        elif model.engine == "lanes":
            found.append(LadderRung(name, simulate([(leg, motor)], problem.contact, model)[0]))
        else:
            try:
                found.append(LadderRung(name, mujoco_jump(leg, motor, problem.contact, model).outcome))
                on_own = mujoco_jump(leg, motor, problem.contact, model, ground="own")
                found.append(LadderRung(name, on_own.outcome, own_contact=True))
            except UserError as error:
                notes[name] = error.problems[0].text
    return tuple(found), notes


def _has_lanes(problem: SweepProblem) -> bool:
    return problem.model.engine == "lanes"


def _tolerances(project: HopperProject, row: GearMotorRow) -> HopperTolerances:
    """Those that the project writes; else from the maker's limits, where it states any; else the defaults."""
    stated = {"speed": row.speed_tolerance, "current": row.current_tolerance}
    taken = {key: half_width(limit) for key, limit in stated.items() if limit is not None}
    return replace(project.tolerances, **{k: v for k, v in taken.items() if k not in project.written_tolerances})


def _best(sweep: Sweep, objective: str, allowed: NDArray[np.bool_]) -> int | None:
    if not allowed.any():
        return None
    score = np.where(allowed, OBJECTIVES[objective] * sweep.values[objective], -np.inf)
    return int(np.argmax(score))


def _group(problem: SweepProblem, index: int) -> Array:
    """Outcomes (n_outcome, 16) of a design and its copies at the tolerances' ends."""
    n = len(problem.lengths)
    m, length = index // n, problem.lengths[index % n]
    motor, tolerances = problem.motors[m], problem.tolerances[m]
    return next(outcomes_of_copies(problem.leg, motor, problem.contact, problem.model, tolerances, np.array([length])))


def _lean_design(leg: HopperLeg, motor: Motor, problem: SweepProblem, pitch: float) -> LeaningDesign:
    found = planar_jump(leg, motor, problem.contact, problem.model, pitch=pitch)
    return LeaningDesign(pitch, found.outcome, found.pitch, found.slip)


def _neighbours(problem: SweepProblem, rows: tuple[GearMotorRow, ...], best: int) -> list[Neighbour]:
    """One centimetre shorter and longer, one ratio less and more of the same motor among those swept."""
    n = len(problem.lengths)
    m, length = best // n, problem.lengths[best % n]
    cases: list[tuple[str, Motor, float]] = [("as chosen", problem.motors[m], length)]
    for change, other in (("1 cm shorter", length - 0.01), ("1 cm longer", length + 0.01)):
        if other > 0.0 and in_reach(problem.leg, np.array([other]))[0]:
            cases.append((change, problem.motors[m], other))
    same = [i for i, row in enumerate(rows) if row.same_motor == rows[m].same_motor]
    same.sort(key=lambda i: problem.motors[i].gear_ratio)
    place = same.index(m)
    if place > 0:
        cases.append(("one ratio less", problem.motors[same[place - 1]], length))
    if place + 1 < len(same):
        cases.append(("one ratio more", problem.motors[same[place + 1]], length))
    found = [_jump_of_design(problem, motor, each) for _, motor, each in cases]
    return [
        Neighbour(change, motor, each, outcome) for (change, motor, each), outcome in zip(cases, found, strict=True)
    ]


def _jump_of_design(problem: SweepProblem, motor: Motor, length: float) -> JumpOutcome:
    """One design by the model of the sweep."""
    leg = problem.leg.with_length(length)
    if problem.model.engine == "point":
        return outcome_of(point_mass_outcomes(leg, motor, np.array([length]))[:, 0])
    if problem.model.engine == "mujoco":
        return mujoco_jump(leg, motor, problem.contact, problem.model).outcome
    return simulate([(leg, motor)], problem.contact, problem.model)[0]
