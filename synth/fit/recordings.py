"""Trials prepared for the fit: rotations, counted samples, and conditions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from synth.arrays import Array, Mask
from synth.drives.servo import Servo, ServoSignals, integral_along
from synth.errors import Problem, UserError
from synth.fit.trial_channels import counted_from, known_torque, rows_read, servo_signals, with_recorded_rates
from synth.motion.first_state import FirstState, first_state
from synth.motion.group_spread import GroupSpread
from synth.motion.low_pass import SeenFilter
from synth.motion.smoothing import Smoothed, lost_samples, smooth
from synth.motion.thinning import thin_recording
from synth.motion.time_step import stepped_unit
from synth.remarks import decisive, noted
from synth.sampling import channel_step, every_nth, own_moments, usual_step
from synth.swing.chain import Conditions
from synth.swing.integral_starts import held_integrals
from synth.swing.known_torque import average_torques
from synth.swing.leg_model import Leg

if TYPE_CHECKING:
    from synth.files.trial_list import Trial

LEAST_SAMPLES = 12  # samples of a trial: fewer determine neither its noise nor its initial state
LEAST_MOTION = np.radians(0.5)  # rad; a smaller motion is not a release
LOCKED_RANGE = np.radians(5.0)  # rad, of most samples: a clamped joint gives less, even with its play
RANGE_SHARES = (0.05, 0.95)  # shares of the samples between which a joint's range is taken: glitches do not count


@dataclass(frozen=True)
class Recording:
    """One trial in the chain's coordinates.

    ``time`` (m,) s from 0; ``rotation`` (m, n) rad, locked joints at their held angle; ``counts`` (m, n) True for
    samples used in the fit; ``known_torque`` as for ``Chain.run`` or None; ``thinning`` : message on a
    recording with more samples than its motion needs, else empty; ``unit`` : s, of the constants of a fit and of
    the integrator, one for all recordings (``motion.time_step``); ``unwrapped`` : message on whole turns that were
    removed, else empty; ``unusual`` : names of joints and rad that their angles cover, as of a trial; ``by_current`` :
    joints whose known torque is a recorded current times their motor's constant; ``behind`` : the filter that the
    readings of all recordings look to have passed, None if they show none or it was not looked for; ``left_out`` (m, n)
    True for good samples that do not count because the cost leaves them out, None: no such.
    """

    name: str
    time: Array
    rotation: Array
    counts: Mask
    conditions: Conditions
    smoothed: Smoothed
    known_torque: tuple[Array, Array] | None = None
    n_lost: int = 0
    leg: Leg | None = None  # the trial's own leg, if it differs
    thinning: str = ""
    signals: ServoSignals | None = None  # inputs of the servos
    averaged: tuple[int, ...] = ()  # readings whose mean each angle is, joint by joint; empty: 1
    unit: float = 1.0
    unwrapped: str = ""
    unusual: tuple[tuple[str, float], ...] = ()
    spread: GroupSpread | None = None  # of the samples about the angles; None: each angle is a sample
    by_current: tuple[int, ...] = ()
    behind: SeenFilter | None = None
    left_out: Mask | None = None

    @cached_property
    def known(self) -> Mask:
        """(m, n) True for good samples, those that the cost leaves out too."""
        return self.counts if self.left_out is None else self.counts | self.left_out

    @cached_property
    def step(self) -> float:
        """Usual time between the samples of the joint that is sampled fastest, s."""
        return usual_step(self.time, self.known[:, self.free])

    @cached_property
    def steps(self) -> tuple[float, ...]:
        """Usual time between the samples of each joint, s; ``step`` of one without any."""
        own = [channel_step(self.time, column) for column in self.known.T]
        return tuple(each if each > 0.0 else self.step for each in own)

    @property
    def driven(self) -> bool:
        """Whether a known torque or a servo acts."""
        return self.known_torque is not None or self.signals is not None

    def known_force(self, leg: Leg) -> Array | None:
        """(k, n) N m on q of known torques and of the leg's servos along the smoothed motion; None without either."""
        if not self.driven:
            return None
        force = np.zeros_like(self.smoothed.angle)
        if self.known_torque is not None:
            force += average_torques(self.known_torque, self.smoothed.time)
        if self.signals is not None:
            force += _servo_torque(leg, self.signals, self.smoothed, self.conditions)
        return force

    @cached_property
    def initial_rate(self) -> tuple[Array, Array]:
        """Initial rate (n,) rad/s from the smoothed samples, and its standard deviation (n,): the diagnosis' prior.

        A fit has a narrower one, ``start``, and one for the angle. The odds of the diagnosis are tuned with this one.

        The deviation is that of what the samples do not show. The initial rate of a joint so damped that it decays
        within a sample may be any, and without a prior any would fit. The largest observed rate is the one size of a
        rate that the recording gives: a smaller deviation would hold the start to the slow motion after the decay, and
        a larger one would allow rates that no sample shows. The trajectory determines all others far better.
        """
        largest = np.abs(self.smoothed.rate).max(axis=0)
        return self.smoothed.rate[0], largest + self.smoothed.noise / self.step + 1e-6

    @cached_property
    def first_samples(self) -> FirstState:
        """The state at the release as the first samples alone tell it."""
        # Rounding to counts is detected from a joint's smallest difference over a series only; here the
        # scatter suffices.
        return first_state(self.time, self.rotation, self.counts, self.smoothed.noise, unit=self.unit)

    @cached_property
    def start(self) -> FirstState:
        """The state at the release from the first samples, with its uncertainty: the prior of a trial's start in a fit.

        The diagnosis has ``initial_rate`` for the rate, and none for the angle. This one follows the first samples, not
        the largest rate: its deviation is 0.2 to 0.9 of that one's in releases of two simulated legs.

        The rate's deviation includes the rate itself. If a joint is so damped that its initial rate decays within a
        sample, the samples show the slow motion that follows and not the rate before it, which may have been zero: a
        smaller deviation would bias the start of every trial the same way, and k and b with it.
        """
        found = self.first_samples
        rate = np.hypot(found.rate_deviation, np.abs(found.rate)) + self.smoothed.noise / self.step + 1e-6
        return replace(found, angle_deviation=found.angle_deviation + 1e-6, rate_deviation=rate)

    @cached_property
    def levels(self) -> tuple[Array, ...]:
        """The distinct counted readings of each joint, rad, rising; those of an encoder show its counts."""
        return tuple(np.unique(self.rotation[self.counts[:, j], j]) for j in range(self.rotation.shape[1]))

    @cached_property
    def free(self) -> list[int]:
        """Joints that are not locked."""
        return [j for j in range(self.rotation.shape[1]) if j not in self.conditions.locked]

    @property
    def _held(self) -> Mask:
        """(n,) True for locked joints, whose samples do not count."""
        return np.isin(np.arange(self.rotation.shape[1]), self.conditions.locked)

    @cached_property
    def moments(self) -> Mask:
        """(m, n) True at the samples of each joint, counted or lost; False where only others are sampled."""
        return own_moments(self.time, self.known | self._held)

    def channel(self, j: int) -> tuple[Array, Array, Mask]:
        """Times (k,) s of a joint's own moments, its rotations (k,) rad, and whether each counts (k,)."""
        own = self.moments[:, j]
        return self.time[own], self.rotation[own, j], self.counts[own, j]

    def later(self, first: int) -> Recording:
        """The same motion from sample ``first``, its time from 0."""
        start = self.time[first]
        time, rotation = self.time[first:] - start, self.rotation[first:]
        smoothed = smooth(time, rotation, ~(self.known[first:] | self._held))
        for j in self.conditions.locked:
            smoothed.rate[:, j] = 0.0
        known = self.known_torque
        if known is not None:
            known = (known[0] - start, known[1])
        drive_signals = None if self.signals is None else self.signals.later(start)
        return replace(
            self,
            time=time,
            rotation=rotation,
            counts=self.counts[first:],
            left_out=None if self.left_out is None else self.left_out[first:],
            smoothed=smoothed,
            known_torque=known,
            signals=drive_signals,
            spread=self.spread and self.spread.rows(slice(first, None)),
        )

    def between(self, begin: float, end: float) -> Recording:
        """The samples from ``begin`` to ``end``, s, with the time from 0; smoothed as before."""
        inside = (self.time >= begin - 1e-9) & (self.time <= end + 1e-9)
        old = self.smoothed
        grid = slice(int(np.argmin(np.abs(old.time - begin))), int(np.argmin(np.abs(old.time - end))) + 1)
        smoothed = replace(
            old, time=old.time[grid] - begin, angle=old.angle[grid], rate=old.rate[grid], gap=old.gap[grid]
        )
        known = self.known_torque
        return replace(
            self,
            name=f"{self.name} from {begin:.3g} s",
            time=self.time[inside] - begin,
            rotation=self.rotation[inside],
            counts=self.counts[inside],
            left_out=None if self.left_out is None else self.left_out[inside],
            smoothed=smoothed,
            known_torque=None if known is None else (known[0] - begin, known[1]),
            signals=None if self.signals is None else self.signals.later(begin),
            spread=self.spread and self.spread.rows(inside),
        )

    def stretched(self, factor: float) -> Recording:
        """The same motion ``factor`` times slower: equal amplitudes, lower rates.

        Raises
        ------
        ValueError : a known torque or a servo acts, whose scaling depends on another leg.
        """
        if self.driven:
            raise ValueError(f"{self.name}: a motion driven by a known torque or a servo cannot be stretched")
        old = self.smoothed
        smoothed = replace(
            old, time=old.time * factor, rate=old.rate / factor, width=old.width * factor, pace=old.pace * factor
        )
        spread = self.spread and self.spread.stretched(factor)
        return replace(self, time=self.time * factor, smoothed=smoothed, spread=spread)

    def thinned(self, samples: int) -> Recording:
        """The same motion with about ``samples`` of each joint's samples, evenly spaced."""
        kept, left_out = every_nth(self.moments, samples), self.left_out
        if left_out is not None:  # where few samples count, every n-th moment may have none of them
            kept |= every_nth(self.counts, samples)
        some = np.asarray(kept.any(axis=1))
        counts, spread = (self.counts & kept)[some], self.spread and self.spread.rows(some)
        left_out = None if left_out is None else (left_out & kept)[some]
        rotation = self.rotation[some]
        return replace(self, time=self.time[some], rotation=rotation, counts=counts, left_out=left_out, spread=spread)


