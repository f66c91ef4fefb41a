"""Recordings prepared for the fit: selected time range, noise, and the weight of each sample."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from synth.arrays import Array
from synth.errors import Problem, UserError
from synth.files.hopper_gap_project import PULL_UP, HopperGapProject, JumpTrial
from synth.files.hopper_recordings import LEAST_SAMPLES, HopperRecording
from synth.hopper.current_zero import current_before
from synth.hopper.measured_jump import (
    MeasuredJump,
    measure,
    refuse_other_crouch,
    refuse_out_of_reach,
    refuse_still,
)
from synth.hopper.motors import motor_of
from synth.hopper.plate_zero import without_plate_zero
from synth.hopper.switch_on import from_switch_on, noise_of
from synth.jump.hopper_leg import HopperLeg, Motor
from synth.jump.jump_lanes import JumpLanes
from synth.jump.jump_models import MODELS, columns
from synth.parts.catalogs import Catalogue
from synth.remarks import decisive, noted
from synth.units import factor

EFFECTIVE_SAMPLES = 50.0  # samples per trial and channel that count as independent
DENSE_STEP = 1e-3  # s; faster recordings are averaged
TIME_AFTER_PUSH = 0.01  # s after the push that still count
STOP_MARGIN = np.radians(2.5)  # a pull-up that begins nearer to the stop may rest on it
ANGLE, FORCE, CURRENT = "upper link", "ground force", "current"
UNITS = {ANGLE: "deg", FORCE: "N", CURRENT: "A", "supply": "V", "pitch": "deg", "foot slide": "mm"}  # as written
# Model error in addition to noise: share of a channel's largest value that our models do not resolve.
MODEL_ERROR_SHARE = {ANGLE: 0.0, FORCE: 0.03, CURRENT: 0.01, "supply": 0.002, "pitch": 0.05, "foot slide": 0.1}
JITTER = 5e-5  # s, timing error of the samples, which matters where a channel is steep
# Smoothed friction lets the foot creep: smaller slides and pitches are not resolved.
LEAST_NOISE = {ANGLE: 2e-4, FORCE: 1e-3, CURRENT: 1e-3, "supply": 1e-3, "pitch": 2e-3, "foot slide": 5e-4}


@dataclass(frozen=True, eq=False)
class Jump:
    """One trial as used by the search.

    ``time`` (m,) s and ``measured`` channel -> (m,) SI, in the selected range; ``sigma`` channel -> (m,) uncertainty of
    a sample from noise, ``MODEL_ERROR_SHARE`` and ``JITTER``; ``noise`` the noise alone. ``jumps`` : one lane of
    the nominal leg under the trial's conditions. ``group`` : index of its motor's tolerances. ``torque`` : a pull-up's,
    over all of ``time``. ``seen`` : takeoff and rise from the recording; None for a pull-up, or if the leg does not
    lift off. ``time`` counts from the switch-on; ``start_deviation`` s: of one that was found in the recording, 0 where
    its clock begins there.
    """

    trial: JumpTrial
    leg: HopperLeg
    motor: Motor
    time: Array
    measured: Mapping[str, Array]
    sigma: Mapping[str, Array]
    noise: Mapping[str, float]
    jumps: JumpLanes
    group: int
    slip_speed: float
    torque: Array | None = None
    seen: MeasuredJump | None = None
    start_deviation: float = 0.0
    notes: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """The file."""
        return self.trial.name

    @property
    def leaning(self) -> bool:
        """Whether the planar form is needed."""
        return self.trial.lean != 0.0

    def upright(self) -> Jump:
        """The same jump without lean, and without the channels that only a lean moves."""
        measured = {name: values for name, values in self.measured.items() if name not in ("pitch", "foot slide")}
        return replace(self, trial=replace(self.trial, lean=0.0), measured=measured)

    @property
    def weight(self) -> float:
        """Weight of each sample's squared error."""
        return min(1.0, EFFECTIVE_SAMPLES / len(self.time))


