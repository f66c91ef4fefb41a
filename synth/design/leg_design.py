"""The computation of ``synth leg`` without solids and pages: fits, damper laws, parts, response, warnings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import cached_property
from math import degrees, pi, radians, remainder
from typing import Literal

import numpy as np

from synth.arrays import Array
from synth.cad.dimensions import LegDimensions  # a stored design refers to the class by this name
from synth.design.choice_robustness import ChoiceRobustness, choice_robustness
from synth.design.choice_rounds import ChoiceTask, LastChoice, Stage, choose_in_rounds, first_choice
from synth.design.choose_dampers import (
    DamperChoiceMade,
    DamperLimits,
    MeasuredCurve,
    choose_dampers,
    measured_curves,
)
from synth.design.choose_springs import SpringChoiceMade
from synth.design.damper_warnings import curve_warnings, size_warnings, travel_warnings
from synth.design.drawable_dampers import reasons_in
from synth.design.link_masses import BuiltLink
from synth.design.part_sets import SetsMade
from synth.design.reached_speeds import reached_speeds
from synth.design.response import WantedResponse
from synth.design.spring_warnings import spring_warnings, stop_warnings, wanted_rate_note, wound_turns
from synth.design.stages import SourceMotion, damper_laws, fit_options, read_motion, releases, with_held_out
from synth.design.stated_range import StatedRange
from synth.design.still_joints import JointSwing, swing_of, widths
from synth.design.stop_places import least_stops, moved_range
from synth.design.target_effects import TargetEffect, TargetLeg, notes, target_of, with_effects
from synth.files.leg_project import LegProject
from synth.fit.damper_laws import DamperLaw
from synth.fit.fit_result import FitResult, TrialFit
from synth.fit.methods import fit_by
from synth.fit.misfits import ANOTHER_MOTION as OTHER
from synth.fit.plausibility import doubts
from synth.fit.uncertainty import MASS_SCALE
from synth.fit.wanted_motion import with_other_legs
from synth.parts.catalogs import Catalogue
from synth.remarks import Remark, decisive, joint_of, kind_of, like, noted
from synth.swing.leg_model import Leg
from synth.swing.mechanics import FROUDE, froude_time_scale

Effort = Literal["first", "found", "chosen", "full"]


@dataclass(frozen=True)
class Solids:
    """Dimensions of all joints that can be drawn, and a sentence for each assumption or omission."""

    dimensions: LegDimensions
    notes: tuple[str, ...]


@dataclass(frozen=True)
class MassRounds:
    """Convergence of links and parts: ``count`` rounds of choosing; ``settled``: whether the parts stayed the same."""

    count: int
    settled: bool


@dataclass(frozen=True)
class LegDesign:
    """The result of a design.

    ``built`` is the robot's leg with the chosen parts and those effects of the target that belong to its joints.
    ``target`` is the fit of the robot's links, with ideal springs and dampers, to the wanted motion. Links include the
    parts that are drawn on them. Motions are (m, n) rotations, rad.
    """

    project: LegProject
    source: FitResult
    target: FitResult
    refit: FitResult
    held_out: tuple[TrialFit, ...]
    laws: Mapping[str, DamperLaw]
    measured: Mapping[str, MeasuredCurve]
    wanted: WantedResponse
    dampers: DamperChoiceMade
    springs: SpringChoiceMade
    built: Leg
    built_motions: tuple[Array, ...]
    errors: Array  # (n,) rad, RMS of each joint, built against wanted
    warnings: tuple[tuple[str | None, str], ...]  # joint or None, text
    sets: SetsMade
    robustness: ChoiceRobustness | None  # of the choice, against the uncertainty of the target's fit
    target_effects: tuple[TargetEffect, ...] = ()
    drawn: Solids | None = None  # the joints as drawn; None: nothing is drawn
    links: tuple[BuiltLink, ...] = ()  # with the drawn and bought parts on them; empty: nothing is drawn
    rounds: MassRounds | None = None
    ranges: tuple[StatedRange, ...] = ()  # that the target states

    @cached_property
    def rest_pose(self) -> Array:
        """(n,) rad, in which the built leg comes to rest."""
        return self.wanted.settled(self.built, self.built_motions)

    @property
    def another_motion(self) -> tuple[str, ...]:
        """The joints whose wanted motion is another one than the animal's: the robot's links do not make that."""
        return tuple(text.joint for text in self.target.warnings if isinstance(text, Remark) and text.kind == OTHER)

    def arm_offset(self, joint: int) -> float:
        """Offset of the lower half's arm, rad, as drawn: free angle less the spring's and the upper arm's angle.

        If the spring is seated so that larger angles close its arms: plus the included angle. In [-pi, pi].
        """
        if self.drawn is not None:
            return radians(remainder(self.drawn.dimensions.joints[joint].arm_offset, 360.0))
        spring = self.built.joints[joint].spring
        assert spring is not None
        chosen = self.springs.chosen[joint]
        offset = spring.free_angle + chosen.closes * chosen.included_angle
        return offset if abs(offset) <= pi else remainder(offset, 2 * pi)


@dataclass(frozen=True)
class KnownResults:
    """Results that do not depend on the robot's links: the animal's fit and motion, and the dampers' laws."""

    source: FitResult
    motion: SourceMotion
    laws: Mapping[str, DamperLaw]
    measured: Mapping[str, MeasuredCurve]


