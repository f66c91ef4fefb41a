"""Friction that simulators' joints lack, as the dry friction and damping that move the leg most alike.

MuJoCo, URDF and SDF have one dry friction and one damping a joint. Friction that grows with a load or falls with speed
stands in them as the two numbers whose motions in the recorded trials, under the same commands, come nearest in the
least squares of the angles; how far they stay apart is stated.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array
from synth.files.trial_list import Trial
from synth.fit.recordings import Recording, recordings
from synth.swing.chain import simulate
from synth.swing.effects import effect_named
from synth.swing.leg_model import Damper, Joint, Leg
from synth.units import significant

STAND_IN_EFFECT = "coulomb_friction"  # of the frictions with a bristle the one that simulators have
MOST_TRIALS = 6  # evenly among all: two numbers a joint are determined by fewer
SAMPLES_A_TRIAL = 300  # of a trial's angles: commands act in full, only the comparison is thinner
START_SHARES = (0.01, 0.03, 0.1, 0.3)  # of the weight's torque about the joint, from a good bearing to a worm gear
RELATIVE_STEP = 1e-2  # relative step of the derivatives: above the integrator's error of 1e-6 rad
ITERATIONS = 15  # of the least squares: it settles in five to ten
# Of the dry friction, damping at the usual speed: a few steps of the least squares leave it above zero.
NEGLIGIBLE_SHARE = 1e-3
DIVERGED_DIFFERENCE = np.pi  # rad, difference that counts where a motion diverged


@dataclass(frozen=True)
class StandIn:
    """``leg`` : with dry friction and damping instead; ``texts`` : what stands for what, and the error it leaves."""

    leg: Leg
    texts: tuple[str, ...]


def lacking_frictions(joint: Joint) -> list[str]:
    """The joint's dry frictions that are not constant, by name."""
    return [name for name in joint.effects if name != STAND_IN_EFFECT and effect_named(name).kin == "bristle"]


def stand_in(leg: Leg, trials: Sequence[Trial]) -> StandIn | None:
    """The leg for simulators; None if its joints lack nothing that has a stand-in.

    ``leg`` : the diagnosed one. Joints with a damper curve keep it and get dry friction alone.
    """
    places = [index for index, joint in enumerate(leg.joints) if lacking_frictions(joint)]
    if not places:
        return None
    from scipy.optimize import least_squares

    made = recordings(leg, trials, ())
    few = [made[k] for k in sorted({round(x) for x in np.linspace(0, len(made) - 1, MOST_TRIALS)})]
    wanted = [simulate_motion(leg, recording) for recording in few]
    scale = np.ravel([(_outboard_weight(leg, j), _outboard_weight(leg, j) / _rms_speed(few, j)) for j in places])
    free = np.ravel([(True, _damper_rate(leg.joints[j]) is not None) for j in places])

    def apart(share: Array) -> Array:
        """(m,) rad, of all trials; ``share`` (k,) of the scales."""
        numbers = np.zeros(len(scale))
        numbers[free] = share
        other = _with_stand_ins(leg, places, numbers * scale)
        each = [simulate_motion(other, r) - w for r, w in zip(few, wanted, strict=True)]
        flat = np.concatenate([x.ravel() for x in each])
        return np.asarray(
            np.nan_to_num(flat, nan=DIVERGED_DIFFERENCE, posinf=DIVERGED_DIFFERENCE, neginf=-DIVERGED_DIFFERENCE)
        )

    starts = [share * _friction_mask(free) for share in START_SHARES]
    begun = min(starts, key=lambda x: float(np.sum(apart(x) ** 2)))
    found = least_squares(
        apart,
        begun + 1e-6,
        bounds=(0.0, np.inf),
        x_scale=0.1,
        diff_step=np.full(len(begun), RELATIVE_STEP),
        max_nfev=ITERATIONS,
    )
    numbers = np.zeros(len(scale))
    numbers[free] = found.x
    numbers[1::2] = np.where(numbers[1::2] > NEGLIGIBLE_SHARE * numbers[::2], numbers[1::2], 0.0)
    left, without = rms_degrees(found.fun), rms_degrees(apart(np.zeros(int(free.sum()))))
    return StandIn(
        _with_stand_ins(leg, places, numbers * scale),
        tuple(_stand_in_texts(leg, places, numbers * scale, left, without)),
    )


def _friction_mask(free: Array) -> Array:
    """1 for each dry friction among the free numbers, 0 for dampings."""
    return np.array([1.0 if index % 2 == 0 else 0.0 for index in np.flatnonzero(free)])


def rms_degrees(difference: Array) -> float:
    """RMS, degrees."""
    return float(np.degrees(np.sqrt(np.mean(difference**2))))


def simulate_motion(leg: Leg, recording: Recording) -> Array:
    """(m, n) rad, from the state at the recording's start under its commands; nan if it diverged."""
    every = max(1, len(recording.time) // SAMPLES_A_TRIAL)
    time = recording.time[::every]
    try:
        return simulate(
            leg,
            recording.smoothed.angle[0],
            recording.smoothed.rate[0],
            time,
            recording.conditions,
            known_torque=recording.known_torque,
            signals=recording.signals,
        )
    except ArithmeticError:
        return np.full((len(time), len(leg.joints)), np.nan)


def _outboard_weight(leg: Leg, place: int) -> float:
    """N m, of what is outboard of a joint with the leg stretched out level."""
    reach, torque = 0.0, 0.0
    for joint in leg.joints[place:]:
        torque += joint.link.mass * (reach + joint.link.com)
        reach += joint.link.length
    return torque * max(leg.gravity, 1.0)


def _rms_speed(made: Sequence[Recording], place: int) -> float:
    """rad/s, RMS over the trials."""
    rates = np.concatenate([recording.smoothed.rate[:, place] for recording in made])
    return max(float(np.sqrt(np.mean(rates**2))), 1e-3)


def _damper_rate(joint: Joint) -> float | None:
    """N m s/rad of a joint's damper, 0 without one, None for a curve."""
    return 0.0 if joint.damper is None else joint.damper.rate


def _with_stand_ins(leg: Leg, places: Sequence[int], numbers: Array) -> Leg:
    """With friction (N m) and damping (N m s/rad) at each of the places instead of what is lacking there."""
    joints = list(leg.joints)
    for place, (torque, damping) in zip(places, numbers.reshape(-1, 2).tolist(), strict=True):
        joint, gone = joints[place], lacking_frictions(joints[place])
        kept: dict[str, Mapping[str, float]] = {k: v for k, v in joint.effects.items() if k not in gone}
        kept[STAND_IN_EFFECT] = {"torque": torque, "presliding": joint.effects[gone[0]].get("presliding", 0.0)}
        rate = _damper_rate(joint)
        damper = joint.damper if rate is None else replace(joint.damper or Damper(), rate=rate + damping)
        joints[place] = replace(joint, effects=kept, damper=damper)
    return replace(leg, joints=tuple(joints))


def _stand_in_texts(leg: Leg, places: Sequence[int], numbers: Array, left: float, without: float) -> list[str]:
    texts = []
    for place, (torque, damping) in zip(places, numbers.reshape(-1, 2).tolist(), strict=True):
        what = " and ".join(lacking_frictions(leg.joints[place]))
        more = f" and damping of {damping:.3g} N*m*s/rad" if damping > 0.0 else ""
        texts.append(f"{leg.joints[place].name}: {what} stands as dry friction of {torque:.3g} N*m{more}")
    error = f"in the trials it moves {significant(left, 2)} deg RMS away from the diagnosed leg, without any friction "
    return [*texts, error + f"there {significant(without, 2)} deg"]
