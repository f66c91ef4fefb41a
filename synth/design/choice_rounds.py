"""Repeated choice of parts: fit with the chosen dampers' curves, choose again, until the parts no longer change."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from math import degrees, radians

import numpy as np

from synth.design.arm_sweep import least_rates
from synth.design.choose_dampers import DamperChoiceMade
from synth.design.choose_springs import SpringSource, travels
from synth.design.part_sets import SetsMade, choose_sets, unjudged_set
from synth.design.response import WantedResponse
from synth.design.stages import SourceMotion, with_held_out
from synth.design.target_effects import TargetLeg
from synth.errors import UserError
from synth.files.leg_project import LegProject
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_result import FitResult
from synth.fit.methods import fit_by
from synth.parts.catalogs import Catalogue
from synth.remarks import decisive
from synth.swing.leg_model import Leg

Stage = Callable[[str], AbstractContextManager[object]]
Labels = tuple[str, ...]

MOST_ROUNDS = 4  # fits with chosen dampers; the lab's project needs 1 to 3
SEATED = radians(2.0)  # of a free angle: the room past the stops, for which a spring is made, is 3.5 deg
MOST_SEATINGS = 3  # choices with the same dampers; the second is sized for what the first builds
SIZED_ELSEWHERE = "{}: the spring's travel and stress are those of a free angle {:+.0f} deg from the one built"
TO_SEAT = "Name the spring's wire or part, so that the choice of free angle and of spring no longer change each other."


@dataclass(frozen=True)
class LastChoice:
    """The springs chosen in the last round: ``wires`` (m) of those to wind, ``free_angles`` (rad) built; by joint."""

    wires: Mapping[str, float] = field(default_factory=dict)
    free_angles: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class ChoiceTask:
    """The inputs that are the same in every round.

    ``target`` is the fit of the links alone, ``wanted`` its motion, ``options`` the fit options. ``held``: of a spring
    to wind the wire is kept if possible, and springs are first sized for these free angles. ``swaps``: whether the
    substitutes for each part are evaluated. ``drawn``: whether the joints are drawn, so that springs must be drawable.
    """

    project: LegProject
    catalogue: Catalogue
    into: TargetLeg
    motion: SourceMotion
    options: LegFitOptions
    target: FitResult
    wanted: WantedResponse
    held: LastChoice = field(default_factory=LastChoice)
    swaps: bool = True
    drawn: bool = False


@dataclass(frozen=True)
class Round:
    """One round: the dampers, the fit with their curves, and the sets chosen from it."""

    dampers: DamperChoiceMade
    refit: FitResult
    sets: SetsMade

    @property
    def expected(self) -> float:
        """Expected error of the chosen set, rad."""
        return self.sets.chosen.ready.expected


def choose_in_rounds(task: ChoiceTask, dampers: DamperChoiceMade, stage: Stage) -> tuple[SetsMade, FitResult]:
    """The best set of all rounds, and the fit with its dampers.

    The sets of all rounds are compared by the same wanted motion and the same draws of the tolerances, and the best is
    kept. The rounds end when the chosen dampers were fitted in an earlier round. Dampers with which the fit fails (such
    as one far too strong for its link) are excluded.

    Raises
    ------
    UserError : a joint has no part that meets its constraints, or the fit fails with every damper.
    """
    rounds: dict[Labels, Round] = {}
    barred: set[Labels] = set()
    now = dampers
    fitted: tuple[DamperChoiceMade, FitResult] | None = None
    while now.labels not in rounds and len(rounds) < MOST_ROUNDS:
        try:
            with stage("fitting springs again with the dampers' curves"):
                fitted = now, refit_links(task, now)
        except UserError as error:
            barred.add(now.labels)
            if fitted is None:
                now = _next_best(dampers, barred, error)
                continue
        with stage("choosing springs and dampers together"):
            last = Round(*fitted, _choose_seated(task, *fitted, frozenset(barred)))
        rounds[last.dampers.labels] = last
        # Each joint's ranking of single dampers is kept, so that the candidates do not depend on the round.
        now = replace(dampers, chosen=last.sets.dampers.chosen, leg=last.sets.leg)
    # At the limit of rounds the last chosen dampers have no fit yet; the best set of the earlier rounds is taken.
    best = min((r for r in rounds.values() if r.sets.dampers.labels in rounds), key=lambda done: done.expected)
    return best.sets, rounds[best.sets.dampers.labels].refit


def first_choice(task: ChoiceTask, dampers: DamperChoiceMade, stage: Stage) -> tuple[SetsMade, FitResult]:
    """The best single dampers, the fit with them, and the best spring of each joint, for a first drawing.

    Raises
    ------
    UserError : a joint has no part that meets its constraints, or the fit fails with these dampers.
    """
    with stage("choosing parts for a first drawing"):
        refit = refit_links(task, dampers)
        leg = _with_dampers(refit.leg, dampers)
        sources = _sources(task, _with_known_angles(task, refit, leg))
        return unjudged_set(task.wanted, leg, dampers, sources, task.project.parts, seed=task.project.fit.seed), refit


def _next_best(dampers: DamperChoiceMade, barred: set[Labels], error: UserError) -> DamperChoiceMade:
    """The best set of dampers that is not excluded. Raises ``error`` if none is left."""
    for item in dampers.sets:
        if tuple(option.label for option in item.options) not in barred:
            return replace(dampers, chosen=item.options, leg=item.leg)
    raise error


def _choose_seated(
    task: ChoiceTask, dampers: DamperChoiceMade, refit: FitResult, barred: frozenset[Labels]
) -> SetsMade:
    """The chosen set, with springs sized for the free angles that are built with them.

    A free angle is chosen with the parts, by the response. Where rate and free angle can replace each other it is far
    from the fitted one, and so are the travel, the stress and the seat of the spring.
    """
    leg = _with_dampers(refit.leg, dampers)
    sized = _with_free_angles(_with_known_angles(task, refit, leg), task.held.free_angles)
    off: dict[str, float] = {}
    for _ in range(MOST_SEATINGS):
        sets = choose_sets(
            task.wanted, leg, dampers, _sources(task, sized), task.project.parts,
            barred=barred, seed=task.project.fit.seed, swaps=task.swaps,
        )  # fmt: skip
        built = built_free_angles(sets.leg)
        now = built_free_angles(sized)
        off = {name: degrees(built[name] - now[name]) for name in built if abs(built[name] - now[name]) > SEATED}
        if not off:
            return sets
        sized = _with_free_angles(leg, built)
    notes = [
        (*words, *([decisive(SIZED_ELSEWHERE.format(name, off[name]), TO_SEAT)] if name in off else []))
        for name, words in zip(leg.joint_names, sets.springs.notes, strict=True)
    ]
    return replace(sets, springs=replace(sets.springs, notes=tuple(notes)))


def _with_known_angles(task: ChoiceTask, refit: FitResult, leg: Leg) -> Leg:
    """The leg with another free angle wherever the fit leaves it open: that with which the joint rests as wanted.

    Where a damper is far too strong the motion hardly depends on the spring, and the fit may put the free angle turns
    away. For a spring that is sized for it nothing holds. The rates are those of the fit with linear dampers, which the
    wanted motion determines.
    """
    open_ones = [name for name, joint in refit.joints.items() if joint.free_angle.is_any_angle]
    if not open_ones:
        return leg
    joints = []
    for joint, linear in zip(leg.joints, task.target.leg.joints, strict=True):
        assert joint.spring is not None
        assert linear.spring is not None
        rate = linear.spring.rate if joint.name in open_ones else joint.spring.rate
        joints.append(replace(joint, spring=replace(joint.spring, rate=rate)))
    rested = built_free_angles(task.wanted.at_rest_like_wanted(replace(leg, joints=tuple(joints))))
    return _with_free_angles(leg, {name: rested[name] for name in open_ones})


def built_free_angles(leg: Leg) -> dict[str, float]:
    """Free angle (rad) of each joint's spring."""
    return {joint.name: joint.spring.free_angle for joint in leg.joints if joint.spring is not None}


