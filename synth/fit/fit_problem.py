"""The unknowns of a fit: springs and dampers of a leg, with priors and static measurements."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from synth.files.project_options import RatePrior
from synth.files.static_points_file import StaticPoint
from synth.fit.recordings import Recording
from synth.fit.search_box import SearchBox
from synth.fit.static_points import balances
from synth.fit.trajectories import FIT_STEPS, TrajectoryModel
from synth.fit.unknowns import SpringsAndDampers, unknowns_of_leg
from synth.swing.chain import compiled_chain
from synth.swing.leg_model import Damper, DamperCurve, Leg, Spring

NOTHING_NEAR = "no motion of this leg comes near the trials: check link masses, zero and sign of each joint"


def without_springs(leg: Leg, curves: Mapping[str, DamperCurve] | None = None) -> Leg:
    """The leg without springs, with dampers only of known curve (joint name -> curve)."""
    known = curves or {}
    joints = [
        replace(joint, spring=Spring(0.0, joint.zero), damper=Damper(curve=known.get(joint.name)))
        for joint in leg.joints
    ]
    return replace(leg, joints=tuple(joints))


def model_of(
    leg: Leg,
    curves: Mapping[str, DamperCurve] | None = None,
    *,
    recordings: Sequence[Recording] = (),
    prior: RatePrior | None = None,
    static: Sequence[StaticPoint] = (),
) -> TrajectoryModel:
    """The leg's motion as a function of spring rates, rest angles, and damper rates without a known curve.

    Parameters
    ----------
    leg : links and gravity; its own springs and dampers are used only through ``prior``.
    curves : joint name -> known torque-speed curve of its damper.
    recordings : those to fit, from which the bounds of the search follow; none: those of a limb. Nothing is sought at
        joints that are locked in all of them: what tells nothing of the trials would count in tests of all unknowns.
    prior : standard deviations of the leg's own values.
    static : poses in which the leg was held still by known torques.
    """
    known = curves or {}
    nothing, chain = without_springs(leg, known), compiled_chain(len(leg.joints))
    held = [j for j, name in enumerate(leg.joint_names) if name in known]
    unknowns = unknowns_of_leg(chain, nothing, damper_known=held, box=box_of(recordings))
    unknowns = unknowns.of_joints(moving_in(recordings, len(leg.joints)))
    beliefs = () if prior is None else _beliefs(unknowns, leg, prior)
    unknowns = replace(unknowns, beliefs=beliefs, balances=balances(nothing, static))
    return TrajectoryModel(chain, nothing, unknowns, max_steps=FIT_STEPS + unknowns.box.steps(nothing))


def moving_in(recordings: Sequence[Recording], n_joint: int) -> list[int]:
    """Joints that are free in some recording; all if there is none."""
    return [j for j in range(n_joint) if not recordings or any(j in recording.free for recording in recordings)]


def box_of(recordings: Sequence[Recording]) -> SearchBox:
    """The bounds of a search for the motion of these recordings."""
    if not recordings:
        return SearchBox()
    low, high = (
        side([side(recording.smoothed.angle, axis=0) for recording in recordings], axis=0) for side in (np.min, np.max)
    )
    return SearchBox(
        min(recording.smoothed.pace for recording in recordings),
        max(float(recording.time[-1]) for recording in recordings),
        min(recording.step for recording in recordings),
        recordings[0].unit,
        tuple(zip(low.tolist(), high.tolist(), strict=True)),
    )


def unknowns_of(model: TrajectoryModel) -> SpringsAndDampers:
    """The unknowns of a model made by ``model_of``."""
    assert isinstance(model.unknowns, SpringsAndDampers)
    return model.unknowns


def _beliefs(unknowns: SpringsAndDampers, given: Leg, prior: RatePrior) -> tuple[tuple[int, float, float], ...]:
    """The user's priors about the leg file's own values: log-normal for rates (their share), normal for angles."""
    found = []
    for j, joint in enumerate(given.joints):
        if j not in unknowns.rates:
            continue
        if joint.spring is not None and prior.spring is not None and joint.spring.rate > 0:
            found.append((unknowns.rate_at(j), float(np.log(joint.spring.rate)), prior.spring**-2))
        if joint.spring is not None and prior.free_angle is not None:
            found.append((unknowns.rest_at(j), joint.rest, prior.free_angle**-2))
        if j in unknowns.dampers and joint.damper is not None and joint.damper.rate and prior.damper is not None:
            found.append((unknowns.damper_at(j), float(np.log(joint.damper.rate)), prior.damper**-2))
    return tuple(found)
