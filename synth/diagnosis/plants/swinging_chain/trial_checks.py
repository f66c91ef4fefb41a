"""Checks of trials before any work: unusable trials are refused, doubtful ones are reported."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from synth.diagnosis.plants.swinging_chain.idle_effects import idle_effects
from synth.diagnosis.plants.swinging_chain.replaced_effects import own_leg_files, some_names
from synth.drives.servo import TorqueDrive
from synth.errors import Problem, UserError
from synth.fit.copies import copies
from synth.fit.recordings import Recording, recordings
from synth.remarks import at_joint, decisive, noted, unlike
from synth.swing.leg_model import Leg
from synth.swing.stated_effects import COUNTS

if TYPE_CHECKING:
    from synth.files.trial_list import Trial

LEAST_MOTION = np.radians(0.5)  # rad; a smaller motion is not a release
LITTLE_BEYOND = 1.1  # times the highest speed of a damper's curve: little extrapolation
LOOSE_MOTION = np.radians(2.0)  # rad; acceptable motion of a locked joint


@dataclass(frozen=True)
class JointMotion:
    """One free joint in one trial: ``travel`` of the smoothed angle, RMS ``motion`` and ``noise``."""

    travel: float
    motion: float
    noise: float

    @property
    def is_visible(self) -> bool:
        """Whether the joint moves visibly."""
        return self.travel >= LEAST_MOTION and self.motion > self.noise


def check_trials(leg: Leg, trials: Sequence[Trial]) -> tuple[str, ...]:
    """Warnings about the trials, one sentence each.

    Raises
    ------
    UserError : a trial cannot be read as motion, or no training trial shows motion above its noise.
    """
    made = recordings(leg, trials, ())
    seen = [{j: motion_of(recording, j) for j in recording.free} for recording in made]
    learnt = [k for k, trial in enumerate(trials) if not trial.held_out]
    _refuse_rest([trials[k].name for k in learnt], [seen[k] for k in learnt])
    return (
        *_loose_joints(leg, trials, made),
        *_still_trials(trials, seen, learnt),
        *_still_joints(leg, [seen[k] for k in learnt]),
        *_fast_dampers(leg, made),
        *_few_trials(
            len(learnt) - len({later for later, _ in copies([made[k] for k in learnt], [False] * len(learnt))}),
            len(trials) - len(learnt),
        ),
        *_driven_trials(leg, trials),
        *_currents_not_recorded(leg, trials),
        *_all_stated_effects(leg, trials, made),
    )


def _all_stated_effects(leg: Leg, trials: Sequence[Trial], made: Sequence[Recording]) -> list[str]:
    """Sentences on the effects of the leg and of the trials' own legs."""
    of_design = [each for each in made if each.leg is None]
    told = _stated_effects(leg, of_design, "part of the designed leg, as its file states", "the leg file")
    for file, own in own_leg_files(trials).items():
        own_made = [made[k] for k, trial in enumerate(trials) if any(trial is each for each in own)]
        told += _stated_effects(own[0].leg or leg, own_made, _of_own_leg(file, own), file)
    return told


def _of_own_leg(file: str, trials: Sequence[Trial]) -> str:
    return f"part of the own leg of {some_names([trial.name for trial in trials])}, as {file} states"


def _stated_effects(leg: Leg, made: Sequence[Recording], whose: str, file: str) -> list[str]:
    """Sentences on the effects that a leg states: they are simulated, except counts, which the readings show.

    And except those that act in none of its trials, ``made``.
    """
    places = [(joint.name, joint.effects) for joint in leg.joints] + [("base", leg.effects)]
    idle = {(leg.joint_names[j], name): missing for (name, j), missing in idle_effects(leg, made).items()}
    simulated = [
        f"{name} ({place})"
        for place, effects in places
        for name in effects
        if name != COUNTS and (place, name) not in idle
    ]
    told: list[str] = [
        at_joint(place, f"{name}, which {file} states, acts in no trial: {missing}")
        for (place, name), missing in idle.items()
    ]
    if simulated:
        told.append(noted(f"{whose}: {', '.join(simulated)}"))
    text = f"{COUNTS} is stated in {file}, but not simulated: coarse counts are found from the readings"
    return [*told, *(at_joint(place, text, "note") for place, effects in places if COUNTS in effects)]


def motion_of(recording: Recording, joint: int) -> JointMotion:
    """Travel, motion and noise of a joint, all rad.

    The variance of the readings is the sum of those of motion and noise, so their difference is the
    motion's.
    """
    smoothed, counts = recording.smoothed, recording.counts[:, joint]
    noise = float(smoothed.noise[joint])
    variance = float(np.var(recording.rotation[counts, joint]))
    return JointMotion(float(np.ptp(smoothed.angle[:, joint])), float(np.sqrt(max(variance - noise**2, 0.0))), noise)


def _refuse_rest(names: Sequence[str], seen: Sequence[dict[int, JointMotion]]) -> None:
    """Refuse trials without motion, each with a description."""
    if any(motion.is_visible for joints in seen for motion in joints.values()):
        return
    problems = []
    for name, joints in zip(names, seen, strict=True):
        most = max(joints.values(), key=lambda motion: motion.motion)
        if most.travel < LEAST_MOTION:
            text = (
                f"does not move: at most {np.degrees(most.travel):.2g} deg at any joint. A leg at rest shows nothing "
            )
            text += "about its motion; use a trial in which it swings"
        else:
            text = f"its noise, {np.degrees(most.noise):.2g} deg, is larger than its motion, "
            text += f"{np.degrees(most.motion):.2g} deg RMS; use a larger release, or a sensor with finer resolution"
        problems.append(Problem(text, name))
    raise UserError(problems)