def known_beforehand(project: LegProject, stage: Stage) -> KnownResults:
    """Fit the animal's leg and the measured dampers.

    Raises
    ------
    UserError : trials that cannot be used, or an unknown method.
    """
    options = fit_options(project)
    motion = read_motion(project)
    with stage("fitting the animal's leg"):
        source = fit_by(
            project.source,
            motion.fitted,
            replace(options, release=project.release, computed=bool(project.wanted_shown)),
            project.fit,
        )
        # Of whole recordings: which samples the fit left out at the start, it says itself.
        warnings = (*motion.notes, *doubts(project.source, motion.fitted, source))
        motion = motion.cut(source.cut)
        source = with_other_legs(with_held_out(source, motion.held_out), project.wanted_legs)
        source = replace(source, warnings=(*warnings, *source.warnings), wanted=project.wanted_shown)
    with stage("finding the dampers' laws"):
        laws = damper_laws(project)
    tables = {n: (m.part, m.curve) for n, m in project.dampers.items() if m.curve is not None}
    measured = measured_curves(laws, tables, {name: item.part for name, item in project.dampers.items()})
    return KnownResults(source, motion, laws, measured)


def design_leg(project: LegProject, catalogue: Catalogue, stage: Stage | None = None) -> LegDesign:
    """Carry out a leg-design project up to the chosen parts, with the target's links as given in its file.

    Raises
    ------
    UserError : trials that cannot be used, constraints that no part meets, or an unknown method.
    """
    stage = stage or (lambda text: nullcontext())
    return design_for(project, catalogue, known_beforehand(project, stage), project.target, stage)