def prepare_jumps(project: HopperGapProject, catalogue: Catalogue) -> tuple[list[Jump], list[str]]:
    """All trials without copies, and warnings.

    Raises
    ------
    UserError : an unknown motor, an impossible leg, or a trial without motion.
    """
    groups: dict[str, int] = {}
    found: list[Jump] = []
    said: list[str] = []
    problems: list[Problem] = []
    for trial in project.trials:
        twin = next((f.name for f in found if _is_copy(f.trial, trial)), None)
        if twin is not None:
            said.append(noted(f"{trial.name} is a copy of {twin} and is left out"))
            continue
        try:
            found.append(_prepare_jump(project, trial, catalogue, groups))
        except UserError as error:
            problems += [p if p.file else replace(p, file=trial.name) for p in error.problems]
    if problems:
        raise UserError(problems)
    said += [noted(note) for jump in found for note in jump.notes]
    said += [text for jump in found if jump.seen is not None and (text := jump.seen.sentence())]
    given = [jump for jump in found if not jump.trial.held_out]
    if len(given) == 1:
        text = "only one training trial: an effect and the peculiarities of this trial cannot be separated"
        said.append(decisive(text))
    if all(jump.trial.kind == "pull-up" for jump in given):
        said.append("pull-ups only: they show the joints' damping, but not motor, gear or ground")
    if not any(jump.leaning for jump in given):
        text = "no training trial leans, and upright jumps do not show whether the foot slides. A jump that "
        said.append(text + "starts leaning (lean: 10 deg), with columns pitch and foot slide, shows it")
    return found, said


def _is_copy(one: JumpTrial, other: JumpTrial) -> bool:
    a, b = one.columns[ANGLE], other.columns[ANGLE]
    return one.kind == other.kind and a.shape == b.shape and bool(np.array_equal(a, b))


def _prepare_jump(project: HopperGapProject, trial: JumpTrial, catalogue: Catalogue, groups: dict[str, int]) -> Jump:
    design = project.design
    row = catalogue.find_motor(trial.motor)
    try:
        motor = motor_of(row, replace(design.motor_options, supply=trial.supply or design.motor_options.supply))
    except ValueError as error:
        raise UserError(f"the motor cannot be simulated: {error}") from None
    leg = design.leg.with_length(trial.length)
    leg = replace(leg, structure_mass=leg.structure_mass + trial.payload)
    wrong = leg.problems()
    if wrong:
        raise UserError(f"with links of {trial.length * 1e3:g} mm {wrong[0]}")
    model = MODELS["A" if design.model == "C" else design.model]
    jumps = columns(leg, motor, design.contact, model, np.array([trial.length]))
    slip = design.contact.slip_speed
    angle = trial.columns[ANGLE]
    refuse_still(trial.name, angle, leg)
    refuse_out_of_reach(trial.name, angle, leg)
    own: tuple[MeasuredJump | None, float, tuple[str, ...]] = (None, 0.0, ())
    if trial.kind == "pull-up":
        _refuse_out_of_reach(trial, leg)
        recorded = _average_dense_samples(_before_the_stop(trial, leg))
        measured = {ANGLE: recorded[ANGLE]}
        torque = recorded[PULL_UP]
    else:
        mass = float(jumps.total_mass[0])
        weight = mass * leg.gravity
        weighed, zero = without_plate_zero(HopperRecording(trial.name, trial.columns, begins=trial.begins), weight)
        timed, begun = from_switch_on(weighed, weight)
        idle = current_before(weighed, begun.time)
        timed = idle.subtracted(timed) if idle.value else timed
        refuse_other_crouch(timed, leg)
        told = f"{trial.name}: {idle.sentence}" if idle.value else ""
        notes = tuple(text for text in (begun.sentence(trial.name), zero.sentence(trial.name), told) if text)
        own = (_jump_by_plate(timed, mass, leg.gravity, zero.deviation), begun.deviation, notes)
        last = _end_of_push(timed)
        stretch = {name: values[timed["time"] <= last] for name, values in timed.columns.items()}
        recorded = _average_dense_samples(stretch)
        measured = {
            name: recorded[name] for name in MODEL_ERROR_SHARE if name in recorded and (name != "pitch" or trial.lean)
        }
        torque = None
    noise = {name: max(noise_of(values), LEAST_NOISE[name]) for name, values in measured.items()}
    sigma = {name: sample_deviation(recorded["time"], v, noise[name], name) for name, v in measured.items()}
    group = groups.setdefault(trial.motor, len(groups))
    return Jump(trial, leg, motor, recorded["time"], measured, sigma, noise, jumps, group, slip, torque, *own)


