"""Location of the gap: missing torque joint by joint, and the error by phase, speed, position and load."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial
from synth.diagnosis.diagnosis_result import PHASES, THIRDS, Where, shares
from synth.diagnosis.plants.swinging_chain.leg_torques import acting_torques, joint_torques
from synth.motion.smoothing import Smoothed, odd_points, smooth
from synth.swing.leg_model import Leg
from synth.swing.mechanics import coefficients, momentum_and_force, outboard_inertia

WINDOW_RATIO = 8 / 3  # of the smoothing's width, width of the test functions that replace the second derivative
SWING_END = 0.2  # of the release's envelope
LEAST_SQUARE = 1e-12  # rad^2, rad^2/s^2: of a joint that is locked in all trials, whose missing torque is not known
Phases = NDArray[np.int64]


@dataclass(frozen=True)
class MissingTorque:
    """``time`` (w,) s, centres of the windows; ``torque`` (w, n) N m on q that the model lacks to move as recorded."""

    time: Array
    torque: Array


def missing_torque(leg: Leg, trial: AngleTrial) -> MissingTorque:
    """Torque on each joint that the given leg lacks, averaged over short windows.

    The momentum outboard of a joint changes only by the joint's own torque and known forces, so a neighbour's missing
    torque is not visible here. The weak form (test function times equation, integrated by parts; see ``fit.weak_form``)
    needs no second derivative of a recording. A trial with its own leg is compared with that leg as
    designed.
    """
    leg = trial.recording.leg or leg
    smoothed = trial.recording.smoothed
    step = float(smoothed.time[1] - smoothed.time[0])
    count = len(smoothed.time)
    support = max(8, min(round(WINDOW_RATIO * smoothed.width / step), (count - 1) // 3))
    u = np.linspace(-1.0, 1.0, support + 1)
    bump = (1.0 - u * u) ** 3
    slope = -6.0 * u * (1.0 - u * u) ** 2 * 2.0 / (support * step)
    conditions = trial.recording.conditions
    found = coefficients(leg, conditions.tip)
    momentum, force = momentum_and_force(found, smoothed.angle, smoothed.rate, leg.tilt + conditions.tilt)
    known = force + acting_torques(leg, trial.recording)
    view = np.lib.stride_tricks.sliding_window_view
    starts = np.arange(0, count - support, max(1, support // 4))
    starts = starts[~view(smoothed.gap, support + 1)[starts].any(axis=1)]
    area = bump.sum() * step
    change = -(view(momentum, support + 1, axis=0)[starts] @ slope) * step
    acting = (view(known, support + 1, axis=0)[starts] @ bump) * step
    torque = (change - acting) / area
    torque[:, [j for j in range(len(leg.joints)) if j not in trial.free]] = np.nan
    return MissingTorque(smoothed.time[starts + support // 2], torque)


def rate_noise(smoothed: Smoothed, noise: Array) -> Array:
    """Standard deviation (n,) rad/s of the smoothed rates due to noise (``noise`` (n,) rad), see ``smooth``."""
    step = float(np.median(np.diff(smoothed.time)))
    half = odd_points(smoothed.width, step) // 2
    inverse = np.linalg.pinv(np.vander(np.arange(-half, half + 1.0), 4, increasing=True))
    return np.asarray(noise * float(np.linalg.norm(inverse[1])) / step)


def phases(trial: AngleTrial, noise: Array) -> Phases:
    """(m,) index into ``PHASES`` of a trial's samples.

    The envelope at a time is the largest later distance of any joint from the last pose; ``settle`` ends
    when every joint's speed stays below its own noise.
    """
    smoothed = trial.recording.smoothed
    free, time = trial.free, smoothed.time
    count = len(time)
    end = smoothed.angle[-max(3, count // 20) :].mean(axis=0)  # the last twentieth
    away = np.abs(smoothed.angle - end)[:, free]
    reach = np.maximum(away.max(axis=0), 1e-9)
    envelope = np.maximum.accumulate((away / reach)[::-1], axis=0)[::-1].max(axis=1)
    speed = np.abs(smoothed.rate[:, free])
    floor = 3.5 * rate_noise(smoothed, noise[free])  # none of some thousand samples exceeds it by chance
    first_peak = int(np.argmax(_first_peaks(speed)))
    moving = np.flatnonzero(np.any(speed > floor, axis=1))
    rest = int(moving[-1]) + 1 if len(moving) else 0
    swing_end = int(np.flatnonzero(envelope >= SWING_END)[-1]) + 1 if np.any(envelope >= SWING_END) else 0
    index = np.full(count, 2)
    index[: max(swing_end, first_peak)] = 1
    index[:first_peak] = 0
    index[rest:] = 3
    nearest = np.clip(np.searchsorted(time, trial.time), 0, count - 1)
    return index[nearest]


def _first_peaks(speed: Array) -> NDArray[np.bool_]:
    """(n_time,) True from the first local maximum of the fastest joint's speed."""
    fastest = speed[:, int(np.argmax(speed.max(axis=0)))]
    high = fastest > 0.5 * fastest.max()
    turning = np.r_[False, (fastest[1:-1] >= fastest[:-2]) & (fastest[1:-1] > fastest[2:]), False] & high
    return np.asarray(np.maximum.accumulate(turning))


