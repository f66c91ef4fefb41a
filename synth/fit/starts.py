"""Starting points of a fit: first and last samples of trials, the weak form's solution, and random draws."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from synth.arrays import Array, Mask
from synth.fit.fit_options import LegFitOptions
from synth.fit.fit_problem import unknowns_of
from synth.fit.free_angle import WIDE
from synth.fit.recordings import Recording
from synth.fit.trajectories import FIT_STEPS, Local, TrajectoryModel
from synth.fit.weak_form import LinearEstimate, WeakForm
from synth.motion.rest import last_tenths
from synth.motion.smoothing import initial_state
from synth.swing.known_torque import average_torques
from synth.swing.leg_model import Leg
from synth.swing.mechanics import coefficients, outboard_inertia, static_torque
from synth.threads import shared_out

# In the recordings' unit of time, as all of the following.
WINDOWS = (0.1, 0.2, 0.05)  # s, weak-form windows that are tried
NATURAL_STARTS = ((3.0, 20.0), (6.0, 100.0), (1.0, 2.0), (4.0, 5.0))  # Hz of k/I, 1/s of b/I
# Tolerance of the integration, 1e-4 rad being far below the differences between candidates, and samples a trial at
# which these are compared: a motion of some periods needs tens.
RANKING, RANKED = 1e-4, 125
DRAWN = 24  # random starts, tried if the fit from the weak form is ``POOR``
DRAWN_FREQUENCY, DRAWN_DECAY = (1.0, 10.0), (1.0, 100.0)  # Hz of k/I, 1/s of b/I
DRAWN_REST = 0.2  # rad about the mean final pose of the trials


@dataclass(frozen=True)
class Start:
    """The beginning and end of a trial: ``rotation``, ``rate``, ``end`` (n,) rad and rad/s."""

    rotation: Array
    rate: Array
    end: Array


@dataclass(frozen=True)
class FirstGuess:
    """Unknowns (p,) and shifts (n_trial, n) rad of each trial's rest angles at the start of a fit."""

    values: Array
    shifts: Array


def starts(recordings: Sequence[Recording]) -> tuple[Start, ...]:
    """From the smoothed recordings: the state of the first sample, and the mean pose of the last tenth."""
    found = []
    for recording in recordings:
        rotation, rate = initial_state(recording.smoothed)
        found.append(Start(rotation, rate, last_tenths(recording.smoothed.angle)))
    return tuple(found)


def first_locals(recordings: Sequence[Recording]) -> list[Local]:
    """Each trial's own unknowns from its first samples, without shifts."""
    found = []
    for recording in recordings:
        rotation, rate = initial_state(recording.smoothed)
        found.append(Local(rotation, rate, np.zeros_like(rotation)))
    return found


def balanced_rests(leg: Leg, recordings: Sequence[Recording], ends: Sequence[Array], spring_rate: Array) -> Array:
    """Rest angles that balance each trial's final pose against gravity and known torques.

    Parameters
    ----------
    ends : (n,) rad a trial.
    spring_rate : (n, c) N m/rad, a candidate a column.

    Returns
    -------
    (n_trial, n, c) rad.
    """
    poses = _end_poses(leg, recordings, ends)
    return np.asarray(poses.angle[:, :, None] + poses.weight[:, :, None] / spring_rate)


@dataclass(frozen=True)
class _Poses:
    """``angle`` (n_trial, n) rad and ``weight`` (n_trial, n) N m, the spring torques that hold them.

    Against gravity, and against the mean of a known torque over the last tenth of the recording.
    """

    angle: Array
    weight: Array


def _end_poses(leg: Leg, recordings: Sequence[Recording], ends: Sequence[Array]) -> _Poses:
    """The final poses (n,) rad a trial, with their weight."""
    tips = {recording.conditions.tip for recording in recordings}
    known = {tip: coefficients(leg, tip) for tip in tips}
    weight = [
        static_torque(known[recording.conditions.tip], end, leg.tilt + recording.conditions.tilt)
        - _torque_at_end(recording)
        for recording, end in zip(recordings, ends, strict=True)
    ]
    return _Poses(np.array(ends), np.array(weight))


def _torque_at_end(recording: Recording) -> Array:
    """(n,) N m on q, mean of the known torque over the last tenth of the recording; 0 without one."""
    if recording.known_torque is None:
        return np.zeros(recording.rotation.shape[1])
    return last_tenths(average_torques(recording.known_torque, recording.smoothed.time))