def _with_free_angles(leg: Leg, angles: Mapping[str, float]) -> Leg:
    """The leg with these free angles (rad) of some joints."""
    joints = [
        replace(joint, spring=replace(joint.spring, free_angle=angles.get(joint.name, joint.spring.free_angle)))
        if joint.spring is not None
        else joint
        for joint in leg.joints
    ]
    return replace(leg, joints=tuple(joints))


def refit_links(task: ChoiceTask, dampers: DamperChoiceMade) -> FitResult:
    """Fit of the robot's links to the motion with the dampers' curves, started from the springs tuned to these dampers.

    Raises
    ------
    UserError : the fit fails with these dampers.
    """
    leg = task.into.real
    curves = {
        joint.name: option.damper.curve
        for joint, option in zip(leg.joints, dampers.chosen, strict=True)
        if option.damper.curve is not None
    }
    options = replace(task.options, curves=curves, near=_start_of_refit(task.target, dampers.leg))
    try:
        again = fit_by(leg, task.motion.fitted_scaled, options, task.project.fit)
    except UserError as error:
        parts = ", ".join(dampers.labels)
        raise UserError(f"with the dampers {parts} the leg cannot be fitted to the motion: {error}") from error
    return with_held_out(again, task.motion.held_out_scaled, begun_late=task.motion.begun_late)


def _sources(task: ChoiceTask, leg: Leg) -> list[SpringSource]:
    """Each joint's source of springs, for the travel of the springs of ``leg``."""
    project = task.project
    least_each = least_rates(leg, task.wanted) if task.drawn else [0.0] * len(leg.joints)
    return [
        SpringSource(
            joint.name,
            project.joints[joint.name].spring,
            turn,
            task.catalogue,
            project.cad,
            project.parts,
            task.held.wires.get(joint.name),
            task.drawn,
            least,
        )
        for joint, turn, least in zip(leg.joints, travels(leg, task.wanted.motions), least_each, strict=True)
    ]


def _start_of_refit(result: FitResult, leg: Leg) -> FitResult:
    """The start of the next fit: the trials' shifts of ``result`` with the spring rates and free angles of ``leg``."""
    joints, moved = {}, []
    for joint in leg.joints:
        assert joint.spring is not None
        found = result.joints[joint.name]
        moved.append(joint.spring.free_angle - found.free_angle.value)
        joints[joint.name] = replace(
            found,
            spring_rate=replace(found.spring_rate, value=joint.spring.rate),
            free_angle=replace(found.free_angle, value=joint.spring.free_angle),
        )
    trials = tuple(replace(trial, free_angle=trial.free_angle + np.array(moved)) for trial in result.trials)
    return replace(result, joints=joints, trials=trials)


def _with_dampers(leg: Leg, dampers: DamperChoiceMade) -> Leg:
    joints = (replace(j, damper=option.damper) for j, option in zip(leg.joints, dampers.chosen, strict=True))
    return replace(leg, joints=tuple(joints))