def recordings(leg: Leg, trials: Sequence[Trial], sought: Sequence[str] | None = None) -> list[Recording]:
    """Trials of a leg as recordings; ``sought``: joints that must move in some trial, None: all.

    Raises
    ------
    UserError : a trial is too short, a joint has too few samples, or a free joint moves in no trial; where any is
        sought, a locked joint moves.
    """
    made, problems = [], []
    for trial in trials:
        try:
            made.append(_read_recording(leg, trial))
            problems += _moving_locked(leg, trial) if sought is None or sought else []
        except UserError as error:
            problems += error.problems
    problems += [] if problems else _unmoved_joints(leg, made, sought)
    if problems:
        raise UserError(problems)
    unit = stepped_unit([recording.smoothed.pace for recording in made])
    return made if unit == 1.0 else [replace(recording, unit=unit) for recording in made]


def _read_recording(leg: Leg, trial: Trial) -> Recording:
    read = rows_read(trial)
    trial = counted_from(trial, float(trial.time[read][0]))
    names, time = leg.joint_names, trial.time[read]
    if len(time) < LEAST_SAMPLES:
        text = f"{len(time)} samples over {time[-1] * 1e3:.4g} ms; a trial needs at least {LEAST_SAMPLES} samples"
        raise UserError(Problem(text, file=trial.name))
    rotation = leg.to_rotation(trial.angles[read])
    found = lost_samples(time, rotation)
    n_lost, thin = int((found & own_moments(time, ~found)).sum()), thin_recording(time, rotation, found)
    trial = counted_from(trial, float(thin.time[0]))
    time, rotation, lost = thin.time - thin.time[0], thin.angle, thin.lost
    few = [name for j, name in enumerate(names) if (~lost[:, j]).sum() < LEAST_SAMPLES]
    if few:
        text = f"fewer than {LEAST_SAMPLES} usable samples of {', '.join(few)}"
        raise UserError(Problem(text, file=trial.name))
    locked = tuple(names.index(name) for name in trial.locked)
    counts = ~lost
    smoothed = with_recorded_rates(leg, trial, smooth(time, rotation, lost, locked=locked))
    for j in locked:
        held = float(np.median(rotation[~lost[:, j], j]))
        rotation[:, j], smoothed.angle[:, j], smoothed.rate[:, j] = held, held, 0.0
        counts[:, j] = False
    rotation = np.where(np.isfinite(rotation), rotation, 0.0)
    conditions = Conditions(locked, trial.tip_mass, trial.tilt, trial.tip_inertia, trial.tip_at)
    return Recording(
        trial.name,
        time,
        rotation,
        counts,
        conditions,
        smoothed,
        known_torque(leg, trial, float(time[-1]), smoothed.pace),
        n_lost,
        trial.leg,
        thin.sentence,
        servo_signals(leg, trial),
        thin.averaged,
        unwrapped=_jump_message(leg, trial),
        unusual=tuple((name, wide) for name, wide in zip(leg.joint_names, trial.unusual, strict=False) if wide),
        spread=thin.spread,
        by_current=tuple(names.index(name) for name in trial.by_current),
    )