def design_for(
    project: LegProject,
    catalogue: Catalogue,
    known: KnownResults,
    target: Leg,
    stage: Stage,
    *,
    effort: Effort = "full",
    held: LastChoice | None = None,
    drawn: bool = False,
) -> LegDesign:
    """The design for the links of ``target``: those of the project, or the same with the joints' parts on them.

    ``effort``: ``first``, each joint's best single damper and spring without evaluating sets, for a first drawing;
    ``found``, the best set without substitutes for its parts, for a round that is followed by another; ``chosen``, what
    ``with_report_figures`` makes whole once the round is known to be the last; ``full``.
    ``held`` and ``drawn`` as in ``ChoiceTask``.

    Raises
    ------
    UserError : constraints that no part meets, or a fit that fails.
    """
    options, motion, laws = replace(fit_options(project), wanted=True), known.motion, known.laws
    into = target_of(target)
    scaled = motion.fitted_scaled
    with stage("fitting the robot's links to the scaled motion"):
        fitted = fit_by(into.ideal, scaled, options, project.fit)
        fitted = with_held_out(fitted, motion.held_out_scaled, begun_late=motion.begun_late)
    with stage("choosing dampers"):
        wanted = WantedResponse.of(fitted.leg, releases(scaled, fitted))
        turned = _turned(project.target, fitted.leg, wanted)
        real = _real(fitted.leg, into)
        limits = DamperLimits(project.parts, reasons_in(project.target, project.cad) if drawn else None)
        dampers = choose_dampers(wanted, project.joints, catalogue, known.measured, turned, leg=real, limits=limits)
    swaps = effort in ("chosen", "full")
    task = ChoiceTask(project, catalogue, into, motion, options, fitted, wanted, held or LastChoice(), swaps, drawn)
    sets, refit = (first_choice if effort == "first" else choose_in_rounds)(task, dampers, stage)
    dampers, springs = sets.dampers, sets.springs
    with stage("moving the built leg"):
        built = _with_part_numbers(sets.leg, springs, dampers)
        motions = tuple(found[:, :, 0] for found in wanted.simulate([built]))
        errors = wanted.errors([built])[0]
    held_out = tuple(trial for trial in fitted.trials if trial.held_out)
    design = LegDesign(
        project=project,
        source=known.source,
        target=fitted,
        refit=refit,
        held_out=held_out,
        laws=laws,
        measured=known.measured,
        wanted=wanted,
        dampers=dampers,
        springs=springs,
        built=built,
        built_motions=motions,
        errors=errors,
        warnings=(),
        sets=sets,
        robustness=None,
        target_effects=into.effects,
    )
    return with_report_figures(design, motion) if effort == "full" else design


def with_report_figures(design: LegDesign, motion: SourceMotion) -> LegDesign:
    """The design with what only its report needs: the next best sets, forecasts, robustness and warnings."""
    sets = design.sets.shown()
    robustness = choice_robustness(design.wanted, design.target, sets.legs, sets.added_by_tolerances)
    design = replace(design, sets=sets, robustness=robustness)
    warnings = _warnings(design, motion)
    if robustness is not None and robustness.warning is not None:
        warnings.append((None, robustness.warning))
    return replace(design, warnings=(*warnings, *notes(design.target_effects)))


def joint_swings(design: LegDesign) -> list[JointSwing]:
    """How far each joint turns as wanted and as built, and by how much its weakest damper is too strong."""
    wanted, ranked = design.wanted, design.dampers.ranked
    fastest = fastest_rates(wanted.motions, [release.time for release in wanted.releases])
    turned = zip(widths(wanted.motions).tolist(), widths(design.built_motions).tolist(), strict=True)
    return [
        swing_of(name, pair, design.target.joints[name].damper_rate, float(speed), (*options, chosen))
        for name, pair, speed, options, chosen in zip(
            design.built.joint_names, turned, fastest, ranked, design.dampers.chosen, strict=True
        )
    ]


def _turned(target: Leg, leg: Leg, wanted: WantedResponse) -> list[float]:
    """How far each joint turns from stop to stop, rad, its stops as close as its range or its motion allow."""
    poses = [*wanted.motions, wanted.settled(leg, wanted.motions)[np.newaxis]]
    angles = np.degrees(np.concatenate([leg.to_measured(each) for each in poses]))
    found = []
    for j, joint in enumerate(target.joints):
        travel = moved_range(angles[:, j].min(), angles[:, j].max())
        if joint.range is not None:
            travel = degrees(joint.range[0]), degrees(joint.range[1])
        first, last = least_stops(travel, asked=joint.range is not None)
        found.append(radians(last - first))
    return found


def _turned_as_drawn(design: LegDesign) -> list[float]:
    """As ``_turned``, from drawn stop to drawn stop where the joints are drawn."""
    if design.drawn is None:
        return _turned(design.project.target, design.target.leg, design.wanted)
    ends = [joint.stop_angles for joint in design.drawn.dimensions.joints]
    return [radians(last - first) for first, last in ends]


def _unloaded(design: LegDesign, j: int) -> tuple[float, tuple[float, float]]:
    """A joint's built free angle, and the least and greatest angle of its built motions, measured, rad."""
    joint = design.built.joints[j]
    assert joint.spring is not None
    angles = np.concatenate([design.built.to_measured(motion)[:, j] for motion in design.built_motions])
    return joint.spring.free_angle, (float(angles.min()), float(angles.max()))