def locate_gap(
    leg: Leg,
    trials: Sequence[AngleTrial],
    predictions: Sequence[Array],
    noise: Array,
    missing: Sequence[MissingTorque],
    blamed: Mapping[str, float],
) -> Where:
    """Shares of the gap left by the nominal leg's best fit.

    Parameters
    ----------
    predictions : (m, n) rad per trial, by the nominal leg's best fit.
    missing : torque that this leg lacks, per trial.
    blamed : joint -> probability that it has a cause; the rest is divided by the missing torque.
    """
    squares = {name: np.zeros(len(labels)) for name, labels in _LABELS.items()}
    for trial, prediction in zip(trials, predictions, strict=True):
        excess = np.where(trial.counts, (prediction - trial.measured) ** 2 - noise**2, 0.0)
        phase = phases(trial, noise)
        rows = {"phase": np.broadcast_to(phase[:, None], excess.shape)}
        rows |= _thirds_of_ranges(leg, trial)
        for name, index in rows.items():
            np.add.at(squares[name], index.ravel(), excess.ravel())
    by_name = {name: shares(_LABELS[name], total) for name, total in squares.items()}
    by_torque = _torque_shares(leg, trials, missing, noise)
    rest = max(0.0, 1.0 - sum(blamed.values()))
    joint = {name: blamed.get(name, 0.0) + rest * by_torque[name] for name in leg.joint_names}
    total = sum(joint.values())
    return Where({name: value / total for name, value in joint.items()}, **by_name)


def locate_remainder(
    leg: Leg, trials: Sequence[AngleTrial], predictions: Sequence[Array], noise: Sequence[Array], usual: Array
) -> tuple[dict[str, float], dict[str, float]]:
    """Shares of each joint, and of each phase, in the squared prediction error above the noise.

    ``noise`` : (m, n) rad per trial, of each reading about its prediction; ``usual`` (n,) rad of the sensors.
    """
    joints, by_phase = np.zeros(len(leg.joints)), np.zeros(len(PHASES))
    for trial, prediction, about in zip(trials, predictions, noise, strict=True):
        excess = np.where(trial.counts, (prediction - trial.measured) ** 2 - about**2, 0.0)
        excess = np.nan_to_num(excess)
        joints += excess.sum(axis=0)
        np.add.at(by_phase, phases(trial, usual), excess.sum(axis=1))
    free = {j for trial in trials for j in trial.free}
    names = [name for j, name in enumerate(leg.joint_names) if j in free]
    return shares(names, joints[sorted(free)]), shares(PHASES, by_phase)


