"""Joints that are locked in every trial: nothing is estimated there, and the leg file's spring and damper are kept.

Of such a joint neither spring nor damper acts in any trial, so that the other joints' estimates do not depend on them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

import numpy as np

from synth.arrays import Array
from synth.estimation.intervals import Estimate
from synth.files.static_points_file import StaticPoint
from synth.files.trial_list import Trial
from synth.fit.draws import DrawnLegs, leg_with
from synth.fit.fit_result import FitResult, JointFit, TrialFit, Variant
from synth.remarks import Remark, at_joint
from synth.swing.leg_model import Joint, Leg

Value = TypeVar("Value")


def moving_joints(leg: Leg, trials: Sequence[Trial]) -> list[str] | None:
    """Joints that are free in some trial; None, for all, where none is: there is nothing to fit."""
    return [name for name in leg.joint_names if any(name not in trial.locked for trial in trials)] or None


def balanced_at(points: Sequence[StaticPoint], leg: Leg, moving: Sequence[str] | None) -> tuple[StaticPoint, ...]:
    """The static points, of which the torques about other joints than ``moving`` are left out."""
    sought = [j for j, name in enumerate(leg.joint_names) if moving is None or name in moving]
    kept = [replace(point, balanced=tuple(j for j in point.balanced if j in sought)) for point in points]
    return tuple(point for point in kept if point.balanced)


def with_locked_joints(result: FitResult, leg: Leg, moving: Sequence[str] | None) -> FitResult:
    """The result with the spring and damper of ``leg`` at the joints other than ``moving``, without estimates there.

    A joint whose spring is given keeps its entry, with values and no interval; one without has none.
    """
    held = [joint for joint in leg.joints if moving is not None and joint.name not in moving]
    if not held:
        return result
    names = {joint.name for joint in held}
    told = {joint.name: _kept(joint) if joint.name in names else result.joints[joint.name] for joint in leg.joints}
    places = [j for j, joint in enumerate(leg.joints) if joint.name in names]
    rests = np.array([np.nan if joint.spring is None else joint.spring.free_angle for joint in held])
    drawn = result.drawn
    return replace(
        result,
        leg=leg_with(result.leg, held),
        joints={name: found for name, found in told.items() if found is not None},
        rms=_without(result.rms, names),
        clipped_rms=_without(result.clipped_rms, names),
        noise=_without(result.noise, names),
        trials=tuple(_trial(each, places, rests) for each in result.trials),
        variants=tuple(_variant(each, names) for each in result.variants),
        warnings=(*map(_sentence, held), *result.warnings),
        drawn=replace(drawn, kept=tuple(held)) if isinstance(drawn, DrawnLegs) else drawn,
    )


def _kept(joint: Joint) -> JointFit | None:
    """The leg file's values as they are; None without a spring."""
    if joint.spring is None:
        return None
    damper = joint.damper
    law = "none" if damper is None else "curve" if damper.curve else "linear"
    return JointFit(
        Estimate(joint.spring.rate, "N*m/rad"),
        Estimate(joint.spring.free_angle, "deg"),
        Estimate(0.0, "deg"),
        Estimate(damper.rate, "N*m*s/rad") if damper is not None and damper.rate is not None else None,
        law,
        estimated=False,
    )


def _sentence(joint: Joint) -> Remark:
    given = [what for what, part in (("spring", joint.spring), ("damper", joint.damper)) if part is not None]
    lacking = [what for what in ("spring", "damper") if what not in given]
    text = "locked in every trial: nothing is estimated here"
    if given:
        text += f"; {' and '.join(given)} stay as the leg file gives them"
    if lacking:
        text += f"; fitted.leg.yaml has no {' and no '.join(lacking)} here, as the leg file gives none"
    return at_joint(joint.name, text, "note")


def _trial(trial: TrialFit, places: Sequence[int], rests: Array) -> TrialFit:
    """The trial with the given free angles (n,) rad at these joints, nan for none."""
    free_angle = trial.free_angle.copy()
    free_angle[list(places)] = rests
    return replace(trial, free_angle=free_angle)


def _variant(variant: Variant, names: set[str]) -> Variant:
    return Variant(
        variant.free_angle,
        _without(variant.spring_rate, names),
        _without(variant.damper_rate, names),
        _without(variant.rms, names),
        _without(variant.spread, names),
    )


def _without(by_joint: Mapping[str, Value], names: set[str]) -> dict[str, Value]:
    return {name: value for name, value in by_joint.items() if name not in names}