def _real(leg: Leg, target: TargetLeg) -> Leg:
    """A fitted leg with the effects of the target's joints."""
    return with_effects(leg, {joint.name: joint.effects for joint in target.real.joints})


def _with_part_numbers(leg: Leg, springs: SpringChoiceMade, dampers: DamperChoiceMade) -> Leg:
    """The leg with the part numbers of bought parts."""
    joints = []
    for joint, spring, damper in zip(leg.joints, springs.chosen, dampers.chosen, strict=True):
        assert joint.spring is not None
        part = spring.row.part if spring.row is not None else None
        joints.append(replace(joint, spring=replace(joint.spring, part=part), damper=damper.damper))
    return replace(leg, name=leg.name, joints=tuple(joints))


def _warnings(design: LegDesign, motion: SourceMotion) -> list[tuple[str | None, str]]:
    """Warnings on fits, parts and motion, each with its joint."""
    project, target, refit, wanted = design.project, design.target, design.refit, design.wanted
    dampers, springs, laws = design.dampers, design.springs, design.laws
    warnings: list[tuple[str | None, str]] = []
    names = project.target.joint_names
    speeds = reached_speeds(design.built_motions, [release.time for release in wanted.releases])
    turned, swings = _turned_as_drawn(design), joint_swings(design)
    for j, name in enumerate(names):
        texts = [
            *swings[j].warnings,
            *springs.warnings[j],
            *spring_warnings(name, springs.chosen[j], project.joints[name].spring),
        ]
        fitted = refit.joints[name].spring_rate.value
        texts += wanted_rate_note(name, springs.chosen[j], dampers.chosen[j].label, fitted, project.joints[name].spring)
        if design.drawn is not None:
            texts += stop_warnings(name, springs.chosen[j], design.drawn.dimensions.joints[j])
        else:
            texts += wound_turns(name, *_unloaded(design, j))
        texts += curve_warnings(name, dampers.chosen[j], speeds[j])
        texts += travel_warnings(name, dampers.chosen[j], project.joints[name].damper, turned[j])
        texts += size_warnings(name, dampers.chosen[j], project.joints[name].damper)
        texts += laws[name].warnings if name in laws else []
        texts += _rate_warning(name, target, refit)
        warnings += [(name, text) for text in texts]
    for text in (*target.not_separable, *target.warnings):
        warnings.append((joint_of(text), text))
    for text in refit.not_separable:
        if kind_of(text) != MASS_SCALE:  # it is the same as of the fit without the dampers
            warnings.append((joint_of(text), like(text, f"with the real dampers: {text}")))
    if target.lost_samples:
        warnings.append((None, noted(f"{target.lost_samples} lost samples were left out of the fit")))
    alike = froude_time_scale(project.source, project.target)
    if motion.factor != 1.0 and not project.dynamic_similarity and alike is not None:
        text = (
            f"time is stretched by {motion.factor:g}; dynamic similarity would stretch it by {alike:.3g} ({FROUDE}), "
            "so gravity acts differently on the robot than on the animal"
        )
        warnings.append((None, noted(text)))
    return warnings


def fastest_rates(motions: Sequence[Array], times: Sequence[Array]) -> Array:
    """(n,) rad/s, the highest speed of each joint in motions (m, n) rad over times (m,) s."""
    return np.array([each.fastest for each in reached_speeds(motions, times)])


def _rate_warning(joint: str, target: FitResult, refit: FitResult) -> list[str]:
    """A warning if the real damper's curve changes the wanted spring rate by more than a quarter."""
    linear, curved = (result.joints[joint].spring_rate.value for result in (target, refit))
    if 0.8 < curved / linear < 1.25:  # a quarter either way: more than two springs' tolerances
        return []
    text = (
        f"{joint}: with the chosen damper's curve the fitted spring rate is {curved:.3g} N*m/rad, with a linear damper "
        f"{linear:.3g}. The spring rate depends on the damper's law: a wrong law gives an error of this size"
    )
    return [decisive(text)]
