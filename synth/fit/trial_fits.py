"""Each trial and its fit: residuals, initial state, characteristics of the recorded motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from synth.arrays import Array
from synth.estimation.intervals import NORMAL90
from synth.fit.fit_result import JointFit, RecordedMotion, StartFit, TrialFit
from synth.fit.recordings import Recording
from synth.fit.trajectories import Local
from synth.fit.uncertainty import residuals, rms_as_recorded
from synth.motion.first_state import FirstState
from synth.remarks import noted
from synth.sampling import usual_step
from synth.swing.driving_inputs import driven_by, is_driven
from synth.swing.leg_model import Leg, Spring
from synth.swing.mechanics import outboard_inertia, rest_pose

# times the stiffest spring: a locked joint turns by less than a millionth of the others' angles
HOLDING_STIFFNESS = 1e6
LEAST_START = (1.5, 60.0)  # deg, and deg in the recordings' unit of time, from the first samples, for a report
HIDDEN_DECAY = 0.5  # of a rate's decay, between two samples


def trial_fits(
    leg: Leg,
    joints: Mapping[str, JointFit],
    recordings: Sequence[Recording],
    locals_: Sequence[Local],
    predictions: Sequence[Array],
    *,
    held_out: bool = False,
) -> tuple[TrialFit, ...]:
    """Each recording and its prediction, in measured angles, with the recorded motion."""
    common = np.array([joint.free_angle.value for joint in joints.values()])
    fits = []
    for recording, local, prediction in zip(recordings, locals_, predictions, strict=True):
        residual = residuals(recording, prediction)
        counted = np.asarray(recording.counts.any(axis=0))
        rms = np.full(len(counted), np.nan)
        rms[counted] = np.sqrt(np.nanmean(residual[:, counted] ** 2, axis=0))
        if recording.spread is not None:
            rms = rms_as_recorded([recording], [prediction])
        smoothed = recording.smoothed
        free, driven = recording.free, is_driven(recording.known_torque, recording.signals)
        motion = RecordedMotion(
            tuple(leg.joint_names[j] for j in free), smoothed.time,
            leg.to_measured(smoothed.angle)[:, free], smoothed.noise[free],
            _equilibrium(leg, joints, recording, local)[free], driven=driven,
        )  # fmt: skip
        rotation = np.where(recording.counts, recording.rotation, np.nan)
        fits.append(
            TrialFit(
                recording.name,
                recording.time,
                leg.to_measured(rotation),
                leg.to_measured(prediction),
                rms,
                common + leg.sign * local.shift,
                local.rotation,
                local.rate,
                _start(leg, recording, local),
                motion,
                held_out,
                recording.conditions,
                driven_by(recording.known_torque, recording.signals),
            )
        )
    return tuple(fits)


def _equilibrium(leg: Leg, joints: Mapping[str, JointFit], recording: Recording, local: Local) -> Array:
    """(n,) rad, measured angles at which the fitted leg rests in this trial; nan if unknown.

    A driven leg does not rest, and with an effect beyond springs and dampers it rests elsewhere.
    """
    unknown = np.full(len(leg.joints), np.nan)
    if (
        is_driven(recording.known_torque, recording.signals)
        or leg.effects
        or any(joint.effects for joint in leg.joints)
    ):
        return unknown
    stiff = HOLDING_STIFFNESS * max(joint.spring_rate.value for joint in joints.values())
    held = leg.to_measured(local.rotation)
    springs = {}
    for j, (name, joint) in enumerate(joints.items()):
        free = joint.free_angle.value + leg.sign[j] * local.shift[j]
        locked = j in recording.conditions.locked
        springs[name] = {"spring": Spring(stiff, held[j]) if locked else Spring(joint.spring_rate.value, free)}
    tilted = replace(leg.with_joints(**springs), tilt=leg.tilt + recording.conditions.tilt)
    try:
        return leg.to_measured(rest_pose(tilted, recording.conditions.tip, recording.smoothed.angle[-1]))
    except ArithmeticError:
        return unknown


def _start(leg: Leg, recording: Recording, local: Local) -> StartFit:
    """Fitted and recorded initial state in measured angles; nan for locked joints."""
    held = ~recording.counts.any(axis=0)
    seen = recording.start

    def if_free(values: Array) -> Array:
        return np.where(held, np.nan, values)

    recorded = FirstState(
        if_free(leg.to_measured(seen.angle)),
        if_free(leg.sign * seen.rate),
        if_free(seen.angle_deviation),
        if_free(seen.rate_deviation),
    )
    return StartFit(if_free(leg.to_measured(local.rotation)), if_free(leg.sign * local.rate), recorded)


def away_from_their_starts(
    leg: Leg, trials: Sequence[TrialFit], unit: float = 1.0, follower: str = "", likely: str = ""
) -> list[str]:
    """A sentence on trials whose fitted motion starts away from their first samples.

    ``leg`` : the fitted one; ``unit`` : s, of the recordings; ``follower`` : of a wanted motion, the leg in words;
    ``likely`` : a sentence on what the readings show of the reason, may be empty.
    """
    away, names = [], leg.joint_names
    damping = np.array([(joint.damper.rate or 0.0) if joint.damper is not None else 0.0 for joint in leg.joints])
    decay = damping / outboard_inertia(leg)
    for trial in trials:
        start = trial.start
        degrees = np.abs(np.degrees(start.angle - start.recorded.angle))
        turning = np.abs(np.degrees(start.rate - start.recorded.rate))
        turned = turning > LEAST_START[1] / unit
        # A rate that decays within two samples is not in the samples, which show the creeping after it.
        hidden = decay * usual_step(trial.time, np.isfinite(trial.measured)) > HIDDEN_DECAY
        turned &= ~hidden | (turning > LEAST_START[0] * decay)
        off = ((degrees > LEAST_START[0]) | turned) & (start.misfit() > NORMAL90).any(axis=0)
        for j in map(int, np.flatnonzero(off)):
            away.append((float(start.misfit()[:, j].max()), trial, j))
    if not away:
        return []
    _, trial, j = max(away, key=lambda item: item[0])
    start, count = trial.start, len({item[1].name for item in away})
    fitted, recorded = (
        f"{np.degrees(each.angle[j]):.1f} deg and {np.degrees(each.rate[j]):.0f} deg/s"
        for each in (start, start.recorded)
    )
    if follower:
        text = f"{follower} goes on most alike in {count} of {len(trials)} trials if it does not start alike"
        return [noted(f"release: {text}. Most so in {trial.name}, {names[j]}: {fitted}, wanted {recorded}")]
    reason = "Something outside the model acts there, such as a hand, a muscle or a latch"
    if likely:
        reason = f"{likely}. Else something acts there, such as a hand, a muscle or a latch"
    return [
        f"release: in {count} of {len(trials)} trials the fitted motion does not start at the first samples. "
        f"Most so in {trial.name}, {names[j]}: fitted {fitted}, recorded {recorded}. {reason}. Use a later start, or "
        "cut the recording with synth import"
    ]
