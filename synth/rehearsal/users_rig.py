"""A user's project as the generator's leg, trials and sensors; unsupported features are reported."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from synth.arrays import Array, Mask
from synth.cache import cache_folder
from synth.compiling.announced import announced
from synth.compiling.compiled import keep_code_of, kept_code
from synth.diagnosis.check.run import UNEXPLAINED_SHARE
from synth.errors import UserError
from synth.fit.recordings import Recording, joints_by_current, recordings
from synth.fit.sensor_noise import estimate_sensor
from synth.motion.low_pass import LowPass
from synth.planting import bodies, engine, torque_laws
from synth.planting.model import MOTOR_PARAMETERS, PlantedLeg, PlantedTrial, Truth
from synth.planting.setup import LONGEST_LAG, Setup, as_built
from synth.planting.simulation import fastest, release
from synth.rehearsal.servo_columns import DriveInputs, drive_inputs, planted_servos
from synth.rehearsal.stated_laws import stated_laws
from synth.swing.damper_curves import torque_at
from synth.swing.leg_model import Joint
from synth.swing.leg_model import Leg as OurLeg

if TYPE_CHECKING:
    from synth.files.gap_project import GapProject
    from synth.files.trial_list import Trial

keep_code_of(bodies, torque_laws, engine)  # before any of their functions is called

BACKGROUND_SHARE = UNEXPLAINED_SHARE  # share of each joint's motion (RMS) that small causes leave beside a main one
LEAST_COUNT_SHARE = 0.1  # of the noise: a smaller step is the file's last digit
FIRST_MOTION = 1e-3  # s, of the motion for which the engine is loaded
TYPICAL_SPEED_SHARE = 0.5  # of the largest speed, at which a measured damper's rate is taken


@dataclass(frozen=True)
class Rig:
    """A user's rig for the generator.

    ``nominal`` : the designed leg; ``widths`` (9, n) tolerances; ``noise`` (n,) rad and ``counts`` (n,) per turn
    (infinite: not visible); ``background`` rad RMS of small causes; ``names`` and ``times`` of the trials,
    ``missing`` (m, n) True where a sample is missing; ``left_out`` trials with their reasons; ``filters`` (n,) what the
    noise goes through, None: it is independent.
    """

    nominal: PlantedLeg
    trials: tuple[PlantedTrial, ...]
    names: tuple[str, ...]
    times: tuple[Array, ...]
    missing: tuple[Mask, ...]
    widths: Array
    noise: Array
    counts: Array
    background: float
    left_out: tuple[str, ...]
    inputs: tuple[DriveInputs | None, ...] = ()  # of each trial's servos
    filters: tuple[LowPass | None, ...] = ()

    def unit_noise(self, rng: np.random.Generator, missing: Mask) -> Array:
        """(m, n) noise of deviation 1 of a trial's samples; filters ran over those that are not ``missing`` (m, n)."""
        white = rng.standard_normal(missing.shape)
        for j, one in enumerate(self.filters):
            if one is not None:
                kept = ~missing[:, j]
                white[kept, j] = one.noise(int(kept.sum()), rng)
        return white

    def built(self, rng: np.random.Generator) -> Setup:
        """The rig with a leg drawn within the tolerances."""
        true = as_built(rng, self.nominal, self.widths)
        quick = max(fastest(Truth(true), trial) for trial in self.trials)
        sampling = float(np.median([(len(t) - 1) / t[-1] for t in self.times]))
        setup = Setup(
            nominal=self.nominal,
            true=true,
            trials=self.trials,
            ranges=False,
            noise=self.noise,
            counts=self.counts,
            sampling=sampling,
            missing=0.0,
            settle=quick,
            own_times=self.times,
            widths=self.widths,
            keeps_sensor=True,
        )
        own = [np.sqrt(k / true.outboard(j)) for j, k in enumerate(true.of("spring")) if k > 0.0]
        slowest = min(own) if own else 1.0 / max(float(t[-1]) for t in self.times)
        return replace(setup, longest_lag=float(max(LONGEST_LAG, 0.5 / slowest)))


def load_engine(rig: Rig) -> None:
    """Load the generator's engine; where it must be compiled, that is announced."""
    shortest = min(rig.trials, key=lambda trial: trial.duration)._replace(duration=FIRST_MOTION)

    def move() -> None:
        with suppress(ArithmeticError):  # only its code is wanted
            release(Truth(rig.nominal), shortest, FIRST_MOTION / 10.0)

    if kept_code(engine.__name__):
        return move()
    # Measured on two cores beside other work: 20 s of processor, 220 s of clock.
    text = "compiling the engine that simulates the planted causes"
    with announced(f"{text} (once on this machine, 20 to 200 s; stored in {cache_folder()})"):
        return move()