_LABELS: dict[str, tuple[str, ...]] = {
    "phase": PHASES, "speed": THIRDS, "position": THIRDS, "load": THIRDS, "time": THIRDS
}  # fmt: skip


def _thirds_of_ranges(leg: Leg, trial: AngleTrial) -> dict[str, NDArray[np.int64]]:
    """Index 0..2 of each sample and joint by speed, deflection and carried torque, and by time.

    A trial with its own leg is deflected from that leg's free angles, and its springs and dampers carry
    the torque.
    """
    leg, smoothed = trial.recording.leg or leg, trial.recording.smoothed
    nearest = np.clip(np.searchsorted(smoothed.time, trial.time), 0, len(smoothed.time) - 1)
    speed = np.abs(smoothed.rate[nearest])
    position = np.abs(smoothed.angle[nearest] - leg.rest)
    load = np.abs(joint_torques(leg, smoothed.angle, smoothed.rate)[nearest])
    time = np.repeat(trial.time[:, None], len(leg.joints), axis=1)
    sized = {"speed": speed, "position": position, "load": load, "time": time}
    return {
        name: np.minimum((3.0 * value / np.maximum(value.max(axis=0), 1e-12)).astype(np.int64), 2)
        for name, value in sized.items()
    }


def _torque_shares(
    leg: Leg, trials: Sequence[AngleTrial], missing: Sequence[MissingTorque], noise: Array
) -> dict[str, float]:
    """Share of each joint in the missing torque, each as the deflection that it causes."""
    energy = np.zeros(len(leg.joints))
    for trial, found in zip(trials, missing, strict=True):
        floor = _torque_noise(leg, trial, noise)
        square = np.nan_to_num(found.torque) ** 2 - floor**2
        energy += np.nansum(np.where(np.isfinite(found.torque), square, 0.0), axis=0)
    return shares(leg.joint_names, np.maximum(energy, 0.0) / _holding_stiffness(leg, trials) ** 2)


def _holding_stiffness(leg: Leg, trials: Sequence[AngleTrial]) -> Array:
    """(n,) N m/rad that holds each joint: of its spring, and of gravity on the links that hang straight from it.

    Where neither holds a joint, its motion tells: outboard inertia times the mean square of the rate over that of the
    deflection.
    """
    held = leg.spring_rate + np.cumsum(coefficients(leg).gravity[::-1])[::-1]
    if np.all(held > 0.0):
        return np.asarray(held)
    swung = [trial.recording.smoothed for trial in trials]
    of_rate = sum((np.sum(each.rate**2, axis=0) for each in swung), np.zeros(len(leg.joints)))
    of_angle = sum(
        (np.sum((each.angle - each.angle.mean(axis=0)) ** 2, axis=0) for each in swung), np.zeros_like(of_rate)
    )
    moved = outboard_inertia(leg) * np.maximum(of_rate, LEAST_SQUARE) / np.maximum(of_angle, LEAST_SQUARE)
    return np.asarray(np.where(held > 0.0, held, moved))


def _torque_noise(leg: Leg, trial: AngleTrial, noise: Array) -> Array:
    """(n,) RMS of the apparent missing torque due to noise, found by adding the same noise again."""
    generator = np.random.default_rng(0)
    recording = trial.recording
    shaken = recording.rotation + noise * generator.standard_normal(recording.rotation.shape)
    locked = list(recording.conditions.locked)
    lost = ~recording.counts | ~np.isfinite(shaken)
    lost[:, locked] = False  # samples of a locked joint do not count, but it is held at the recorded angle
    again = smooth(recording.time, shaken, lost, recording.smoothed.width)
    for j in locked:
        again.angle[:, j], again.rate[:, j] = recording.smoothed.angle[:, j], 0.0
    more = replace(trial, recording=replace(recording, smoothed=again))
    difference = missing_torque(leg, more).torque - missing_torque(leg, trial).torque
    return np.asarray(np.sqrt(np.mean(np.nan_to_num(difference) ** 2, axis=0)))