def joints_by_current(recordings: Sequence[Recording]) -> list[int]:
    """Joints whose torque is a recorded current times their motor's constant wherever one is known."""
    known = [(recording, recording.known_torque[1]) for recording in recordings if recording.known_torque is not None]
    driven = {j for _, torque in known for j in np.flatnonzero(torque.any(axis=0)).tolist()}
    return sorted(j for j in driven if all(j in recording.by_current for recording, t in known if t[:, j].any()))


def _jump_message(leg: Leg, trial: Trial) -> str:
    """The message on removed jumps and whole turns; empty if there were none."""
    counts = [f"{name} {count}" for name, count in zip(leg.joint_names, trial.jumps, strict=False) if count]
    turned = [f"{name} {360 * k:+d} deg" for name, k in zip(leg.joint_names, trial.turned, strict=False) if k]
    texts = [f"jumps by a whole turn were removed ({', '.join(counts)}): the readings are wrapped"] if counts else []
    if turned:
        texts.append(f"turned back by whole turns to where the other trials are ({', '.join(turned)})")
    return "; ".join(texts)


def _moving_locked(leg: Leg, trial: Trial) -> list[Problem]:
    """Joints listed as locked whose angles change."""
    problems = []
    for name in trial.locked:
        angle = trial.angles[:, leg.joint_names.index(name)]
        low, high = np.nanquantile(angle, RANGE_SHARES)
        if high - low > LOCKED_RANGE:
            text = f"{name} is listed as locked, but its angle changes by {np.degrees(high - low):.3g} deg. List the "
            text += "joints that were held in this trial, or leave the trial out"
            problems.append(Problem(text, file=trial.name, key="locked"))
    return problems