def users_rig(project: GapProject) -> Rig:
    """The project's leg, trials, noise, counts and tolerances.

    Raises
    ------
    UserError : the generator's engine has no equations for the leg, or there is no trial to score.
    """
    leg = project.leg
    kept = [trial for trial in project.trials if trial.leg is None]
    left_out = [f"{t.name}: has its own leg, which a rehearsal does not support" for t in project.trials if t.leg]
    if all(trial.held_out for trial in kept):
        raise UserError("no trial remains for a rehearsal: all have their own leg or are held out")
    made = recordings(leg, kept, ())
    found = estimate_sensor([r for r, t in zip(made, kept, strict=True) if not t.held_out])
    fastest_seen = np.max([np.abs(r.smoothed.rate).max(axis=0) for r in made], axis=0)
    motion = [np.std(r.smoothed.angle[:, r.free], axis=0) for r in made if r.free]
    counts = np.full(len(leg.joints), np.inf)
    coarse = found.step > LEAST_COUNT_SHARE * found.noise
    counts[coarse] = 2.0 * np.pi / found.step[coarse]
    inputs = [_servo_inputs(project, t, r) for r, t in zip(made, kept, strict=True)]
    rounding = np.where(coarse, found.step, 0.0) / np.sqrt(12.0)
    # Noise beside the rounding: at least a twentieth of both, which the rounding hides.
    noise = np.sqrt(np.maximum(found.noise**2 - rounding**2, (0.05 * found.noise) ** 2))
    told = found.stated(leg.joint_names, project.noise)
    noise[list(told.known)] = told.noise[list(told.known)]
    by_current = joints_by_current(made)
    return Rig(
        _nominal_leg(leg, fastest_seen, by_current),
        tuple(
            _planted_trial(leg, r, held_out=t.held_out, own=own) for r, t, own in zip(made, kept, inputs, strict=True)
        ),
        tuple(trial.name for trial in kept),
        tuple(r.time for r in made),
        tuple(np.logical_not(r.counts) for r in made),
        project.tolerance.widths(leg, by_current),
        noise,
        counts,
        BACKGROUND_SHARE * float(np.sqrt(np.mean(np.concatenate(motion) ** 2))),
        tuple(left_out),
        tuple(inputs),
        found.filters,
    )


def _servo_inputs(project: GapProject, trial: Trial, recording: Recording) -> DriveInputs | None:
    """Inputs of a trial's servos, on the recording's clock."""
    if trial.signals is None or recording.signals is None:
        return None
    start = float(trial.signals.time[0] - recording.signals.time[0])
    return drive_inputs(project.path.parent, trial, project.leg, start)


def _nominal_leg(leg: OurLeg, fastest_seen: Array, by_current: Sequence[int]) -> PlantedLeg:
    """The generator's leg, with rows in the order of ``planting.model.ROWS``."""
    rates, curves = [], []
    for j, joint in enumerate(leg.joints):
        rate, curve = _damper_rate_and_curve(joint, TYPICAL_SPEED_SHARE * float(fastest_seen[j]))
        rates.append(rate)
        if curve is not None:
            curves.append((j, curve))
    links = [joint.link for joint in leg.joints]
    values = np.array(
        [
            [link.length for link in links],
            [link.mass for link in links],
            [link.com for link in links],
            [link.inertia for link in links],
            leg.spring_rate,
            rates,
            leg.rest,
        ]
    )
    servos = planted_servos(leg)
    if servos or by_current:
        values = np.vstack([values, np.ones((len(MOTOR_PARAMETERS), len(leg.joints)))])
    own = leg.joint_names, leg.zero, leg.sign, leg.tilt, values, leg.gravity
    across = np.array([link.com_across for link in links])
    return PlantedLeg(*own, tuple(curves), leg.armature, servos, tuple(by_current), stated_laws(leg), across)


def _damper_rate_and_curve(joint: Joint, speed: float) -> tuple[float, Array | None]:
    """N m s/rad, and the curve if there is one: rows of speed and torque from (0, 0)."""
    damper = joint.damper
    if damper is None:
        return 0.0, None
    if damper.curve is None:
        return damper.rate or 0.0, None
    rows = np.vstack([[0.0, 0.0], np.column_stack([damper.curve.speed, damper.curve.torque])])
    speed = max(speed, 1e-6)  # rad/s: no motion
    return float(torque_at(damper.curve, np.array([speed]))[0]) / speed, rows


def _planted_trial(leg: OurLeg, recording: Recording, *, held_out: bool, own: DriveInputs | None) -> PlantedTrial:
    """One trial from the pose and speed at its start."""
    smoothed, conditions = recording.smoothed, recording.conditions
    known = recording.known_torque
    return PlantedTrial(
        pose=smoothed.angle[0].copy(),
        duration=float(recording.time[-1]),
        tip_mass=conditions.tip_mass,
        locked=tuple(conditions.locked),
        tilt=conditions.tilt,
        held_out=held_out,
        known=None if known is None else (np.asarray(known[0]), np.asarray(known[1])),
        speed=smoothed.rate[0].copy(),
        tip_inertia=conditions.tip_inertia,
        tip_at=conditions.tip_at,
        inputs=None if own is None else own.planted(leg),
    )