def _loose_joints(leg: Leg, trials: Sequence[Trial], made: Sequence[Recording]) -> list[str]:
    """Joints listed as locked that move nevertheless."""
    found = []
    for trial, recording in zip(trials, made, strict=True):
        for j in recording.conditions.locked:
            low, high = np.nanpercentile(trial.angles[:, j], [2.0, 98.0])
            if high - low > max(LOOSE_MOTION, 6.0 * recording.smoothed.noise[j]):
                text = f"{trial.name}: {leg.joint_names[j]} is listed as locked but moves by "
                held = f"{np.degrees(high - low):.2g} deg; it is assumed locked at its median"
                found.append(decisive(text + held))
    return found


def _still_trials(trials: Sequence[Trial], seen: Sequence[dict[int, JointMotion]], learnt: Sequence[int]) -> list[str]:
    still = [k for k in range(len(trials)) if not any(motion.is_visible for motion in seen[k].values())]
    return [
        f"{trials[k].name}: no joint moves above its noise; it only shows the rest pose"
        + ("" if k in learnt else ", and the gap scored on it is close to zero")
        for k in still
    ]


def _still_joints(leg: Leg, seen: Sequence[dict[int, JointMotion]]) -> list[str]:
    found = []
    for j, name in enumerate(leg.joint_names):
        motions = [joints[j] for joints in seen if j in joints]
        if not motions:
            found.append(f"{name}: locked in every training trial; its own spring, damper and friction are not seen")
        elif not any(motion.is_visible for motion in motions):
            most = np.degrees(max(motion.travel for motion in motions))
            found.append(
                f"{name}: never moves above its noise (by {most:.2g} deg at most); nothing is known about this joint. "
                "If it was held, list it under `locked`"
            )
    return found


def _fast_dampers(leg: Leg, made: Sequence[Recording]) -> list[str]:
    """Dampers turned much faster than the end of their stated torque-speed curve."""
    found: list[str] = []
    for j, joint in enumerate(leg.joints):
        curve = joint.damper.curve if joint.damper is not None else None
        turned = [(float(np.abs(each.smoothed.rate[:, j]).max()), each.name) for each in made if j in each.free]
        if curve is None or not turned:
            continue
        reached, name = max(turned)
        if reached > LITTLE_BEYOND * curve.speed[-1]:
            speed, end = unlike(np.degrees(reached), np.degrees(curve.speed[-1]), ".0f")
            text = f"{name} turns the damper at up to {speed} deg/s; its curve in the leg file ends at {end}, and "
            found.append(at_joint(joint.name, f"{text}beyond it {curve.beyond_words}"))
    return found


def _few_trials(learnt: int, held_out: int) -> list[str]:
    """``learnt`` : distinct training trials."""
    if learnt > 1:
        return []
    scored = "the gap is scored on the held-out trials" if held_out else "the gap is scored on the trial itself"
    text = f"only one training trial ({scored}): an effect and the peculiarities of this release cannot be "
    text += "separated, and the variation between trials is unknown; add two more, from other poses"
    return [decisive(text)]


def _driven_trials(leg: Leg, trials: Sequence[Trial]) -> list[str]:
    """What known torques leave out; a recorded current has its motor in the leg file, and that is no doubt."""
    driven = [trial for trial in trials if trial.torques is not None]
    acting = {trial.name: _torque_joints(leg, trial) for trial in driven}
    if driven and not any(acting.values()):
        column = "current" if all(trial.by_current for trial in driven) else "torque"
        return [decisive(f"{some_names(list(acting))}: the {column} columns are all zero")]
    by_column = {t.name: [each for each in acting[t.name] if each not in t.by_current] for t in driven}
    by_column = {name: each for name, each in by_column.items() if each}
    if not by_column:
        return []
    joints = [name for name in leg.joint_names if any(name in each for each in by_column.values())]
    return [
        f"{some_names(list(by_column))}: the torque columns of {', '.join(joints)} are applied as known torques "
        "without a motor model (winding, supply, gears); an error in them that is no offset, factor or delay would be "
        "attributed to the joint"
    ]


def _currents_not_recorded(leg: Leg, trials: Sequence[Trial]) -> list[str]:
    """Joints with a drive of known torque, in trials that have neither a torque nor a current of it: free there."""
    said = list[str]()
    for joint in leg.joints:
        if not isinstance(joint.drive, TorqueDrive):
            continue
        held = {trial.name for trial in trials if joint.name in (*trial.locked, *trial.drive_off)}
        free = [t.name for t in trials if t.name not in held and joint.name not in _torque_joints(leg, t)]
        if free:
            what, unit = ("torque", "N*m") if joint.drive.motor is None else ("current", "A")
            text = f"no {what} of its drive in {some_names(free)}: free there. If it was off, write drive_off: "
            text += f'[{joint.name}] beside the file; otherwise add the column "{joint.name} {what} [{unit}]"'
            said.append(at_joint(joint.name, decisive(text)))
    return said


def _torque_joints(leg: Leg, trial: Trial) -> list[str]:
    """Joints on which a known torque acts in the trial."""
    torques = trial.torques
    return [] if torques is None else [each for j, each in enumerate(leg.joint_names) if np.any(torques[:, j] != 0.0)]