def _servo_torque(leg: Leg, signals: ServoSignals, smoothed: Smoothed, conditions: Conditions) -> Array:
    """(k, n) N m on q of the leg's servos along a motion."""
    servos = [joint.drive if isinstance(joint.drive, Servo) else None for joint in leg.joints]
    delay = np.array([0.0 if servo is None else servo.delay for servo in servos])
    command, supply, enabled = signals.at(smoothed.time, delay)
    torque = np.zeros_like(smoothed.angle)
    starts = held_integrals(leg, conditions.tip, conditions.tilt, smoothed.angle[0], supply[0])
    for j, servo in enumerate(servos):
        if servo is not None:
            error, on = command[:, j] - smoothed.angle[:, j], enabled[:, j]
            integral = integral_along(smoothed.time, error, on, np.array(servo.numbers), starts[j])
            torque[:, j] = servo.torque(error, smoothed.rate[:, j], supply[:, j], on, integral)
    return torque


def _unmoved_joints(leg: Leg, made: Sequence[Recording], sought: Sequence[str] | None) -> list[Problem]:
    problems = []
    for j, name in enumerate(leg.joint_names):
        if sought is not None and name not in sought:
            continue
        free = [r for r in made if j in r.free]
        if not free:
            text = "locked in every trial: its spring and damper cannot be estimated"
            problems.append(Problem(text, key=name))
            continue
        motion = max(float(np.ptp(r.smoothed.angle[:, j])) for r in free)
        if motion < LEAST_MOTION:
            text = f"never moves by more than {np.degrees(motion):.2g} deg in any trial; its spring and damper cannot"
            text += " be estimated. Add a trial in which it moves, or list it under `locked`"
            problems.append(Problem(text, key=name))
    return problems


def sentences_on_reading(recordings: Sequence[Recording]) -> tuple[str, ...]:
    """Messages on recordings with angles that may be degrees or jump by whole turns, or with needless samples."""
    doubts = [_unit_doubt(name, recordings) for name in dict(pair for each in recordings for pair in each.unusual)]
    notes = [
        noted(f"{recording.name}: {text}")
        for recording in recordings
        for text in (recording.unwrapped, recording.thinning)
        if text
    ]
    return (*doubts, *notes)


def _unit_doubt(joint: str, recordings: Sequence[Recording]) -> str:
    """The sentence on angles of a joint that are wide for radians."""
    wide = {each.name: dict(each.unusual)[joint] for each in recordings if joint in dict(each.unusual)}
    name = max(wide, key=wide.__getitem__)
    more = f" and of {len(wide) - 1} more" if len(wide) > 1 else ""
    text = (
        f"{joint}: the angles of {name}{more}, in radians, cover {np.degrees(wide[name]):.0f} deg, more than the joint "
    )
    text += "is known to do. If the numbers are degrees, all that is estimated from them is wrong."
    remedy = (
        f"Are these radians? In a file write {joint} [deg] for degrees, in code numpy.radians(...). If the joint turns "
    )
    return decisive(text, f"{remedy}so far, give it a range in the leg.")


def relative_amplitudes(recordings: Sequence[Recording]) -> Array:
    """(n_trial, n) each joint's amplitude in a trial over its mean; at least 0.2."""
    amplitude = np.array([np.ptp(r.smoothed.angle, axis=0) for r in recordings])
    # A fifth: a joint that hardly moves would otherwise have an unlimited weight.
    return np.asarray(np.maximum(amplitude / np.maximum(amplitude.mean(axis=0), 1e-6), 0.2))