def weak_form_start(model: TrajectoryModel, recordings: Sequence[Recording], options: LegFitOptions) -> FirstGuess:
    """The weak form's solution with the window whose trajectories are nearest to the trials."""
    leg, inertia, unknowns = model.leg, outboard_inertia(model.leg), unknowns_of(model)
    curves = [options.curves.get(name) for name in leg.joint_names]
    known = np.array([curve is not None for curve in curves])
    poses = _end_poses(leg, recordings, [last_tenths(recording.smoothed.angle) for recording in recordings])
    lowest, highest = unknowns.box.rests(len(leg.joints), np.pi)
    weak, tried, unit = WeakForm(leg, recordings, curves), [], recordings[0].unit
    for window in WINDOWS:
        for found in weak.solve(window * unit)[: 2 if len(recordings) > 1 else 1]:
            usable = (found.spring_rate > 0) & ((found.damper_rate > 0) | known)
            for rate, damping, own in _joints_at_start(found, usable, poses, inertia, unit):
                rest = np.where(usable, np.nan_to_num(found.rest), np.median(own, axis=0))
                own = np.where(usable & found.per_trial, found.rest_by_trial, own)
                shift = np.clip(np.nan_to_num(own - rest), -2 * WIDE, 2 * WIDE) * (options.free_angle != "common")
                tried.append(FirstGuess(unknowns.pack(rate, np.clip(rest, lowest, highest), damping), shift))
    costs = quick_costs(model, recordings, [guess.values for guess in tried], [guess.shifts for guess in tried])
    return tried[int(np.argmin(costs))]


def _joints_at_start(
    found: LinearEstimate, usable: Mask, poses: _Poses, inertia: Array, unit: float
) -> Iterator[tuple[Array, Array, Array]]:
    """Spring rates (n,), damper rates (n,), and rest angles (n_trial, n) that balance each trial's end.

    A joint that is ``usable`` (n,) has the rates found. Noise, or a joint that moves as no passive one does, can make a
    rate negative: the joint then starts at typical limb values, from springy to well damped. So can the absence of a
    spring or damper, whose rate is then found as zero but for its error: the joint also starts with rates of that size,
    where gravity, not the spring, sets the end. From a limb's springs a free pendulum's motion is not found again.
    """
    for frequency, decay in NATURAL_STARTS if not np.all(usable) else NATURAL_STARTS[:1]:
        rate = np.where(usable, found.spring_rate, inertia * (2 * np.pi * frequency / unit) ** 2)
        yield rate, np.where(usable, found.damper_rate, inertia * decay / unit), poses.angle + poses.weight / rate
    slack = ~usable & (found.spring_rate != 0.0) & np.isfinite(found.spring_rate) & np.isfinite(found.damper_rate)
    if slack.any():
        frequency, decay = NATURAL_STARTS[0]
        rate = np.where(usable | slack, np.abs(found.spring_rate), inertia * (2 * np.pi * frequency / unit) ** 2)
        damping = np.where(usable | slack, np.abs(found.damper_rate), inertia * decay / unit)
        yield rate, damping, np.where(slack, np.median(poses.angle, axis=0), poses.angle + poses.weight / rate)


def drawn_starts(model: TrajectoryModel, recordings: Sequence[Recording], seed: int) -> list[Array]:
    """Unknowns (p,) in the range of limbs, ``DRAWN`` of them, random in natural units."""
    random = np.random.default_rng(seed)
    n, inertia, unknowns = len(model.leg.joints), outboard_inertia(model.leg), unknowns_of(model)
    rest = np.mean([last_tenths(recording.smoothed.angle) for recording in recordings], axis=0)
    slow, fast = (float(np.log(frequency)) for frequency in DRAWN_FREQUENCY)
    light, heavy = (float(np.log(decay)) for decay in DRAWN_DECAY)
    drawn, unit = [], recordings[0].unit
    for _ in range(DRAWN):
        rate = inertia * (2 * np.pi * np.exp(random.uniform(slow, fast, n)) / unit) ** 2
        damping = inertia * np.exp(random.uniform(light, heavy, n)) / unit
        drawn.append(unknowns.pack(rate, rest + random.uniform(-DRAWN_REST, DRAWN_REST, n), damping))
    return drawn


def quick_costs(
    model: TrajectoryModel,
    recordings: Sequence[Recording],
    candidates: Sequence[Array],
    shifts: Sequence[Array] | None = None,
) -> Array:
    """(n_candidate,) squared residuals of trajectories from the smoothed initial states; inf if the motion diverges.

    They only rank the candidates, so they are integrated to ``RANKING`` and compared at ``RANKED`` samples a trial.

    ``candidates`` : unknowns (p,) each, all lanes of one simulation per trial. ``shifts`` : of the rest angles,
    (n_trial, n) rad per candidate.
    """
    values, locals_ = np.stack(candidates, axis=1), first_locals(recordings)
    model, recordings = model.at_tolerance(RANKING, FIT_STEPS), [recording.thinned(RANKED) for recording in recordings]
    none = np.zeros((recordings[0].rotation.shape[1], len(candidates)))

    def one(t: int) -> Array:
        shift = none if shifts is None else np.stack([found[t] for found in shifts], axis=1)
        out = model.predictions(recordings[t], values, locals_[t], shift)
        off = np.where(recordings[t].counts[:, :, None], out - recordings[t].rotation[:, :, None], 0.0)
        return np.where(np.all(np.isfinite(out), axis=(0, 1)), np.sum(off**2, axis=(0, 1)), np.inf)

    return np.asarray(np.sum(shared_out(one, len(recordings)), axis=0))
