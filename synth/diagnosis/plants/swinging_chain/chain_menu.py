"""Possible next trials of a swinging chain, and their prediction by a hypothesis."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping, Sequence

import numpy as np

from synth.arrays import Array
from synth.diagnosis.angle_trials import AngleTrial
from synth.diagnosis.evaluated_hypothesis import EvaluatedHypothesis
from synth.diagnosis.lanes import PredictorCache
from synth.diagnosis.plant import MenuItem
from synth.diagnosis.plants.swinging_chain.command_menu import (
    CommandLimits,
    CommandMenu,
    follows_command,
    has_servo,
    settled_state,
)
from synth.diagnosis.plants.swinging_chain.command_programme import Programme
from synth.diagnosis.workbench import Workbench
from synth.drives.servo import Servo, ServoSignals, TorqueDrive
from synth.estimation.information import TrialForecast
from synth.files.next_command import NextCommand
from synth.fit.recordings import Recording
from synth.motion.smoothing import Smoothed
from synth.swing.chain import Conditions
from synth.swing.leg_model import Joint, Leg
from synth.swing.mechanics import coefficients, rest_pose, static_torque
from synth.units import significant, write

TRIAL_LENGTH, TRIAL_RATE = 3.0, 100.0  # s and samples per second of an imagined trial
RAMP_SHARE = 0.7  # of the way from rest to the widest release so far: the ramp stays within the observed range
COMMANDS_DRAWN, COMMANDS_VARIED = 24, 12  # commands of the first round of a search, and of each later one
TILT_ANGLE = np.radians(30.0)  # rad, of the base in a suggested trial


def menu(
    leg: Leg, bench: Workbench, trials: Sequence[AngleTrial], wanted: NextCommand | None = None
) -> list[MenuItem[AngleTrial]]:
    """Releases of other sizes and sides, locked joints, a tip mass, a tilted base, a slow torque ramp.

    Drives are off in them, with open windings, but for a ramp's: a short-circuited motor brakes by its constant.
    For a servo-driven leg: commands to follow, within the limits ``wanted``.
    """
    if has_servo(leg, trials):
        return _command_menu(leg, bench, trials, wanted or NextCommand()).usual()
    usual = [trial for trial in trials if not trial.recording.conditions.locked] or list(trials)
    starts = np.array([trial.recording.smoothed.angle[0] for trial in usual])
    ends = np.array([trial.recording.smoothed.angle[-1] for trial in usual])
    rest = np.median(ends, axis=0)
    widest = starts[int(np.argmax(np.abs(starts - rest).sum(axis=1)))]
    away, plain, names = widest - rest, Conditions(), leg.joint_names

    def item(
        what: str,
        share: float,
        keys: Mapping[str, object],
        conditions: Conditions,
        ramp: tuple[int, float] | None = None,
    ) -> MenuItem[AngleTrial]:
        release = leg.within_travel(rest + share * away)
        angles = dict(zip(leg.joint_names, leg.to_measured(release).tolist(), strict=True))
        torque = None if ramp is None else (leg.joint_names[ramp[0]], ramp[1], TRIAL_LENGTH)
        off = [k for k, joint in enumerate(leg.joints) if joint.drive is not None and (ramp is None or k != ramp[0])]
        servos = [names[k] for k in off if isinstance(leg.joints[k].drive, Servo)]
        entry = {"file": "trials/next.csv", **keys, **({"drive_off": servos} if servos else {})}
        trial = _imagined_release(leg, bench.noise, release, conditions, ramp)
        return MenuItem(what, entry, trial, angles, torque, state=_off_text([names[k] for k in off]))

    made = [
        item("a release of one third of the amplitude", 0.33, {}, plain),
        item("a release of the largest amplitude so far", 1.0, {}, plain),
        item("a release of 1.5 times the largest amplitude so far", 1.5, {}, plain),
        item("a release from the other side", -1.0, {}, plain),
    ]
    n = len(leg.joints)
    tip = 0.5 * leg.joints[-1].link.mass
    added = {"tip_mass": write(float(f"{tip:.3g}"), "kg")}
    made += [
        item(f"a mass of {significant(tip * 1e3, 3)} g at the tip", 1.0, added, Conditions((), tip)),
        item("the base tilted by 30 deg", 1.0, {"tilt": "30 deg"}, Conditions((), 0.0, TILT_ANGLE)),
        item("the base tilted by -30 deg", 1.0, {"tilt": "-30 deg"}, Conditions((), 0.0, -TILT_ANGLE)),
    ]
    for j in range(n if n > 1 else 0):
        made.append(item(f"{names[j]} locked", 1.0, {"locked": [names[j]]}, Conditions((j,))))
    for j in range(n if n > 2 else 0):
        others = [k for k in range(n) if k != j]
        held = {"locked": [names[k] for k in others]}
        made.append(item(f"all but {names[j]} locked", 1.0, held, Conditions(tuple(others))))
    for j, joint in enumerate(leg.joints):
        torque = (
            joint.sign * holding_torque(leg, rest, j, RAMP_SHARE * float(away[j])) if joint.spring is not None else 0.0
        )
        if torque:
            made.append(item(_ramp_text(joint, torque), 0.0, {}, plain, (j, torque)))
    return made


def _off_text(names: Sequence[str]) -> str:
    """That the motors of these joints must be off; empty without any."""
    if not names:
        return ""
    some = ", ".join(names[:-1])
    return f"with the {'windings' if some else 'winding'} of {some + ' and ' if some else ''}{names[-1]} open"


def _ramp_text(joint: Joint, torque: float) -> str:
    """A slowly rising ``torque`` (N m, measured sense), told as what the drive of the joint takes."""
    drive = joint.drive
    if isinstance(drive, TorqueDrive) and drive.motor is not None:
        ampere = torque / drive.motor.torque_a_current
        return f"a current of {joint.name} that rises slowly to {ampere:.3g} A in {TRIAL_LENGTH:g} s and is recorded"
    if isinstance(drive, Servo) and drive.open_duty and drive.motor is not None:
        volt = torque / drive.motor.strength
        return f"a voltage on {joint.name} that rises slowly to {volt:.3g} V in {TRIAL_LENGTH:g} s and is recorded"
    return f"a torque on {joint.name} that rises slowly to {torque:.3g} N m in {TRIAL_LENGTH:g} s and is recorded"


def holding_torque(leg: Leg, rest: Array, j: int, away: float) -> float:
    """Torque on q_j (N m) that turns it from the ``rest`` (n,) rad by ``away`` rad, inside its range; 0: it holds none.

    Of springs and gravity of the designed leg, other joints where these then hold them, less what they miss at rest.
    """
    begun, end = leg.within_travel(rest), rest.copy()
    end[j] = leg.within_travel(rest + away * (np.arange(len(rest)) == j))[j]
    with contextlib.suppress(ArithmeticError):  # another joint is held by nothing: it stays
        end = rest_pose(leg, start=end, held=[j])
    gravity = coefficients(leg)

    def torque(pose: Array) -> float:
        held = static_torque(gravity, pose, leg.tilt) + leg.spring_rate * (pose - leg.rest)
        return float(held[j])

    found = torque(end) - torque(begun)
    return found if found * (end[j] - begun[j]) > 0.0 else 0.0


def _command_menu(leg: Leg, bench: Workbench, trials: Sequence[AngleTrial], wanted: NextCommand) -> CommandMenu:
    begun = np.median([trial.recording.smoothed.angle[0] for trial in trials], axis=0)
    return CommandMenu(leg, bench, CommandLimits.of(leg, trials, wanted), wanted.length, begun)


def variations(
    leg: Leg,
    bench: Workbench,
    trials: Sequence[AngleTrial],
    wanted: NextCommand,
    best: Sequence[MenuItem[AngleTrial]],
    number: int,
) -> list[MenuItem[AngleTrial]]:
    """Commands in round ``number`` of a search: drawn at random in the first, later varied from the ``best``."""
    if not has_servo(leg, trials):
        return []
    commands, rng = _command_menu(leg, bench, trials, wanted), np.random.default_rng(number)
    if number == 0:
        return [
            commands.of_programme(Programme.drawn(rng, len(leg.joints), wanted.length)) for _ in range(COMMANDS_DRAWN)
        ]
    programmes = [item.source for item in best if isinstance(item.source, Programme)]
    each = -(-COMMANDS_VARIED // max(len(programmes), 1))
    return [commands.of_programme(programme.varied(rng)) for programme in programmes for _ in range(each)]


def _imagined_release(
    leg: Leg, noise: Array, release: Array, conditions: Conditions, ramp: tuple[int, float] | None
) -> AngleTrial:
    """A trial without readings; ``ramp``: joint and final torque, N m in the measured sense."""
    n = len(release)
    time = np.arange(0.0, TRIAL_LENGTH, 1.0 / TRIAL_RATE)
    held = np.tile(release, (len(time), 1))
    smoothed = Smoothed(time, held, np.zeros_like(held), noise, np.zeros(len(time), dtype=bool))
    counts = np.ones((len(time), n), dtype=bool)
    counts[:, list(conditions.locked)] = False
    known, signals = None, None
    if ramp is not None:
        joint, torque = ramp
        applied, ends, drive = np.zeros((2, n)), np.array([0.0, TRIAL_LENGTH]), leg.joints[joint].drive
        applied[1, joint] = leg.joints[joint].sign * torque
        if isinstance(drive, Servo) and drive.open_duty and drive.motor is not None:
            driven = np.ones((2, 1)) * (np.arange(n) == joint)  # the windings of the others are open
            signals = ServoSignals(ends, np.zeros((2, n)), applied / drive.motor.strength, driven)
        else:
            known = ends, applied
    recording = Recording("next", time, held, counts, conditions, smoothed, known, signals=signals)
    return AngleTrial(recording, time, held, counts, held_out=False)


def forecast(
    leg: Leg, bench: Workbench, fit: EvaluatedHypothesis, trial: AngleTrial, covariance: Array, kept: PredictorCache
) -> TrialForecast | None:
    """Prediction and its uncertainty, whitened by the noise; initial state free. None if it diverges.

    Commands are followed from rest at the first one.
    ``kept`` : one for all trials of the fit.
    """
    state = np.concatenate([trial.measured[0], np.zeros(trial.measured.shape[1])])
    if follows_command(leg, trial):
        state = settled_state(bench, fit, leg, trial)
    # By the unknowns that are not fixed.
    moved = [*bench.predictor.open_tolerances, *range(bench.n_tolerance, len(fit.unknowns))]
    prediction, slopes = bench.slopes(trial, fit, state, moved, kept)
    if not (np.all(np.isfinite(prediction)) and np.all(np.isfinite(slopes))):
        return None
    mean = (prediction / bench.sigma(trial))[trial.counts]
    open_ = np.linalg.cholesky(covariance)[moved]
    return TrialForecast(mean, slopes[:, : len(moved)] @ open_, slopes[:, len(moved) :])
