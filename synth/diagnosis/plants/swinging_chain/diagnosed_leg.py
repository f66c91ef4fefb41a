"""The diagnosed leg: the nominal one fitted within the tolerances, with the accepted effects."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from synth.arrays import Array
from synth.diagnosis.encoder_counts import CoarseChannel
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.plants.swinging_chain.chain_candidates import Candidate
from synth.diagnosis.plants.swinging_chain.lane_packing import chain_candidates
from synth.swing.damper_curves import with_rate
from synth.swing.leg_lanes import LegLanes
from synth.swing.leg_model import Joint, Leg
from synth.swing.stated_effects import COUNTS
from synth.swing.tolerances import Tolerances


def diagnosed_leg(
    leg: Leg, tolerances: Tolerances, fit: EvaluatedHypothesis | None, coarse: Sequence[CoarseChannel]
) -> Leg:
    """A leg for a leg file; effects that change a number of the leg are included in that number.

    ``fit`` : None, the leg as it is.
    """
    if fit is None:
        return leg
    made = tolerances.leg(leg, fit.unknowns[: tolerances.size])
    for candidate, place in zip(chain_candidates(fit.hypothesis), fit.slices, strict=True):
        x = fit.unknowns[place]
        made = (
            _with_changed_numbers(made, candidate, x)
            if candidate.effect.way == "leg"
            else _with_effect(made, candidate, x)
        )
    for item in coarse:
        joint = made.joints[item.joint]
        effects = {**joint.effects, COUNTS: {"step": item.step}}
        made = made.with_joints(**{joint.name: {"effects": effects}})
    return made


def _with_effect(leg: Leg, candidate: Candidate, x: Array) -> Leg:
    name, values = candidate.effect.name, candidate.named(x)
    if candidate.effect.where == "base":
        return replace(
            leg, effects=_without(leg.effects, name) if candidate.is_absent else {**leg.effects, name: values}
        )
    joint = leg.joints[candidate.joint]
    if candidate.is_absent:
        return leg.with_joints(**{joint.name: {"effects": _without(joint.effects, name)}})
    rest = {other: given for other, given in joint.effects.items() if other not in candidate.replaced}
    there = rest.get(candidate.effect.name)
    if candidate.effect.name == "torque_gain" and there is not None:  # within the tolerance of the motor's constant
        values = {"share": (1.0 + there["share"]) * (1.0 + values["share"]) - 1.0}
    return leg.with_joints(**{joint.name: {"effects": {**rest, name: values}}})


def _without(effects: Mapping[str, Mapping[str, float]], name: str) -> dict[str, Mapping[str, float]]:
    return {other: given for other, given in effects.items() if other != name}


def _with_changed_numbers(leg: Leg, candidate: Candidate, x: Array) -> Leg:
    """The leg with the numbers changed by the effect."""
    legs = LegLanes.of(leg)
    values = candidate.values(x[:, None])
    candidate.effect.function()(legs, candidate.joint, candidate.leg.joints[candidate.joint].sign, *values)
    joints = []
    for j, joint in enumerate(leg.joints):
        link = replace(
            joint.link,
            length=float(legs.length[j, 0]),
            mass=float(legs.mass[j, 0]),
            com=float(legs.com[j, 0]),
            com_across=float(legs.com_across[j, 0]),
            inertia=float(legs.inertia[j, 0]),
        )
        spring = joint.spring
        if spring is not None:
            angle = joint.zero + joint.sign * float(legs.rest[j, 0])
            spring = replace(spring, rate=float(legs.spring_rate[j, 0]), free_angle=angle)
        damper, rate = joint.damper, float(legs.damper_rate[j, 0])
        if damper is not None and damper.rate is not None:
            damper = replace(damper, rate=rate)
        elif damper is not None and damper.curve is not None and rate != 0.0:
            damper = replace(damper, curve=with_rate(damper.curve, rate))
        joint = _with_armature(joint, float(legs.armature[j, 0]))
        joints.append(replace(joint, link=link, spring=spring, damper=damper))
    return replace(leg, joints=tuple(joints), tilt=float(np.asarray(legs.tilt)[0]))


def _with_armature(joint: Joint, whole: float) -> Joint:
    """The joint with ``whole`` kg m^2 that turn with it; where its rotor alone has more, with less of a rotor."""
    own = whole - (joint.with_whole_rotor - joint.armature)
    if own >= 0.0 or joint.drive is None or joint.drive.motor is None:
        return replace(joint, armature=own)
    motor = replace(joint.drive.motor, rotor_inertia=whole / joint.drive.motor.gear_ratio**2)
    return replace(joint, armature=0.0, drive=replace(joint.drive, motor=motor))