def _before_the_stop(trial: JumpTrial, leg: HopperLeg) -> dict[str, Array]:
    """A pull-up until the leg approaches its stop; the bounce there is sensitive to small errors."""
    near = trial.columns[ANGLE] < leg.extended + STOP_MARGIN
    last = int(np.argmax(near)) if near.any() else len(near)
    if last < LEAST_SAMPLES:
        text = f"begins {np.degrees(STOP_MARGIN):.1f} deg or less from the stop at {np.degrees(leg.extended):.1f} deg"
        raise UserError(Problem(f"{text}; fold the leg a little before the recording begins", trial.name, key=ANGLE))
    return {name: values[:last] for name, values in trial.columns.items()}


def _refuse_out_of_reach(trial: JumpTrial, leg: HopperLeg) -> None:
    most = np.degrees(0.99 * leg.largest_crouch)
    low, high = np.degrees(trial.columns[ANGLE].min()), np.degrees(trial.columns[ANGLE].max())
    # Deg; nearly straight and nearly locked, as in ``identify_damping``.
    if low < 1.2 or high > most:
        text = f"the angle runs from {low:.1f} to {high:.1f} deg; links of {leg.length * 1e3:g} mm fold from 1.2 to "
        raise UserError(Problem(f"{text}{most:.1f} deg", trial.name, key=ANGLE))


def _jump_by_plate(jump: HopperRecording, mass: float, gravity: float, zero_deviation: float) -> MeasuredJump | None:
    """Takeoff and rise from the force plate; empty without one. The motion shows whether the leg lifts off."""
    if FORCE not in jump.columns:
        return None
    try:
        return measure(jump, mass, gravity, zero_deviation=zero_deviation)
    except UserError:
        return None


def _end_of_push(jump: HopperRecording) -> float:
    """A little after the upper link's largest speed, which ends at the leg's stop; s.

    Later motion is sensitive to small errors: whether a weak jump lifts off, how a landing oscillates.
    """
    time, angle = jump["time"], jump[ANGLE]
    width = max(1, round(0.004 / float(np.median(np.diff(time)))))  # 4 ms: above the noise of an encoder, below a push
    rate = (angle[2 * width :] - angle[: -2 * width]) / (time[2 * width :] - time[: -2 * width])
    return float(time[width + int(np.argmin(rate))]) + TIME_AFTER_PUSH


def _average_dense_samples(columns: Mapping[str, Array]) -> dict[str, Array]:
    """Samples finer than ``DENSE_STEP``, averaged in groups."""
    time = columns["time"]
    size = max(1, round(DENSE_STEP / float(np.median(np.diff(time)))))
    whole = len(time) // size * size
    return {name: values[:whole].reshape(-1, size).mean(axis=1) for name, values in columns.items()}


def sample_deviation(time: Array, values: Array, noise: float, channel: str) -> Array:
    """(m,) standard deviation of each sample of a channel."""
    claim = MODEL_ERROR_SHARE[channel] * float(np.abs(values).max())
    return np.asarray(np.sqrt(noise**2 + claim**2 + (JITTER * np.gradient(values, time)) ** 2))


def pooled_noise(jumps: Sequence[Jump], channel: str) -> float:
    """Noise of a channel over trials, RMS; 0 if no trial has it."""
    found = [jump.noise[channel] ** 2 for jump in jumps if channel in jump.noise]
    return float(np.sqrt(np.mean(found))) if found else 0.0


def factor_of(channel: str) -> float:
    """SI value of one unit of those in which a channel is written."""
    return factor(UNITS[channel], {"deg": "rad", "mm": "m"}.get(UNITS[channel], UNITS[channel]))
