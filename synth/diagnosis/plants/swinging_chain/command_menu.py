"""Command trajectories for a servo-driven leg's next trial, within the limits of its earlier trials.

The best command depends on the causes to be separated: friction that falls with speed needs slow and fast motion, a
current limit a hard step, a dead band small steps about one angle, a share of the load the same motion with and against
gravity. The menu has one command for each of these, combinations, and a chirp for comparison;
``next_experiment`` weighs them by the predictions of the remaining rivals.
"""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial
from synth.diagnosis.effect_shape import unknown_slices
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.lanes import Block, PredictorCache
from synth.diagnosis.plant import MenuItem
from synth.diagnosis.plants.swinging_chain.command_programme import Programme
from synth.diagnosis.plants.swinging_chain.command_shapes import COMMAND_RATE, Shape, limit_rate, shapes
from synth.diagnosis.plants.swinging_chain.lane_packing import chain_candidates
from synth.diagnosis.workbench import Workbench
from synth.drives.servo import Servo, ServoSignals, integral_along
from synth.files.next_command import JointLimits, NextCommand
from synth.fit.recordings import Recording
from synth.motion.smoothing import Smoothed
from synth.swing.chain import Conditions
from synth.swing.integral_starts import held_integrals
from synth.swing.leg_model import Leg, Tip
from synth.swing.mechanics import rest_pose

LIMIT_PERCENTILE = 98.0  # % of the time, so that a single outlier is no limit
# A first command is held so many s at a time, at most so often, until no joint moves farther than this (rad) in the
# last tenth: a hundredth of the finest counts. What swings on is left swinging, as it would in a recording.
HOLDING, MOST_HOLDS, STILL = 1.0, 4, 1e-6
MOST_SHRINKS, LIMIT_MARGIN = 8, 0.98  # times that a command is made smaller, and the share of a limit aimed at


@dataclass(frozen=True)
class CommandLimits:
    """Limits per joint: ``low``, ``high`` (n,) rad of a command on q; ``speed`` (n,) rad/s and ``torque`` (n,) N m.

    The latter two are of the motion that the designed leg makes of it.
    """

    low: Array
    high: Array
    speed: Array
    torque: Array

    @classmethod
    def of(cls, leg: Leg, trials: Sequence[AngleTrial], wanted: NextCommand) -> CommandLimits:
        """As the project states them, else as wide and as fast as the commands so far; within the joints' ranges."""
        recorded = [trial.recording.signals for trial in trials]
        known = [signals for signals in recorded if signals is not None]
        low = np.min([signals.command.min(axis=0) for signals in known], axis=0)
        high = np.max([signals.command.max(axis=0) for signals in known], axis=0)
        moved = [np.percentile(np.abs(trial.recording.smoothed.rate), LIMIT_PERCENTILE, axis=0) for trial in trials]
        speed = np.max([*moved, *(_fastest_command(signals) for signals in known)], axis=0)
        speed = np.maximum(speed, (high - low) / wanted.length)
        torque = np.full(len(low), np.inf)
        for j, joint in enumerate(leg.joints):
            stated = wanted.limits.get(joint.name, JointLimits())
            ends = np.sort(leg.to_measured(np.stack([low, high]))[:, j])
            measured = np.zeros((2, len(low)))
            measured[0, j] = ends[0] if stated.lowest is None else stated.lowest
            measured[1, j] = ends[1] if stated.highest is None else stated.highest
            low[j], high[j] = np.sort(leg.to_rotation(measured)[:, j])
            if joint.ends is not None:
                low[j], high[j] = max(low[j], joint.ends[0]), min(high[j], joint.ends[1])
            speed[j] = stated.speed if stated.speed is not None else speed[j]
            torque[j] = np.inf if stated.torque is None else stated.torque
        return cls(low, high, speed, torque)

    @property
    def middle(self) -> Array:
        """(n,) rad."""
        return 0.5 * (self.low + self.high)

    def command(self, shape: Array) -> Array:
        """(m, n) rad of shapes (m, n) between -1 and 1."""
        return np.asarray(self.middle + 0.5 * (self.high - self.low) * np.clip(shape, -1.0, 1.0))

    def shaped(self, shape: Shape, time: Array) -> Array:
        """(m, n) rad: a shape between every joint's limits, as a command no faster than its speed."""
        crossing = np.maximum(self.high - self.low, 1e-9) / np.maximum(self.speed, 1e-9)
        return self.command(np.stack([limit_rate(shape(time, each), 2.0 / each) for each in crossing], axis=1))


