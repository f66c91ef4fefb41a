"""How far a servo as simulators have it moves from the diagnosed one: what they lack is left out, and its error stated.

MuJoCo's actuator is linear in angle and speed up to a limit, late by a constant time (``files.drive_terms``). A dead
band, a limited rate of the command, a supply that sags, control steps, a limit on the braking of the winding are left
out. The stand-in is that actuator; its motion under the commands of the trials tells what it leaves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from synth.diagnosis.plants.swinging_chain.stand_in import MOST_TRIALS, rms_degrees, simulate_motion
from synth.drives.servo import Servo
from synth.files.drive_terms import DriveTerms, drive_terms
from synth.files.trial_list import Trial
from synth.fit.recordings import Recording, recordings
from synth.swing.effects import effect_named
from synth.swing.leg_model import Damper, Joint, Leg

SHARED_EFFECT = "shared_source_resistance"


def drive_error(leg: Leg, trials: Sequence[Trial]) -> tuple[str, ...]:
    """A sentence on what the simulators' drives leave; empty where they lack nothing, or have none of that kind.

    ``leg`` : the diagnosed one. Joints that follow a voltage, or have a damper curve beside their drive, have none.
    """
    terms = drive_terms(leg)
    known = [each for each in terms if each is not None]
    if not any(each.lost for each in known) and SHARED_EFFECT not in leg.effects:
        return ()
    if any(each.volt for each in known) or any(_has_damper_curve(joint) for joint in leg.joints):
        return ()
    made = recordings(leg, trials, ())
    few = [made[k] for k in sorted({round(x) for x in np.linspace(0, len(made) - 1, MOST_TRIALS)})]
    plain = _with_plain_drives(leg, terms)
    apart = np.concatenate(
        [(simulate_motion(plain, _at_one_volt(each)) - simulate_motion(leg, each)).ravel() for each in few]
    )
    if not np.all(np.isfinite(apart)):
        return ("in the trials the drive as it stands here diverges from the diagnosed leg's motion",)
    error = rms_degrees(apart)
    return (f"in the trials the drive as it stands here moves {error:.2g} deg RMS away from the diagnosed leg",)


def _has_damper_curve(joint: Joint) -> bool:
    return isinstance(joint.drive, Servo) and joint.damper is not None and joint.damper.rate is None


def _with_plain_drives(leg: Leg, terms: Sequence[DriveTerms | None]) -> Leg:
    """The leg with each servo as a torque that follows at once, and its winding's braking in the joint's damper."""
    joints = [_joint_with_terms(joint, own) for joint, own in zip(leg.joints, terms, strict=True)]
    base = {name: values for name, values in leg.effects.items() if name != SHARED_EFFECT}
    return replace(leg, joints=tuple(joints), effects=base)


def _joint_with_terms(joint: Joint, own: DriveTerms | None) -> Joint:
    if own is None or not isinstance(joint.drive, Servo):
        return joint
    servo = Servo(
        own.stiffness,
        own.damping,
        delay=own.delay,
        torque_limit=min(own.limit, own.cut),
        linear_commands=joint.drive.linear_commands,
    )
    damper = joint.damper or Damper(0.0)
    kept = {name: values for name, values in joint.effects.items() if effect_named(name).way != "drive"}
    damper = replace(damper, rate=(damper.rate or 0.0) + own.braking)
    return replace(joint, drive=servo, damper=damper, armature=joint.with_rotor, effects=kept)


def _at_one_volt(recording: Recording) -> Recording:
    """A drive without a motor has its torque a radian, at one volt."""
    signals = recording.signals
    if signals is None:
        return recording
    return replace(recording, signals=replace(signals, supply=np.ones_like(signals.supply)))