def _fastest_command(signals: ServoSignals) -> Array:
    """(n,) rad/s, the largest rate of change of a command apart from jumps; of a held one, from change to change."""
    command = signals.command.copy()
    for j in signals.held:
        told = np.flatnonzero(np.diff(command[:, j], prepend=np.inf) != 0.0)
        command[:, j] = np.interp(signals.time, signals.time[told], command[told, j])
    rate = np.abs(np.diff(command, axis=0)) / np.diff(signals.time)[:, None]
    return np.asarray(np.percentile(rate, LIMIT_PERCENTILE, axis=0))


def has_servo(leg: Leg, trials: Sequence[AngleTrial]) -> bool:
    """Whether a joint of the leg follows commands, and some trial records them."""
    return any(follows_command(leg, trial) for trial in trials)


@dataclass(frozen=True)
class CommandMenu:
    """Commands for a servo-driven ``leg``; all driven joints follow theirs together, each within its own limits.

    ``begun`` (n,) rad : the pose in which recordings usually begin.
    """

    leg: Leg
    bench: Workbench
    limits: CommandLimits
    length: float
    begun: Array

    @property
    def time(self) -> Array:
        """(m,) s."""
        return np.arange(0.0, self.length, 1.0 / COMMAND_RATE)

    def usual(self) -> list[MenuItem[AngleTrial]]:
        """One trial per well-known shape, the chirp first."""
        return [self.item(what, self.limits.shaped(shape, self.time)) for what, shape in shapes(self.length).items()]

    def of_programme(self, programme: Programme) -> MenuItem[AngleTrial]:
        """The trial of a programme."""
        made = self.item("steps and ramps found by search", self.limits.command(programme.shape(self.time)))
        return replace(made, source=programme)

    def item(self, what: str, command: Array) -> MenuItem[AngleTrial]:
        """The trial of a command (m, n) rad on q, made so small that the designed leg keeps its limits."""
        leg = self.leg
        passive = [j for j, joint in enumerate(leg.joints) if not isinstance(joint.drive, Servo)]
        command = self.at_rest(command, passive)
        trial = self.imagined(command)
        for _ in range(MOST_SHRINKS):
            over = self.over(trial, command)
            if over <= 1.0:
                break
            command = self.limits.middle + (command - self.limits.middle) * max(LIMIT_MARGIN / over, 0.5)
            command = self.at_rest(command, passive)
            trial = self.imagined(command)
        measured = dict(zip(leg.joint_names, leg.to_measured(command[:1])[0].tolist(), strict=True))
        driven = {name: leg.to_measured(command)[:, j] for j, name in enumerate(leg.joint_names) if j not in passive}
        return MenuItem(what, {"file": "trials/next.csv"}, trial, measured, command=(self.time, driven))

    def at_rest(self, command: Array, passive: Sequence[int]) -> Array:
        """(m, n) rad: the command, with passive joints at rest beside the driven ones' first angles.

        Where nothing pulls a joint to an angle it rests as the recordings begin.
        """
        start = np.where(np.isin(np.arange(len(self.begun)), passive), self.begun, command[0])
        driven = [j for j in range(len(start)) if j not in passive]
        with contextlib.suppress(ArithmeticError):
            start = rest_pose(self.leg, start=start, held=driven)
        made = command.copy()
        made[:, passive] = self.leg.within_travel(start)[passive]
        return made

    def over(self, trial: AngleTrial, command: Array) -> float:
        """Largest speed or torque of the designed leg's motion, over its limit; infinite if it cannot be simulated."""
        n, p = len(self.leg.joints), self.bench.n_tolerance
        block = Block((), np.zeros((p, 1)), np.concatenate([command[0], np.zeros(n)])[None, :, None])
        motion = self.bench.predictor.predict([trial], [block])[0][:, :, 0]
        if not np.all(np.isfinite(motion)):
            return np.inf
        speed = np.gradient(motion, 1.0 / COMMAND_RATE, axis=0)
        worst, supply = 0.0, np.array([j.drive.supply if isinstance(j.drive, Servo) else 1.0 for j in self.leg.joints])
        starts = held_integrals(self.leg, Tip(), 0.0, motion[0], supply)
        for j, joint in enumerate(self.leg.joints):
            if not isinstance(joint.drive, Servo):
                continue
            worst = max(worst, float(np.abs(speed[:, j]).max()) / self.limits.speed[j])
            if np.isfinite(self.limits.torque[j]):
                ahead = command[1:, j] - motion[:-1, j]  # a servo sees a step at once, before the joint moves
                numbers, on = np.array(joint.drive.numbers), np.ones(len(ahead))
                integral = integral_along(self.time[1:], ahead, on, numbers, starts[j])
                torque = joint.drive.torque(ahead, speed[:-1, j], joint.drive.supply, integral=integral)
                worst = max(worst, float(np.abs(torque).max()) / self.limits.torque[j])
        return worst

    def imagined(self, command: Array) -> AngleTrial:
        """A trial without readings that follows ``command`` (m, n) rad on q."""
        return _imagined_command_trial(self.leg, self.bench.noise, self.time, command)


def follows_command(leg: Leg, trial: AngleTrial) -> bool:
    """Whether a servo holds a joint of the trial at a command."""
    driven = any(isinstance(joint.drive, Servo) and joint.drive.gain > 0.0 for joint in leg.joints)
    return driven and trial.recording.signals is not None


def settled_state(bench: Workbench, fit: EvaluatedHypothesis, leg: Leg, trial: AngleTrial) -> Array:
    """(2 n,) rad and rad/s on q of a fit's leg that has held the trial's first command until it rests; nan: diverges.

    A recording of a command begins so. A leg that were released at the command itself would first fall to where servo
    and load balance, and causes that act alike under any command, as one that is late and a reading that is late,
    would differ in that fall alone.
    """
    signals = trial.recording.signals
    assert signals is not None
    n, time = len(leg.joints), HOLDING * np.array([0.0, 0.9, 1.0 - 1.0 / COMMAND_RATE, 1.0])
    # Without the causes that only read otherwise: the state is the leg's own.
    every = chain_candidates(fit.hypothesis)
    moving = [k for k, cause in enumerate(every) if cause.effect.way != "reading"]
    places = unknown_slices(every, bench.n_tolerance)
    unknowns = np.concatenate([fit.unknowns[: bench.n_tolerance], *(fit.unknowns[places[k]] for k in moving)])
    held = _imagined_command_trial(
        leg, trial.recording.smoothed.noise, time, np.tile(signals.command[0], (len(time), 1))
    )
    state, kept = np.concatenate([trial.measured[0], np.zeros(n)]), PredictorCache()
    for _ in range(MOST_HOLDS):
        block = Block(tuple(every[k] for k in moving), unknowns[:, None], state[None, :, None])
        motion = bench.predictor.predict([held], [block], kept)[0][:, :, 0]
        moved = motion[-1] - motion[1:-1]  # over the last tenth, and over the last sample
        state = np.concatenate([motion[-1], moved[-1] / (time[-1] - time[-2])])
        if not np.abs(moved).max() > STILL:
            break
    return state


def _imagined_command_trial(leg: Leg, noise: Array, time: Array, command: Array) -> AngleTrial:
    """A trial without readings that follows ``command`` (m, n) rad on q."""
    n = len(leg.joints)
    start = np.tile(command[0], (len(time), 1))
    smoothed = Smoothed(time, start, np.zeros_like(start), noise, np.zeros(len(time), dtype=bool))
    supply = [joint.drive.supply if isinstance(joint.drive, Servo) else 1.0 for joint in leg.joints]
    holds = [isinstance(joint.drive, Servo) and not joint.drive.linear_commands for joint in leg.joints]
    ones = np.ones((len(time), n))
    signals = ServoSignals(time, command, np.array(supply) * ones, ones, tuple(np.flatnonzero(holds).tolist()))
    counts = np.ones((len(time), n), dtype=bool)
    recording = Recording("next", time, start, counts, Conditions(), smoothed, signals=signals)
    return AngleTrial(recording, time, start, counts, held_out=False)
